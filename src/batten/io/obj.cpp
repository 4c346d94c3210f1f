#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/obj_detail.hpp"

namespace batten::detail {

namespace {

constexpr long kMostObjElements = std::numeric_limits<int>::max() / 3;

/// An index as OBJ writes it: from 1, or negative to count back from the last one so far. May point ahead;
/// the end of the file checks that.
long resolved(long index, size_t so_far, const LineReader& reader, std::string_view what) {
  if (index > 0 && index <= kMostObjElements) return index - 1;
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

/// A word that OBJ might use: other statements are no OBJ at all.
bool is_keyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }) &&
         std::isalpha(static_cast<unsigned char>(word[0]));
}

/// Statements that say nothing about shape, or repeat what the free-form ones say.
bool is_harmless(std::string_view word) {
  static constexpr std::string_view kHarmless[] = {
      "usemap",   "maplib", "s",          "mg",        "vp",    "cstype", "deg",  "bmat",  "step",
      "parm",     "trim",   "hole",       "scrv",      "sp",    "end",    "con",  "bevel", "c_interp",
      "d_interp", "lod",    "shadow_obj", "trace_obj", "ctech", "stech",  "call", "csh"};
  return std::find(std::begin(kHarmless), std::end(kHarmless), word) != std::end(kHarmless);
}

class ObjParser {
 public:
  ObjParser(std::string content, const std::string& path) : path_(path), reader_(std::move(content), path) {}

  ObjContent parse() {
    Statements statements(reader_);
    std::string_view statement, word;
    while (statements.next(statement)) {
      const std::string_view line = trim(statement);
      if (line.substr(0, 8) == "# batten") obj_.comments.emplace_back(trim(line.substr(8)));
      Tokens tokens(without_comment(line));
      if (tokens.next(word)) read(word, line, tokens);
    }
    vertices_.check(obj_.positions.size() / 3, "vertex", path_);
    normals_.check(obj_.normals.size() / 3, "normal", path_);
    texture_.check(obj_.texture.size() / 2, "texture coordinate", path_);
    warn();
    return std::move(obj_);
  }

 private:
  /// One statement: its first word, all of its line, and what follows the word.
  void read(std::string_view word, std::string_view line, Tokens& tokens) {
    if (word == "v")
      read_vertex_line(tokens);
    else if (word == "vn")
      read_point(tokens, obj_.normals, "a coordinate of the normal");
    else if (word == "f")
      read_face(tokens);
    else if (word == "l")
      read_line(tokens);
    else if (word == "t")
      obj_.tags.push_back({std::string(trim(without_comment(line).substr(1))), reader_.line_number()});
    else if (word == "o")
      object_ = trim(line.substr(1));
    else if (word == "g")
      group_ = trim(line.substr(1));
    else if (word == "p")
      ++obj_.n_points;
    else if (word == "vt")
      read_texture(tokens);
    else if (word == "usemtl")
      material_ = trim(line.substr(6));
    else if (word == "mtllib")
      obj_.libraries.emplace_back(trim(line.substr(6)));
    else if (word == "curv" || word == "curv2" || word == "surf")
      ++n_free_form_;
    else if (!is_keyword(word))
      reader_.fail("this is no OBJ statement; is the extension right?");
    else if (!is_harmless(word) && n_unknown_++ == 0) {
      first_unknown_ = reader_.line_number();
      unknown_ = word.substr(0, 30);
    }
  }

  void read_point(Tokens& tokens, std::vector<double>& values, std::string_view what) {
    if (values.size() / 3 >= static_cast<size_t>(kMostObjElements))
      reader_.fail("too many vertices for this program");
    for (int k = 0; k < 3; ++k) values.push_back(read_finite(tokens, reader_, what));
  }

