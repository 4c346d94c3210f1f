#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "batten/core/text.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;

/// A scalar property: its numbers lie `stride` apart.
struct PlyColumn {
  std::string name, type;
  const double* numbers = nullptr;
  Index stride = 1;
  double at(Index row) const { return numbers[row * stride]; }
};

template <typename Number>
bool is_exact(double value) {
  if constexpr (std::numeric_limits<Number>::is_integer)
    return value >= static_cast<double>(std::numeric_limits<Number>::min()) &&
           value <= static_cast<double>(std::numeric_limits<Number>::max()) && std::floor(value) == value &&
           !(value == 0 && std::signbit(value));
  else  // comparing what is too large for a float would be undefined
    return !(std::abs(value) > static_cast<double>(std::numeric_limits<Number>::max())) &&
           (static_cast<double>(static_cast<Number>(value)) == value || std::isnan(value));
}

/// Calls `use` with a number of the type of that name. @pre one of the eight names
template <typename Use>
auto with_type(const std::string& type, const Use& use) {
  if (type == "char") return use(std::int8_t{});
  if (type == "uchar") return use(std::uint8_t{});
  if (type == "short") return use(std::int16_t{});
  if (type == "ushort") return use(std::uint16_t{});
  if (type == "int") return use(std::int32_t{});
  if (type == "uint") return use(std::uint32_t{});
  if (type == "float") return use(float{});
  return use(double{});
}

bool holds(const std::string& type, const PlyColumn& column, Index n) {
  return with_type(type, [&](auto number) {
    for (Index row = 0; row < n; ++row)
      if (!is_exact<decltype(number)>(column.at(row))) return false;
    return true;
  });
}

void append_number(std::string& text, const std::string& type, double value) {
  with_type(type, [&](auto number) {
    using Number = decltype(number);
    const auto exact = static_cast<Number>(value);
    if constexpr (sizeof(Number) == 1)
      text += static_cast<char>(exact);
    else if constexpr (sizeof(Number) == 2)
      append_little_endian(text, static_cast<std::uint16_t>(exact));
    else if constexpr (std::numeric_limits<Number>::is_integer)
      append_little_endian(text, static_cast<std::uint32_t>(exact));
    else
      append_little_endian(text, exact);
    return 0;
  });
}

/// A property name is one token; anything else in it would break the header.
std::string property_name(const std::string& name) {
  std::string safe;
  for (const char c : name) safe += static_cast<unsigned char>(c) > 32 ? c : '_';
  return safe.empty() ? "value" : safe;
}

constexpr const char* kChannels[] = {"red", "green", "blue", "alpha"};

/// Colours of whole numbers from 0 to 255 are written as bytes, which is what other programs look for. Where
/// none exceeds 1 and some are 1, they may be fractions.
bool is_byte_channel(const PlyColumn& column, Index n) {
  if (std::find(std::begin(kChannels), std::end(kChannels), column.name) == std::end(kChannels)) return false;
  double most = 0;
  for (Index row = 0; row < n; ++row) most = std::max(most, column.at(row));
  return n > 0 && most != 1 && holds("uchar", column, n);
}

