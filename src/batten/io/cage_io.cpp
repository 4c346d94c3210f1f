#include "batten/io/cage_io.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten {

namespace {

/// The edges of the faces, to see whether two vertices are joined.
class FaceEdges {
 public:
  explicit FaceEdges(const PolygonMesh& mesh) {
    for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
      const int begin = mesh.offsets[f], end = mesh.offsets[f + 1];
      for (int c = begin; c < end; ++c)
        keys_.push_back(key(mesh.corners[static_cast<size_t>(c)],
                            mesh.corners[static_cast<size_t>(c + 1 < end ? c + 1 : begin)]));
    }
    std::sort(keys_.begin(), keys_.end());
  }
  bool contains(int a, int b) const { return std::binary_search(keys_.begin(), keys_.end(), key(a, b)); }

 private:
  static std::uint64_t key(int a, int b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  }
  std::vector<std::uint64_t> keys_;
};

/// One `t` statement: name, the counts of its integers, numbers and words, then these.
struct Tag {
  std::string_view name;
  std::vector<long> integers;
  std::vector<double> numbers;
};

Tag parse_tag(const detail::RawMesh::Tag& raw, const std::string& path) {
  const auto fail = [&](std::string_view problem) { throw FileError(path, raw.line, problem); };
  const std::vector<std::string_view> words = split_blanks(raw.text);
  Tag tag;
  if (words.empty()) return tag;
  tag.name = words[0];
  if (tag.name != "crease" && tag.name != "corner") return tag;
  const std::vector<std::string_view> counts =
      words.size() > 1 ? split_fields(words[1], '/') : std::vector<std::string_view>();
  long n_integers = 0, n_numbers = 0, n_words = 0;
  if (counts.size() < 2 || !parse_integer(counts[0], n_integers) || !parse_integer(counts[1], n_numbers) ||
      (counts.size() > 2 && !parse_integer(counts[2], n_words)) || n_integers < 0 || n_numbers < 0 ||
      n_words < 0)
    fail("the counts of a tag are missing; expected for example 't crease 2/1/0 4 7 2.5'");
  if (static_cast<double>(words.size()) - 2 !=
      static_cast<double>(n_integers) + static_cast<double>(n_numbers) + static_cast<double>(n_words))
    fail(concat("the tag announces ", n_integers, " integers and ", n_numbers, " numbers, but holds ",
                words.size() - 2, " values; correct the counts"));
  for (long k = 0; k < n_integers; ++k) {
    long value = 0;
    if (!parse_integer(words[static_cast<size_t>(2 + k)], value))
      fail("a vertex of a tag is no integer; vertices of tags are counted from 0");
    tag.integers.push_back(value);
  }
  for (long k = 0; k < n_numbers; ++k) {
    double value = 0;
    if (!parse_number(words[static_cast<size_t>(2 + n_integers + k)], value) || std::isnan(value) ||
        value < 0)
      fail("a sharpness is no number of 0 or more");
    tag.numbers.push_back(value);
  }
  return tag;
}

void add_tags(const detail::RawMesh& raw, const FaceEdges& edges, const std::string& path, ControlCage& cage,
              std::vector<std::string>& notes) {
  const long n = static_cast<long>(raw.positions.size() / 3);
  long n_unknown = 0;
  for (const detail::RawMesh::Tag& text : raw.tags) {
    const Tag tag = parse_tag(text, path);
    const auto fail = [&](std::string_view problem) { throw FileError(path, text.line, problem); };
    for (const long v : tag.integers)
      if (v < 0 || v >= n)
        fail(concat("vertex ", v, " of a tag is out of range; the file holds ", n, ", counted from 0"));
    if (tag.name == "crease") {
      const size_t n_edges = tag.integers.size() - std::min<size_t>(tag.integers.size(), 1);
      if (n_edges == 0 || (tag.numbers.size() != 1 && tag.numbers.size() != n_edges))
        fail("a crease needs two vertices or more and one sharpness, or one for each of its edges");
      for (size_t k = 0; k < n_edges; ++k) {
        const int a = static_cast<int>(tag.integers[k]), b = static_cast<int>(tag.integers[k + 1]);
        if (!edges.contains(a, b))
          fail(concat("no face has an edge between vertices ", a, " and ", b, " (counted from 0)"));
        cage.sharp_edges.push_back({a, b, tag.numbers[tag.numbers.size() == 1 ? 0 : k]});
      }
    } else if (tag.name == "corner") {
      if (tag.integers.empty() || (tag.numbers.size() != 1 && tag.numbers.size() != tag.integers.size()))
        fail("a corner needs one vertex or more and one sharpness, or one for each of its vertices");
      for (size_t k = 0; k < tag.integers.size(); ++k)
        cage.sharp_vertices.push_back(
            {static_cast<int>(tag.integers[k]), tag.numbers[tag.numbers.size() == 1 ? 0 : k]});
    } else {
      ++n_unknown;
    }
  }
  if (n_unknown > 0)
    notes.push_back(concat(n_unknown, " subdivision tags other than 'crease' and 'corner' were left out"));
}

