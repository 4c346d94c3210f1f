#include <algorithm>
#include <cctype>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/obj_detail.hpp"

namespace batten::detail {

namespace {

constexpr long kMost = std::numeric_limits<int>::max() / 3;

/// An index as OBJ writes it: from 1, or negative to count back from the last one so far. May point ahead;
/// the end of the file checks that.
long resolved(long index, size_t so_far, const LineReader& reader, std::string_view what) {
  if (index > 0 && index <= kMost) return index - 1;
  if (index < 0 && static_cast<size_t>(-index) <= so_far) return static_cast<long>(so_far) + index;
  reader.fail(
      concat(what, " ", index, " is out of range; ", so_far, " are given so far and counting begins at 1"));
}

/// The lines of an OBJ file; a backslash at the end continues a line on the next one.
class Statements {
 public:
  explicit Statements(LineReader& reader) : reader_(reader) {}

  bool next(std::string_view& statement) {
    if (!reader_.next(statement)) return false;
    if (statement.empty() || statement.back() != '\\') return true;
    joined_.assign(statement);
    std::string_view more;
    while (!joined_.empty() && joined_.back() == '\\') {
      joined_.back() = ' ';
      if (!reader_.next(more)) break;
      joined_ += more;
    }
    statement = joined_;
    return true;
  }

 private:
  LineReader& reader_;
  std::string joined_;
};

/// Which statement lies behind an index, to name its line when it turns out to be out of range.
struct Reference {
  long line = 0;
  long highest = -1;