  /// Three numbers behind the coordinates are a colour; one is a weight, and left out.
  void read_vertex_line(Tokens& tokens) {
    read_point(tokens, obj_.positions, "a coordinate");
    std::string_view token;
    double channels[3];
    for (double& channel : channels)
      if (!tokens.next(token) || !parse_number(token, channel) || !std::isfinite(channel)) return;
    obj_.colours.insert(obj_.colours.end(), channels, channels + 3);
  }

  void read_texture(Tokens& tokens) {
    obj_.texture.push_back(read_finite(tokens, reader_, "a texture coordinate"));
    std::string_view token;
    double v = 0;  // may be missing
    if (tokens.next(token) && !(parse_number(token, v) && std::isfinite(v)))
      reader_.fail("a texture coordinate is no number");
    obj_.texture.push_back(v);
  }

  /// The texture coordinates of a corner a/t or a/t/n; −1 where it has none.
  int read_corner_texture(std::string_view word) {
    const size_t slash = word.find('/');
    if (slash == std::string_view::npos) return -1;
    const std::string_view rest = word.substr(slash + 1), text = rest.substr(0, rest.find('/'));
    if (text.empty()) return -1;
    long index = 0;
    if (!parse_integer(text, index))
      reader_.fail("the index of a texture coordinate is no integer; expected f a/t … or f a/t/n …");
    const long texture = resolved(index, obj_.texture.size() / 2, reader_, "texture coordinate");
    texture_.note(texture, reader_.line_number());
    return static_cast<int>(texture);
  }

  /// The label of the face read last.
  static void add_label(MeshAttributes::Labels& labels, const std::string& word, int& number) {
    if (!word.empty() && (number < 0 || labels.words[static_cast<size_t>(number)] != word)) {
      const auto found = std::find(labels.words.begin(), labels.words.end(), word);
      number = static_cast<int>(found - labels.words.begin());
      if (found == labels.words.end()) labels.words.push_back(word);
    }
    labels.of_face.push_back(word.empty() ? -1 : number);
  }

  /// The vertex that a word names, up to its first slash.
  int read_vertex(std::string_view word, std::string_view no_integer) {
    long index = 0;
    if (!parse_integer(word.substr(0, word.find('/')), index)) reader_.fail(no_integer);
    const long vertex = resolved(index, obj_.positions.size() / 3, reader_, "vertex");
    vertices_.note(vertex, reader_.line_number());
    return static_cast<int>(vertex);
  }

  /// The normal of a corner a, a/t, a//n or a/t/n; −1 where it has none.
  int read_normal(std::string_view word) {
    const size_t slash = word.find('/');
    if (slash == std::string_view::npos) return -1;
    const size_t second = word.find('/', slash + 1);
    if (second == std::string_view::npos || second + 1 >= word.size()) return -1;
    long index = 0;
    if (!parse_integer(word.substr(second + 1), index))
      reader_.fail("the index of a normal is no integer; expected f a//n … or f a/t/n …");
    const long normal = resolved(index, obj_.normals.size() / 3, reader_, "normal");
    normals_.note(normal, reader_.line_number());
    return static_cast<int>(normal);
  }

  void read_face(Tokens& tokens) {
    int n_corners = 0;
    std::string_view word;
    while (tokens.next(word)) {
      const int vertex =
          read_vertex(word, "a corner is no integer; expected f a b c, f a/t …, f a//n … or f a/t/n …");
      const int normal = read_normal(word);
      obj_.face_vertices.push_back(vertex);
      obj_.face_normals.push_back(normal);
      obj_.face_texture.push_back(read_corner_texture(word));
      ++n_corners;
    }
    if (n_corners == 0) reader_.fail("a face without corners");
    if (obj_.face_vertices.size() > static_cast<size_t>(kMostObjElements))
      reader_.fail("too many faces for this program");
    obj_.face_offsets.push_back(static_cast<int>(obj_.face_vertices.size()));
    add_label(obj_.objects, object_, object_number_);
    add_label(obj_.groups, group_, group_number_);
    add_label(obj_.materials, material_, material_number_);
  }

