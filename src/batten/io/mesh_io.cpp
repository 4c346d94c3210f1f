#include "batten/io/mesh_io.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten {

namespace detail {

bool Tokens::next(std::string_view& token) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  size_t begin = 0;
  while (begin < rest_.size() && blank(rest_[begin])) ++begin;
  size_t end = begin;
  while (end < rest_.size() && !blank(rest_[end])) ++end;
  token = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return !token.empty();
}

/// Shortened and without control characters, fit to stand in a sentence.
static std::string quoted(std::string_view token) {
  std::string text = "'";
  for (const char c : token.substr(0, 30)) text += static_cast<unsigned char>(c) < 32 ? '?' : c;
  return text + (token.size() > 30 ? "…'" : "'");
}

double read_finite(Tokens& tokens, const LineReader& reader, std::string_view what) {
  std::string_view token;
  if (!tokens.next(token)) reader.fail(concat(what, " is missing; the line has too few numbers"));
  double value = 0;
  if (!parse_number(token, value)) reader.fail(concat(what, " is ", quoted(token), ", expected a number"));
  if (!std::isfinite(value))
    reader.fail(concat(what, " is ", quoted(token), ", which is not finite; remove it"));
  return value;
}

long read_integer(Tokens& tokens, const LineReader& reader, std::string_view what, long low, long high) {
  std::string_view token;
  if (!tokens.next(token)) reader.fail(concat(what, " is missing"));
  long value = 0;
  if (!parse_integer(token, value)) reader.fail(concat(what, " is ", quoted(token), ", expected an integer"));
  if (value < low || value > high) reader.fail(concat(what, " is ", value, ", expected ", low, " to ", high));
  return value;
}

std::string_view without_comment(std::string_view line) {
  return line.substr(0, line.find('#'));
}

void append_row(std::string& text, const Points& rows, Eigen::Index row) {
  for (int k = 0; k < 3; ++k) {
    if (k > 0) text += ' ';
    text += exact_decimal(rows(row, k));
  }
}

bool add_face(RawMesh& mesh, const std::vector<int>& corners) {
  if (corners.size() < 3) {
    ++mesh.n_short_faces;
    return false;
  }
  mesh.faces.corners.insert(mesh.faces.corners.end(), corners.begin(), corners.end());
  mesh.faces.offsets.push_back(static_cast<int>(mesh.faces.corners.size()));
  return true;
}

namespace {

Points to_points(const std::vector<double>& values) {
  return Eigen::Map<const Points>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3);
}

/// Normals of unit length. Rows that are already so keep their bits; rows without a direction are replaced by
/// the area-weighted normal of their triangles.
void finish_normals(TriangleMesh& mesh, std::vector<std::string>& warnings) {
  constexpr double kUnit = 1e-12;  // of the squared length; normals written by us stay as they are
  std::vector<Eigen::Index> missing;
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) {
    const double squared = mesh.normals.row(v).squaredNorm();
    if (!(squared > 0) || !std::isfinite(squared))
      missing.push_back(v);
    else if (std::abs(squared - 1) > kUnit)
      mesh.normals.row(v) /= std::sqrt(squared);
  }
  if (missing.empty()) return;
  std::vector<int> slot(static_cast<size_t>(mesh.n_vertices()), -1);
  for (size_t k = 0; k < missing.size(); ++k) slot[static_cast<size_t>(missing[k])] = static_cast<int>(k);
  Points sums = Points::Zero(static_cast<Eigen::Index>(missing.size()), 3);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::RowVector3d a = mesh.positions.row(mesh.triangles(f, 0));
    const Eigen::RowVector3d b = mesh.positions.row(mesh.triangles(f, 1));
    const Eigen::RowVector3d c = mesh.positions.row(mesh.triangles(f, 2));
    for (int k = 0; k < 3; ++k) {
      const int s = slot[static_cast<size_t>(mesh.triangles(f, k))];
      if (s >= 0) sums.row(s) += (b - a).cross(c - a);
    }
  }
  for (size_t k = 0; k < missing.size(); ++k) {
    const double length = sums.row(static_cast<Eigen::Index>(k)).norm();
    if (length > 0)
      mesh.normals.row(missing[k]) = sums.row(static_cast<Eigen::Index>(k)) / length;
    else
      mesh.normals.row(missing[k]) << 0, 0, 1;  // no triangle to ask: any direction will do
  }
  warnings.push_back(concat("the normals of ", missing.size(), " vertices (the first is vertex ", missing[0],
                            ") have no direction and were taken from the faces"));
}