/// The scalar properties of the vertices: those of the file that was read first, in its order; then
/// coordinates, normals, colours in their usual order, and the others by name.
std::vector<PlyColumn> vertex_columns(const TriangleMesh& mesh, const MeshAttributes& attributes) {
  std::vector<PlyColumn> columns;
  const auto add = [&](const std::string& name, const double* numbers, Index stride) {
    columns.push_back({name, "", numbers, stride});
  };
  const char* const kAxes[] = {"x", "y", "z", "nx", "ny", "nz"};
  for (int k = 0; k < 3; ++k) add(kAxes[k], mesh.positions.data() + k, 3);
  if (mesh.normals.rows() > 0)
    for (int k = 0; k < 3; ++k) add(kAxes[3 + k], mesh.normals.data() + k, 3);
  for (const char* name : kChannels)
    if (const auto found = mesh.vertex_values.find(name); found != mesh.vertex_values.end())
      add(name, found->second.data(), 1);
  for (const auto& [name, values] : mesh.vertex_values)
    if (std::find(std::begin(kChannels), std::end(kChannels), name) == std::end(kChannels))
      add(name, values.data(), 1);
  const auto place = [&](const PlyColumn& column) {
    const auto& known = attributes.vertex_properties;
    return std::find_if(known.begin(), known.end(),
                        [&](const MeshAttributes::Property& p) { return p.name == column.name; }) -
           known.begin();
  };
  std::stable_sort(columns.begin(), columns.end(),
                   [&](const PlyColumn& a, const PlyColumn& b) { return place(a) < place(b); });
  for (PlyColumn& column : columns) {
    const auto at = static_cast<std::size_t>(place(column));
    if (at < attributes.vertex_properties.size() &&
        holds(attributes.vertex_properties[at].type, column, mesh.n_vertices()))
      column.type = attributes.vertex_properties[at].type;
    else
      column.type = is_byte_channel(column, mesh.n_vertices()) ? "uchar" : "double";
    column.name = property_name(column.name);
  }
  return columns;
}

std::vector<PlyColumn> face_columns(const MeshAttributes& attributes, Index n) {
  std::vector<PlyColumn> columns;
  for (std::size_t p = 0; p < attributes.face_properties.size(); ++p) {
    PlyColumn column{property_name(attributes.face_properties[p].name), "double",
                     attributes.face_values[p].data(), 1};
    if (holds(attributes.face_properties[p].type, column, n))
      column.type = attributes.face_properties[p].type;
    columns.push_back(std::move(column));
  }
  return columns;
}

/// One element, row by row.
class Rows {
 public:
  Rows(std::string& text, bool ascii) : text_(text), ascii_(ascii) {}
  void add(const std::string& type, double value) {
    if (ascii_)
      (text_ += is_first_ ? "" : " ") += exact_decimal(value);
    else
      append_number(text_, type, value);
    is_first_ = false;
  }
  void end() {
    if (ascii_) text_ += '\n';
    is_first_ = true;
  }

 private:
  std::string& text_;
  bool ascii_, is_first_ = true;
};

}  // namespace

std::string ply_text(const TriangleMesh& mesh, const MeshAttributes& attributes, bool ascii) {
  const std::vector<PlyColumn> columns = vertex_columns(mesh, attributes),
                               of_faces = face_columns(attributes, mesh.n_triangles());
  const Triangles& corners = attributes.texture_corners;
  std::string text =
      concat("ply\nformat ", ascii ? "ascii" : "binary_little_endian", " 1.0\ncomment Batten\n");
  for (const std::string& file : attributes.texture_files) text += concat("comment TextureFile ", file, "\n");
  text += concat("element vertex ", mesh.n_vertices(), "\n");
  for (const PlyColumn& column : columns) text += concat("property ", column.type, " ", column.name, "\n");
  text += concat("element face ", mesh.n_triangles(), "\nproperty list uchar int vertex_indices\n");
  for (const PlyColumn& column : of_faces) text += concat("property ", column.type, " ", column.name, "\n");
  if (corners.rows() > 0) text += "property list uchar double texcoord\n";
  text += "end_header\n";
  Rows rows(text, ascii);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    for (const PlyColumn& column : columns) rows.add(column.type, column.at(v));
    rows.end();
  }
  for (Index f = 0; f < mesh.n_triangles(); ++f) {
    rows.add("uchar", 3);
    for (int k = 0; k < 3; ++k) rows.add("int", mesh.triangles(f, k));
    for (const PlyColumn& column : of_faces) rows.add(column.type, column.at(f));
    if (corners.rows() > 0) {
      const bool known = corners.row(f).minCoeff() >= 0;
      rows.add("uchar", known ? 6 : 0);
      for (int k = 0; known && k < 3; ++k)
        for (int axis = 0; axis < 2; ++axis) rows.add("double", attributes.texture(corners(f, k), axis));
    }
    rows.end();
  }
  return text;
}

}  // namespace batten::detail