  void note(long index, long at_line) {
    if (index > highest) {
      highest = index;
      line = at_line;
    }
  }
  void check(size_t count, std::string_view what, const std::string& path) const {
    if (highest >= static_cast<long>(count))
      throw FileError(path, line,
                      concat(what, " ", highest + 1, " is used, but the file holds ", count,
                             "; the file is truncated or its indices are wrong"));
  }
};

}  // namespace

ObjContent parse_obj(std::string content, const std::string& path) {
  ObjContent obj;
  LineReader reader(std::move(content), path);
  Statements statements(reader);
  std::string_view statement, word;
  std::string object, group;
  Reference vertex_reference, normal_reference;
  long n_texture = 0, n_unknown = 0, first_unknown = 0, n_free_form = 0;
  std::string unknown;
  while (statements.next(statement)) {
    const std::string_view line = trim(statement);
    if (line.substr(0, 8) == "# batten") obj.comments.emplace_back(trim(line.substr(8)));
    Tokens tokens(without_comment(line));
    if (!tokens.next(word)) continue;
    if (word == "v" || word == "vn") {
      std::vector<double>& values = word == "v" ? obj.positions : obj.normals;
      if (values.size() / 3 >= static_cast<size_t>(kMost)) reader.fail("too many vertices for this program");
      for (int k = 0; k < 3; ++k)
        values.push_back(
            read_finite(tokens, reader, word == "v" ? "a coordinate" : "a coordinate of the normal"));
    } else if (word == "f") {
      int n_corners = 0;
      while (tokens.next(word)) {
        // a, a/t, a//n or a/t/n
        const size_t slash = word.find('/');
        long index = 0;
        if (!parse_integer(word.substr(0, slash), index))
          reader.fail("a corner is no integer; expected f a b c, f a/t …, f a//n … or f a/t/n …");
        const long vertex = resolved(index, obj.positions.size() / 3, reader, "vertex");
        vertex_reference.note(vertex, reader.line_number());
        long normal = -1;
        if (slash != std::string_view::npos) {
          const size_t second = word.find('/', slash + 1);
          if (second != std::string_view::npos && second + 1 < word.size()) {
            if (!parse_integer(word.substr(second + 1), index))
              reader.fail("the index of a normal is no integer; expected f a//n … or f a/t/n …");
            normal = resolved(index, obj.normals.size() / 3, reader, "normal");
            normal_reference.note(normal, reader.line_number());
          }
        }
        obj.face_vertices.push_back(static_cast<int>(vertex));
        obj.face_normals.push_back(static_cast<int>(normal));
        ++n_corners;
      }
      if (n_corners == 0) reader.fail("a face without corners");
      if (obj.face_vertices.size() > static_cast<size_t>(kMost))
        reader.fail("too many faces for this program");
      obj.face_offsets.push_back(static_cast<int>(obj.face_vertices.size()));
    } else if (word == "l") {
      ObjContent::Line polyline{object, group, {}, reader.line_number()};
      while (tokens.next(word)) {
        long index = 0;
        if (!parse_integer(word.substr(0, word.find('/')), index))
          reader.fail("a point of a line is no integer; expected l a b c …");
        const long vertex = resolved(index, obj.positions.size() / 3, reader, "vertex");
        vertex_reference.note(vertex, reader.line_number());
        polyline.vertices.push_back(static_cast<int>(vertex));
      }
      if (polyline.vertices.size() < 2) reader.fail("a line needs at least two points");
      obj.lines.push_back(std::move(polyline));
    } else if (word == "t") {
      obj.tags.push_back({std::string(trim(without_comment(line).substr(1))), reader.line_number()});
    } else if (word == "o") {
      object = trim(line.substr(1));
    } else if (word == "g") {
      group = trim(line.substr(1));
    } else if (word == "p") {
      ++obj.n_points;
    } else if (word == "vt") {
      ++n_texture;
    } else if (word == "curv" || word == "curv2" || word == "surf") {
      ++n_free_form;
    } else if (std::all_of(word.begin(), word.end(),
                           [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }) &&
               std::isalpha(static_cast<unsigned char>(word[0]))) {
      static constexpr std::string_view kHarmless[] = {
          "mtllib", "usemtl",     "usemap",    "maplib", "s",     "mg",       "vp",
          "cstype", "deg",        "bmat",      "step",   "parm",  "trim",     "hole",
          "scrv",   "sp",         "end",       "con",    "bevel", "c_interp", "d_interp",
          "lod",    "shadow_obj", "trace_obj", "ctech",  "stech", "call",     "csh"};
      if (std::find(std::begin(kHarmless), std::end(kHarmless), word) == std::end(kHarmless) &&
          n_unknown++ == 0) {
        first_unknown = reader.line_number();
        unknown = word.substr(0, 30);
      }
    } else {
      reader.fail("this is no OBJ statement; is the extension right?");
    }
  }
  vertex_reference.check(obj.positions.size() / 3, "vertex", path);
  normal_reference.check(obj.normals.size() / 3, "normal", path);
  if (n_unknown > 0)
    obj.warnings.push_back(concat(n_unknown, " unknown statements were left out (the first is '", unknown,
                                  "' on line ", first_unknown, ")"));
  if (n_texture > 0) obj.warnings.push_back(concat(n_texture, " texture coordinates were left out"));
  if (n_free_form > 0)
    obj.warnings.push_back(
        concat(n_free_form, " free-form curves or surfaces were left out; export polylines or faces"));
  return obj;
}

RawMesh parse_obj_mesh(std::string content, const std::string& path) {
  ObjContent obj = parse_obj(std::move(content), path);
  const size_t n_faces = obj.face_offsets.size() - 1;
  if (n_faces == 0 && !obj.lines.empty())
    throw FileError(path, obj.lines.front().line,
                    "holds lines and no faces: it is a curve network, not a mesh");
  if (obj.positions.empty()) throw FileError(path, 0, "holds no vertices ('v x y z'), expected a mesh");
  RawMesh mesh;
  mesh.warnings = std::move(obj.warnings);
  std::vector<int> corners;
  for (size_t f = 0; f < n_faces; ++f) {
    corners.assign(obj.face_vertices.begin() + obj.face_offsets[f],
                   obj.face_vertices.begin() + obj.face_offsets[f + 1]);
    add_face(mesh, corners);
  }
  const size_t n = obj.positions.size() / 3;
  if (!obj.normals.empty()) {
    // OBJ gives normals to corners; a mesh here has one per vertex. They agree when every corner of a vertex
    // carries the same three numbers.
    std::vector<int> normal_of(n, -1);
    bool referred = false, agree = true;
    for (size_t c = 0; c < obj.face_vertices.size() && agree; ++c) {
      const int normal = obj.face_normals[c];
      if (normal < 0) continue;
      referred = true;
      int& known = normal_of[static_cast<size_t>(obj.face_vertices[c])];
      if (known < 0)
        known = normal;
      else
        for (size_t k = 0; k < 3; ++k)
          agree = agree && obj.normals[3 * static_cast<size_t>(known) + k] ==
                               obj.normals[3 * static_cast<size_t>(normal) + k];
    }
    if (!referred && obj.normals.size() == obj.positions.size()) {
      mesh.normals = std::move(obj.normals);  // not referred to, but one for each vertex
    } else if (referred && agree) {
      mesh.normals.assign(3 * n, 0.0);
      for (size_t v = 0; v < n; ++v)
        if (normal_of[v] >= 0)
          std::copy_n(obj.normals.begin() + 3 * normal_of[v], 3,
                      mesh.normals.begin() + static_cast<long>(3 * v));
    } else if (referred) {
      mesh.warnings.emplace_back("the normals differ between the faces around a vertex and were left out");
    } else {
      mesh.warnings.push_back(
          concat(obj.normals.size() / 3, " normals that no face refers to were left out"));
    }
  }
  for (ObjContent::Line& line : obj.lines) mesh.polylines.push_back({std::move(line.vertices), line.line});
  mesh.tags = std::move(obj.tags);
  mesh.positions = std::move(obj.positions);
  return mesh;
}

}  // namespace batten::detail