/// Cuts the polylines at the vertices of faces; each piece belongs to the edge between its ends.
void add_polylines(const detail::RawMesh& raw, const std::vector<char>& in_face, const FaceEdges& edges,
                   ControlCage& cage, std::vector<std::string>& notes) {
  long n_left_out = 0, first_line = 0;
  for (const detail::RawMesh::Polyline& polyline : raw.polylines) {
    std::vector<int> piece;
    for (const int v : polyline.vertices) {
      piece.push_back(v);
      if (piece.size() < 2 || in_face[static_cast<size_t>(v)] == 0) continue;
      const int a = piece.front();
      if (in_face[static_cast<size_t>(a)] != 0 && edges.contains(a, v)) {
        EdgePolyline curve{a, v, Points(static_cast<Eigen::Index>(piece.size()), 3)};
        for (size_t k = 0; k < piece.size(); ++k)
          for (int axis = 0; axis < 3; ++axis)
            curve.points(static_cast<Eigen::Index>(k), axis) =
                raw.positions[3 * static_cast<size_t>(piece[k]) + static_cast<size_t>(axis)];
        cage.polylines.push_back(std::move(curve));
      } else if (n_left_out++ == 0) {
        first_line = polyline.line;
      }
      piece.assign(1, v);
    }
    if (piece.size() > 1 && n_left_out++ == 0) first_line = polyline.line;
  }
  if (n_left_out > 0)
    notes.push_back(concat(n_left_out,
                           " pieces of polylines do not run along an edge of a face and were left ",
                           "out (the first is on line ", first_line, ")"));
}

/// Leaves out the vertices that no face uses.
void compact(ControlCage& cage, std::vector<char> in_face, const std::vector<char>& in_polyline,
             std::vector<std::string>& notes) {
  long n_dropped = 0;
  std::vector<int> renamed(in_face.size(), -1);
  int n = 0;
  for (size_t v = 0; v < in_face.size(); ++v) {
    if (in_face[v] != 0)
      renamed[v] = n++;
    else
      n_dropped += in_polyline[v] == 0;
  }
  if (static_cast<size_t>(n) == in_face.size()) return;
  if (n_dropped > 0) notes.push_back(concat(n_dropped, " vertices that no face uses were left out"));
  Points kept(n, 3);
  for (size_t v = 0; v < in_face.size(); ++v)
    if (renamed[v] >= 0) kept.row(renamed[v]) = cage.mesh.positions.row(static_cast<Eigen::Index>(v));
  cage.mesh.positions = std::move(kept);
  for (int& v : cage.mesh.corners) v = renamed[static_cast<size_t>(v)];
  for (SharpEdge& edge : cage.sharp_edges) {
    edge.from = renamed[static_cast<size_t>(edge.from)];
    edge.to = renamed[static_cast<size_t>(edge.to)];
  }
  std::vector<SharpVertex> corners;
  for (const SharpVertex& corner : cage.sharp_vertices)
    if (renamed[static_cast<size_t>(corner.vertex)] >= 0)
      corners.push_back({renamed[static_cast<size_t>(corner.vertex)], corner.sharpness});
  cage.sharp_vertices = std::move(corners);
  for (EdgePolyline& polyline : cage.polylines) {
    polyline.from = renamed[static_cast<size_t>(polyline.from)];
    polyline.to = renamed[static_cast<size_t>(polyline.to)];
  }
}