/// Attributes of polygons to their triangles, which follow each other as the polygons do.
MeshAttributes finished_attributes(RawMesh& raw, const Triangles& triangles) {
  MeshAttributes result = std::move(raw.attributes);
  std::vector<int> polygon_of;
  const PolygonMesh& faces = raw.faces;
  for (size_t f = 0; f + 1 < faces.offsets.size(); ++f)
    polygon_of.insert(polygon_of.end(), static_cast<size_t>(faces.offsets[f + 1] - faces.offsets[f] - 2),
                      static_cast<int>(f));
  for (const std::vector<double>& values : raw.face_values) {
    Eigen::VectorXd of_triangles(triangles.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
      of_triangles(t) = values[static_cast<size_t>(polygon_of[static_cast<size_t>(t)])];
    result.face_values.push_back(std::move(of_triangles));
  }
  for (MeshAttributes::Labels* labels : {&result.objects, &result.groups, &result.materials}) {
    if (labels->words.empty()) labels->of_face.clear();
    if (labels->of_face.empty()) continue;
    std::vector<int> of_face;
    for (const int f : polygon_of) of_face.push_back(labels->of_face[static_cast<size_t>(f)]);
    labels->of_face = std::move(of_face);
  }
  if (raw.texture.empty()) return result;
  result.texture = Eigen::Map<const decltype(result.texture)>(
      raw.texture.data(), static_cast<Eigen::Index>(raw.texture.size() / 2), 2);
  result.texture_corners.setConstant(triangles.rows(), 3, -1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto f = static_cast<size_t>(polygon_of[static_cast<size_t>(t)]);
    for (int k = 0; k < 3; ++k)
      for (int c = faces.offsets[f]; c < faces.offsets[f + 1]; ++c)
        if (faces.corners[static_cast<size_t>(c)] == triangles(t, k))
          result.texture_corners(t, k) = raw.corner_texture[static_cast<size_t>(c)];
  }
  return result;
}

}  // namespace

TriangleMesh finished_mesh(RawMesh&& raw, const std::string& path, std::vector<std::string>* warnings,
                           MeshAttributes* attributes) {
  std::vector<std::string> notes = std::move(raw.warnings);
  if (raw.positions.empty()) throw FileError(path, 0, "holds no vertices, expected a mesh");
  const size_t n_faces = raw.faces.offsets.size() - 1;
  bool all_triangles = true;
  size_t n_polygons = 0;
  for (size_t f = 0; f < n_faces; ++f)
    if (raw.faces.offsets[f + 1] - raw.faces.offsets[f] != 3) {
      all_triangles = false;
      ++n_polygons;
    }
  TriangleMesh mesh;
  if (all_triangles) {
    mesh.positions = to_points(raw.positions);
    mesh.triangles =
        Eigen::Map<const Triangles>(raw.faces.corners.data(), static_cast<Eigen::Index>(n_faces), 3);
  } else {
    raw.faces.positions = to_points(raw.positions);
    try {
      mesh = triangulated(raw.faces);
    } catch (const InvalidInput& problem) {
      throw FileError(path, 0, problem.what());
    }
    notes.push_back(concat(n_polygons, " of ", n_faces,
                           " faces have more than three corners and were split into triangles"));
  }
  if (attributes != nullptr)
    *attributes = finished_attributes(raw, mesh.triangles);
  else if (!raw.texture.empty())
    notes.push_back(concat(raw.texture.size() / 2, " texture coordinates were left out"));
  if (raw.n_short_faces > 0)
    notes.push_back(concat(raw.n_short_faces, " faces with fewer than three corners were left out"));
  if (!raw.polylines.empty())
    notes.push_back(concat(raw.polylines.size(), " polylines beside the faces were left out"));
  if (!raw.tags.empty())
    notes.push_back(
        concat(raw.tags.size(), " subdivision tags ('t') were left out; batten subdivide reads them"));
  if (mesh.n_triangles() == 0) notes.emplace_back("the file holds points without faces");
  if (!raw.normals.empty()) {
    mesh.normals = to_points(raw.normals);
    finish_normals(mesh, notes);
  }
  mesh.vertex_values = std::move(raw.vertex_values);
  if (warnings != nullptr) warnings->insert(warnings->end(), notes.begin(), notes.end());
  return mesh;
}

}  // namespace detail