  void read_line(Tokens& tokens) {
    ObjContent::Line polyline{object_, group_, {}, reader_.line_number()};
    std::string_view word;
    while (tokens.next(word))
      polyline.vertices.push_back(read_vertex(word, "a point of a line is no integer; expected l a b c …"));
    if (polyline.vertices.size() < 2) reader_.fail("a line needs at least two points");
    obj_.lines.push_back(std::move(polyline));
  }

  /// Says what was left out.
  void warn() {
    if (n_unknown_ > 0)
      obj_.warnings.push_back(concat(n_unknown_, " unknown statements were left out (the first is '",
                                     unknown_, "' on line ", first_unknown_, ")"));
    if (n_free_form_ > 0)
      obj_.warnings.push_back(
          concat(n_free_form_, " free-form curves or surfaces were left out; export polylines or faces"));
  }

  const std::string& path_;
  LineReader reader_;
  ObjContent obj_;
  std::string object_, group_, material_;                              // that lines and faces belong to
  int object_number_ = -1, group_number_ = -1, material_number_ = -1;  // those words among the labels
  Reference vertices_, normals_, texture_;
  long n_free_form_ = 0, n_unknown_ = 0, first_unknown_ = 0;
  std::string unknown_;  // the first
};

/// OBJ gives normals to corners; a mesh here has one per vertex. They agree when every corner of a vertex
/// carries the same three numbers.
void take_normals(ObjContent& obj, RawMesh& mesh) {
  const size_t n = obj.positions.size() / 3;
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
    mesh.warnings.push_back(concat(obj.normals.size() / 3, " normals that no face refers to were left out"));
  }
}

/// Fractions of 255, as whole numbers where they are meant to be.
void take_colours(const ObjContent& obj, RawMesh& mesh) {
  const char* const kNames[] = {"red", "green", "blue"};
  for (size_t k = 0; k < 3; ++k) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(obj.colours.size() / 3));
    for (size_t v = 0; 3 * v < obj.colours.size(); ++v) {
      const double value = 255 * obj.colours[3 * v + k], whole = std::round(value);
      values(static_cast<Eigen::Index>(v)) = std::abs(value - whole) < 0.01 ? whole : value;
    }
    mesh.vertex_values[kNames[k]] = std::move(values);
  }
}

}  // namespace

ObjContent parse_obj(std::string content, const std::string& path) {
  return ObjParser(std::move(content), path).parse();
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
  MeshAttributes& attributes = mesh.attributes;
  attributes.objects.words = std::move(obj.objects.words);
  attributes.groups.words = std::move(obj.groups.words);
  attributes.materials.words = std::move(obj.materials.words);
  attributes.libraries = std::move(obj.libraries);
  for (size_t f = 0; f < n_faces; ++f) {
    const int begin = obj.face_offsets[f], end = obj.face_offsets[f + 1];
    corners.assign(obj.face_vertices.begin() + begin, obj.face_vertices.begin() + end);
    if (!add_face(mesh, corners)) continue;
    mesh.corner_texture.insert(mesh.corner_texture.end(), obj.face_texture.begin() + begin,
                               obj.face_texture.begin() + end);
    attributes.objects.of_face.push_back(obj.objects.of_face[f]);
    attributes.groups.of_face.push_back(obj.groups.of_face[f]);
    attributes.materials.of_face.push_back(obj.materials.of_face[f]);
  }
  mesh.texture = std::move(obj.texture);
  if (obj.colours.size() == obj.positions.size()) take_colours(obj, mesh);
  if (!obj.normals.empty()) take_normals(obj, mesh);
  for (ObjContent::Line& line : obj.lines) mesh.polylines.push_back({std::move(line.vertices), line.line});
  mesh.tags = std::move(obj.tags);
  mesh.positions = std::move(obj.positions);
  return mesh;
}

}  // namespace batten::detail