void check_indices(const ControlCage& cage, const Points& normals) {
  const PolygonMesh& mesh = cage.mesh;
  const auto n = mesh.positions.rows();
  const auto check = [n](int v, std::string_view what) {
    if (v < 0 || v >= n) throw InvalidInput(concat(what, " names vertex ", v, ", but there are ", n));
  };
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f)
    for (int c = mesh.offsets[static_cast<size_t>(f)]; c < mesh.offsets[static_cast<size_t>(f) + 1]; ++c)
      check(mesh.corners[static_cast<size_t>(c)], concat("face ", f));
  for (const SharpEdge& edge : cage.sharp_edges) {
    check(edge.from, "a sharp edge");
    check(edge.to, "a sharp edge");
  }
  for (const SharpVertex& corner : cage.sharp_vertices) check(corner.vertex, "a sharp vertex");
  for (const EdgePolyline& polyline : cage.polylines) {
    check(polyline.from, "a polyline");
    check(polyline.to, "a polyline");
  }
  if (normals.rows() != 0 && normals.rows() != n)
    throw InvalidInput(concat("the cage has ", normals.rows(), " normals for ", n, " vertices"));
}

void append_row(std::string& text, const Points& rows, Eigen::Index row) {
  for (int k = 0; k < 3; ++k) {
    text += ' ';
    text += exact_decimal(rows(row, k));
  }
}

/// Infinity has no place in a tag: OpenSubdiv takes 10 and more as infinitely sharp.
std::string sharpness_text(double sharpness) {
  return exact_decimal(std::min(sharpness, 10.0));
}

std::string obj_text(const ControlCage& cage, const Points& normals) {
  const PolygonMesh& mesh = cage.mesh;
  std::string text = "# Batten\n";
  const auto vertex = [&text](const Points& rows, Eigen::Index row, const char* word) {
    append_row(text += word, rows, row);
    text += '\n';
  };
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) vertex(mesh.positions, v, "v");
  Eigen::Index next = mesh.positions.rows();
  std::string lines;
  for (const EdgePolyline& polyline : cage.polylines) {
    lines += concat("l ", polyline.from + 1);
    for (Eigen::Index k = 1; k + 1 < polyline.points.rows(); ++k) {
      vertex(polyline.points, k, "v");
      lines += concat(' ', ++next);
    }
    lines += concat(' ', polyline.to + 1, '\n');
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) vertex(normals, v, "vn");
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
    text += 'f';
    for (int c = mesh.offsets[f]; c < mesh.offsets[f + 1]; ++c) {
      const std::string corner = std::to_string(mesh.corners[static_cast<size_t>(c)] + 1);
      (text += ' ') += corner;
      if (normals.rows() > 0) (text += "//") += corner;
    }
    text += '\n';
  }
  text += lines;
  for (const SharpEdge& edge : cage.sharp_edges)
    text += concat("t crease 2/1/0 ", edge.from, ' ', edge.to, ' ', sharpness_text(edge.sharpness), '\n');
  for (const SharpVertex& corner : cage.sharp_vertices)
    text += concat("t corner 1/1/0 ", corner.vertex, ' ', sharpness_text(corner.sharpness), '\n');
  return text;
}

std::string off_text(const PolygonMesh& mesh, const Points& normals) {
  std::string text =
      concat(normals.rows() > 0 ? "NOFF\n" : "OFF\n", mesh.positions.rows(), ' ', mesh.n_faces(), " 0\n");
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
    append_row(text, mesh.positions, v);
    if (normals.rows() > 0) append_row(text, normals, v);
    text += '\n';
  }
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
    text += std::to_string(mesh.offsets[f + 1] - mesh.offsets[f]);
    for (int c = mesh.offsets[f]; c < mesh.offsets[f + 1]; ++c)
      (text += ' ') += std::to_string(mesh.corners[static_cast<size_t>(c)]);
    text += '\n';
  }
  return text;
}