namespace {

bool format_of_extension(const std::string& extension, MeshFormat& format) {
  if (extension == "ply")
    format = MeshFormat::Ply;
  else if (extension == "obj")
    format = MeshFormat::Obj;
  else if (extension == "off")
    format = MeshFormat::Off;
  else if (extension == "stl")
    format = MeshFormat::Stl;
  else if (extension == "glb" || extension == "gltf")
    format = MeshFormat::Gltf;
  else if (extension == "3mf")
    format = MeshFormat::ThreeMf;
  else
    return false;
  return true;
}

const char* name_of(MeshFormat format) {
  switch (format) {
    case MeshFormat::Ply:
      return "PLY";
    case MeshFormat::Obj:
      return "OBJ";
    case MeshFormat::Off:
      return "OFF";
    case MeshFormat::Stl:
      return "STL";
    case MeshFormat::Gltf:
      return "glTF";
    case MeshFormat::ThreeMf:
      return "3MF";
  }
  return "";
}

bool has_normals(const TriangleMesh& mesh) {
  return mesh.normals.rows() > 0;
}

std::string off_text(const TriangleMesh& mesh) {
  std::string text =
      concat(has_normals(mesh) ? "NOFF\n" : "OFF\n", mesh.n_vertices(), ' ', mesh.n_triangles(), " 0\n");
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    detail::append_row(text, mesh.positions, v);
    if (has_normals(mesh)) detail::append_row(text += ' ', mesh.normals, v);
    text += '\n';
  }
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    text += concat("3 ", mesh.triangles(f, 0), ' ', mesh.triangles(f, 1), ' ', mesh.triangles(f, 2), '\n');
  return text;
}

Eigen::RowVector3d unit_normal(const TriangleMesh& mesh, Eigen::Index f) {
  const Eigen::RowVector3d a = mesh.positions.row(mesh.triangles(f, 0));
  const Eigen::RowVector3d n =
      (mesh.positions.row(mesh.triangles(f, 1)) - a).cross(mesh.positions.row(mesh.triangles(f, 2)) - a);
  const double length = n.norm();
  return length > 0 ? Eigen::RowVector3d(n / length) : Eigen::RowVector3d::Zero();
}

std::string stl_text(const TriangleMesh& mesh, bool ascii) {
  std::string text;
  if (ascii) {
    text = "solid batten\n";
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
      const Points n = unit_normal(mesh, f);
      detail::append_row(text += "facet normal ", n, 0);
      text += "\n outer loop\n";
      for (int k = 0; k < 3; ++k) {
        detail::append_row(text += "  vertex ", mesh.positions, mesh.triangles(f, k));
        text += '\n';
      }
      text += " endloop\nendfacet\n";
    }
    return text + "endsolid batten\n";
  }
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (mesh.n_vertices() > 0 && mesh.positions.cwiseAbs().maxCoeff() > kLargest)
    throw InvalidInput(concat("binary STL holds coordinates up to ", kLargest, ", but the mesh reaches ",
                              mesh.positions.cwiseAbs().maxCoeff(),
                              "; write .ply, .obj or .off, or scale it"));
  text.assign(80, ' ');
  text.replace(0, 6, "Batten");
  detail::append_little_endian(text, static_cast<std::uint32_t>(mesh.n_triangles()));
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::RowVector3d n = unit_normal(mesh, f);
    for (int k = 0; k < 3; ++k) detail::append_little_endian(text, static_cast<float>(n(k)));
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        detail::append_little_endian(text, static_cast<float>(mesh.positions(mesh.triangles(f, k), axis)));
    text += std::string(2, '\0');
  }
  return text;
}

}  // namespace

