#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/gltf_detail.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"

// Meshes as the binary form of glTF 2.0: metres, +Y up.
namespace batten::detail {

namespace {

using Json = nlohmann::json;

/// The bytes of one bufferView, and what refers to it.
class GlbWriter {
 public:
  /// @param values of `width` each, row by row.
  int add_floats(const std::vector<double>& values, int width, bool with_range) {
    begin_view(34962);  // ARRAY_BUFFER
    for (const double value : values) append_little_endian(binary_, static_cast<float>(value));
    Json accessor = add_accessor(gltf::kFloat, values.size() / static_cast<size_t>(width),
                                 width == 1 ? "SCALAR" : "VEC3");
    if (with_range) {
      std::vector<float> low(3, std::numeric_limits<float>::max()),
          high(3, std::numeric_limits<float>::lowest());
      for (size_t i = 0; i < values.size(); ++i) {
        low[i % 3] = std::min(low[i % 3], static_cast<float>(values[i]));
        high[i % 3] = std::max(high[i % 3], static_cast<float>(values[i]));
      }
      accessor["min"] = low;
      accessor["max"] = high;
    }
    return put(std::move(accessor));
  }
  int add_colours(const std::vector<std::uint8_t>& bytes) {
    begin_view(34962);
    for (const std::uint8_t byte : bytes) binary_ += static_cast<char>(byte);
    Json accessor = add_accessor(gltf::kUnsignedByte, bytes.size() / 4, "VEC4");
    accessor["normalized"] = true;
    return put(std::move(accessor));
  }
  int add_indices(const Triangles& triangles) {
    begin_view(34963);  // ELEMENT_ARRAY_BUFFER
    for (Eigen::Index f = 0; f < triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) append_little_endian(binary_, static_cast<std::uint32_t>(triangles(f, k)));
    return put(add_accessor(gltf::kUnsignedInt, static_cast<size_t>(triangles.size()), "SCALAR"));
  }

  std::string bytes(const Json& primitive) {
    while (binary_.size() % 4 != 0) binary_ += '\0';
    const Json content = {{"asset", {{"version", "2.0"}, {"generator", "Batten"}}},
                          {"scene", 0},
                          {"scenes", {{{"nodes", {0}}}}},
                          {"nodes", {{{"mesh", 0}}}},
                          {"meshes", {{{"primitives", {primitive}}}}},
                          {"buffers", {{{"byteLength", binary_.size()}}}},
                          {"bufferViews", views_},
                          {"accessors", accessors_}};
    std::string text = content.dump();
    while (text.size() % 4 != 0) text += ' ';
    std::string out;
    append_little_endian(out, gltf::kMagic);
    append_little_endian(out, 2);
    append_little_endian(out, static_cast<std::uint32_t>(28 + text.size() + binary_.size()));
    append_little_endian(out, static_cast<std::uint32_t>(text.size()));
    append_little_endian(out, gltf::kJsonChunk);
    out += text;
    append_little_endian(out, static_cast<std::uint32_t>(binary_.size()));
    append_little_endian(out, gltf::kBinaryChunk);
    return out + binary_;
  }

 private:
  void begin_view(int target) {
    while (binary_.size() % 4 != 0) binary_ += '\0';
    begin_ = binary_.size();
    target_ = target;
  }
  Json add_accessor(int type, size_t count, const char* shape) {
    views_.push_back({{"buffer", 0},
                      {"byteOffset", begin_},
                      {"byteLength", binary_.size() - begin_},
                      {"target", target_}});
    return {{"bufferView", views_.size() - 1}, {"componentType", type}, {"count", count}, {"type", shape}};
  }
  int put(Json accessor) {
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }

  std::string binary_;
  size_t begin_ = 0;
  int target_ = 0;
  Json views_ = Json::array(), accessors_ = Json::array();
};

std::vector<double> y_up(const Points& rows, double scale) {
  std::vector<double> values;
  values.reserve(static_cast<size_t>(rows.size()));
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    values.insert(values.end(), {scale * rows(i, 0), scale * rows(i, 2), -scale * rows(i, 1)});
  return values;
}

}  // namespace

std::string glb_bytes(const TriangleMesh& mesh, double metres_per_unit) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  const double largest = mesh.n_vertices() > 0 ? mesh.positions.cwiseAbs().maxCoeff() * metres_per_unit : 0;
  if (!(largest <= kLargest) || mesh.triangles.size() > (Eigen::Index{1} << 29))
    throw InvalidInput(concat("GLB holds coordinates up to ", kLargest,
                              " m and half a billion corners; the mesh reaches ", largest,
                              " m; write .ply, or simplify it"));
  GlbWriter writer;
  Json attributes = {{"POSITION", writer.add_floats(y_up(mesh.positions, metres_per_unit), 3, true)}};
  if (mesh.normals.rows() > 0) attributes["NORMAL"] = writer.add_floats(y_up(mesh.normals, 1), 3, false);
  const auto red = mesh.vertex_values.find("red"), green = mesh.vertex_values.find("green"),
             blue = mesh.vertex_values.find("blue"), none = mesh.vertex_values.end();
  if (red != none && green != none && blue != none) {
    std::vector<std::uint8_t> bytes;
    for (Eigen::Index i = 0; i < mesh.n_vertices(); ++i) {
      for (const auto* channel : {&red->second, &green->second, &blue->second})
        bytes.push_back(static_cast<std::uint8_t>(std::clamp(std::round((*channel)[i]), 0.0, 255.0)));
      bytes.push_back(255);
    }
    attributes["COLOR_0"] = writer.add_colours(bytes);
  }
  const Json primitive = {{"attributes", attributes},
                          {"indices", writer.add_indices(mesh.triangles)},
                          {"mode", gltf::kTriangles}};
  return writer.bytes(primitive);
}

}  // namespace batten::detail