std::string ply_text(const PolygonMesh& mesh, const Points& normals) {
  int longest = 0;
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f)
    longest = std::max(longest, mesh.offsets[f + 1] - mesh.offsets[f]);
  const bool small = longest < 256;
  std::string text =
      concat("ply\nformat binary_little_endian 1.0\ncomment Batten\nelement vertex ", mesh.positions.rows(),
             "\nproperty double x\nproperty double y\nproperty double z\n");
  if (normals.rows() > 0) text += "property double nx\nproperty double ny\nproperty double nz\n";
  text += concat("element face ", mesh.n_faces(), "\nproperty list ", small ? "uchar" : "int",
                 " int vertex_indices\nend_header\n");
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
    for (int k = 0; k < 3; ++k) detail::append_little_endian(text, mesh.positions(v, k));
    if (normals.rows() > 0)
      for (int k = 0; k < 3; ++k) detail::append_little_endian(text, normals(v, k));
  }
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
    const int n = mesh.offsets[f + 1] - mesh.offsets[f];
    if (small)
      detail::append_little_endian(text, static_cast<std::uint8_t>(n));
    else
      detail::append_little_endian(text, static_cast<std::int32_t>(n));
    for (int c = mesh.offsets[f]; c < mesh.offsets[f + 1]; ++c)
      detail::append_little_endian(text, static_cast<std::int32_t>(mesh.corners[static_cast<size_t>(c)]));
  }
  return text;
}

}  // namespace

ControlCage parse_cage(std::string content, const std::string& path, std::vector<std::string>* warnings) {
  std::vector<std::string> notes;
  detail::RawMesh raw = detail::parse_raw_mesh(std::move(content), path, notes);
  notes.insert(notes.end(), raw.warnings.begin(), raw.warnings.end());
  ControlCage cage;
  cage.mesh = std::move(raw.faces);
  if (cage.mesh.n_faces() == 0) throw FileError(path, 0, "holds no faces, expected a cage of polygons");
  if (raw.n_short_faces > 0)
    notes.push_back(concat(raw.n_short_faces, " faces with fewer than three corners were left out"));
  cage.mesh.positions =
      Eigen::Map<const Points>(raw.positions.data(), static_cast<Eigen::Index>(raw.positions.size() / 3), 3);
  std::vector<char> in_face(raw.positions.size() / 3, 0), in_polyline(in_face.size(), 0);
  for (const int v : cage.mesh.corners) {
    if (v < 0 || static_cast<size_t>(v) >= in_face.size())
      throw FileError(path, 0, concat("a face names vertex ", v, ", but the file holds ", in_face.size()));
    in_face[static_cast<size_t>(v)] = 1;
  }
  for (const detail::RawMesh::Polyline& polyline : raw.polylines)
    for (const int v : polyline.vertices) in_polyline[static_cast<size_t>(v)] = 1;
  const FaceEdges edges(cage.mesh);
  add_tags(raw, edges, path, cage, notes);
  add_polylines(raw, in_face, edges, cage, notes);
  compact(cage, std::move(in_face), in_polyline, notes);
  if (warnings != nullptr) warnings->insert(warnings->end(), notes.begin(), notes.end());
  return cage;
}

ControlCage read_cage(const std::string& path, std::vector<std::string>* warnings) {
  return parse_cage(read_file(path), path, warnings);
}

std::string format_cage(const ControlCage& cage, const std::string& path, const Points& normals) {
  check_indices(cage, normals);
  switch (mesh_format(path)) {
    case MeshFormat::Ply:
      return ply_text(cage.mesh, normals);
    case MeshFormat::Obj:
      return obj_text(cage, normals);
    case MeshFormat::Off:
      return off_text(cage.mesh, normals);
    case MeshFormat::Stl:
    case MeshFormat::Gltf:
    case MeshFormat::ThreeMf:
      break;
  }
  throw FileError(path, 0, "this format holds triangles only; use .ply, .obj or .off for polygons");
}

void write_cage(const std::string& path, const ControlCage& cage, const Points& normals) {
  if (path.size() > 3 && path.compare(path.size() - 3, 3, ".gz") == 0)
    throw FileError(path, 0, "compressed files are read but not written; leave out .gz");
  write_file(path, format_cage(cage, path, normals));
}

}  // namespace batten