MeshFormat mesh_format(std::string_view path) {
  MeshFormat format = MeshFormat::Ply;
  if (!format_of_extension(output_extension(path, "ply"), format))
    throw UnknownExtension(path,
                           "is no mesh file by its extension; use .ply, .obj, .off, .stl, .glb or .3mf");
  if (file_extension(path) == "gltf") throw UnknownExtension(path, "is read and not written; use .glb");
  return format;
}

namespace detail {

void check_arrays(const TriangleMesh& mesh) {
  const Eigen::Index n = mesh.n_vertices();
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      if (mesh.triangles(f, k) < 0 || mesh.triangles(f, k) >= n)
        throw InvalidInput(
            concat("triangle ", f, " names vertex ", mesh.triangles(f, k), ", but there are ", n));
  if (mesh.normals.rows() != 0 && mesh.normals.rows() != n)
    throw InvalidInput(concat("the mesh has ", mesh.normals.rows(), " normals for ", n, " vertices"));
  for (const auto& [name, values] : mesh.vertex_values)
    if (values.size() != n)
      throw InvalidInput(
          concat("the mesh has ", values.size(), " values of '", name, "' for ", n, " vertices"));
}

/// The extension looks through .gz for the readers; what is written under such a name would be no gzip file.
void refuse_compressed(const std::string& path) {
  if (path.size() > 3 && path.compare(path.size() - 3, 3, ".gz") == 0)
    throw FileError(path, 0, "compressed files are read but not written; leave out .gz");
}

std::optional<MeshFormat> shown_mesh_format(std::string_view content) {
  if (content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);
  const std::string_view head = content.substr(0, 4);
  if (head == "ply\n" || head == "ply\r") return MeshFormat::Ply;
  if (is_binary_stl(content)) return MeshFormat::Stl;
  if (begins_as_gltf(content)) return MeshFormat::Gltf;
  if (begins_as_zip(content)) return MeshFormat::ThreeMf;
  if (begins_as_text_stl(content)) return MeshFormat::Stl;
  Tokens tokens(content.substr(0, 200));
  std::string_view first;
  tokens.next(first);
  for (const std::string_view name : {"OFF", "COFF", "NOFF", "CNOFF", "NCOFF", "STOFF"})
    if (first == name) return MeshFormat::Off;
  return std::nullopt;
}

RawMesh parse_raw_mesh(std::string content, const std::string& path, std::vector<std::string>& notes) {
  if (content.empty()) throw FileError(path, 0, "is empty, expected a mesh");
  MeshFormat format = MeshFormat::Ply;
  const std::optional<MeshFormat> shown = shown_mesh_format(content);
  const bool named =
      format_of_extension(path == "-" ? extension_of_content(content) : file_extension(path), format);
  if (!shown && !named)
    throw FileError(path, 0, "is not recognised as a mesh; use a .ply, .obj, .off, .stl, .glb or .3mf file");
  if (shown && (!named || *shown != format)) {
    if (named)
      notes.push_back(concat(path, " is a ", name_of(*shown), " file by its content and was read as such"));
    format = *shown;
  }
  switch (format) {
    case MeshFormat::Ply:
      return parse_ply(content, path);
    case MeshFormat::Obj:
      return parse_obj_mesh(std::move(content), path);
    case MeshFormat::Off:
      return parse_off(std::move(content), path);
    case MeshFormat::Stl:
      return parse_stl(std::move(content), path);
    case MeshFormat::Gltf:
      return parse_gltf(content, path);
    case MeshFormat::ThreeMf:
      return parse_threemf(content, path);
  }
  return {};
}

}  // namespace detail

TriangleMesh parse_mesh(std::string content, const std::string& path, std::vector<std::string>* warnings) {
  std::vector<std::string> notes;
  detail::RawMesh raw = detail::parse_raw_mesh(std::move(content), path, notes);
  raw.warnings.insert(raw.warnings.begin(), notes.begin(), notes.end());
  return detail::finished_mesh(std::move(raw), path, warnings);
}

TriangleMesh read_mesh(const std::string& path, std::vector<std::string>* warnings) {
  return parse_mesh(read_file(path), path, warnings);
}

std::optional<std::string> MeshWriteOptions::problem() const {
  if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit))
    return concat("metres_per_unit must be finite and above 0, got ", metres_per_unit);
  return std::nullopt;
}

std::string format_mesh(const TriangleMesh& mesh, MeshFormat format, const MeshWriteOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  detail::check_arrays(mesh);
  switch (format) {
    case MeshFormat::Ply:
      return detail::ply_text(mesh, {}, options.ascii);
    case MeshFormat::Obj:
      return detail::obj_text(mesh, {});
    case MeshFormat::Off:
      return off_text(mesh);
    case MeshFormat::Stl:
      return stl_text(mesh, options.ascii);
    case MeshFormat::Gltf:
      return detail::glb_bytes(mesh, options.metres_per_unit);
    case MeshFormat::ThreeMf:
      return detail::threemf_bytes(mesh, options.metres_per_unit);
  }
  return {};
}

void write_mesh(const std::string& path, const TriangleMesh& mesh, const MeshWriteOptions& options) {
  detail::refuse_compressed(path);
  write_file(path, format_mesh(mesh, mesh_format(path), options));
}

bool holds_polygons(MeshFormat format) {
  return format == MeshFormat::Ply || format == MeshFormat::Obj || format == MeshFormat::Off;
}

bool has_unit(MeshFormat format) {
  return format == MeshFormat::Gltf || format == MeshFormat::ThreeMf;
}

std::vector<std::string> losses_in_format(const TriangleMesh& mesh, MeshFormat format,
                                          const MeshWriteOptions& options) {
  std::vector<std::string> losses;
  if (format == MeshFormat::Ply) return losses;
  std::string names;
  for (const auto& [name, values] : mesh.vertex_values) {
    const bool colour = name == "red" || name == "green" || name == "blue";
    const bool holds_colour =
        format == MeshFormat::Gltf || (format == MeshFormat::Obj && detail::has_byte_colours(mesh));
    if (!holds_colour || !colour) names += (names.empty() ? "" : ", ") + name;
  }
  if (!names.empty()) {
    losses.push_back(
        concat(name_of(format), " cannot hold the values per vertex (", names, "); use .ply to keep them"));
  }
  if (format == MeshFormat::Gltf)
    losses.emplace_back("glTF rounds coordinates to single precision (7 digits)");
  if (format == MeshFormat::ThreeMf && has_normals(mesh))
    losses.emplace_back("3MF cannot hold the normals of the vertices; use .ply to keep them");
  if (format == MeshFormat::Stl) {
    if (has_normals(mesh))
      losses.emplace_back("STL cannot hold the normals of the vertices; use .ply to keep them");
    std::vector<char> used(static_cast<size_t>(mesh.n_vertices()), 0);
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k) used[static_cast<size_t>(mesh.triangles(f, k))] = 1;
    Eigen::Index n_unused = 0;
    for (const char u : used) n_unused += u == 0;
    if (n_unused > 0) losses.push_back(concat("STL leaves out the ", n_unused, " vertices without a face"));
    if (!options.ascii) losses.emplace_back("binary STL rounds coordinates to single precision (7 digits)");
  }
  return losses;
}

}  // namespace batten
