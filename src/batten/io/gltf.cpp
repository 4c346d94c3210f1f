#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/exact_merger_detail.hpp"
#include "batten/io/gltf_detail.hpp"
#include "batten/io/little_endian_detail.hpp"
#include "batten/io/mesh_formats_detail.hpp"

// glTF 2.0, the specification of the Khronos Group: metres, +Y up. Here +Z is up, so that (x, y, z) of a file
// is (x, −z, y).
namespace batten::detail {

namespace {

using Json = nlohmann::json;

/// Nodes deeper than this are a loop or no scene that anybody made.
constexpr int kDeepest = 200;

std::string from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int n_bits = 0;
  for (const char c : text) {
    int digit = -1;
    if (c >= 'A' && c <= 'Z') digit = c - 'A';
    if (c >= 'a' && c <= 'z') digit = c - 'a' + 26;
    if (c >= '0' && c <= '9') digit = c - '0' + 52;
    if (c == '+' || c == '-') digit = 62;
    if (c == '/' || c == '_') digit = 63;
    if (digit < 0) continue;  // padding and line ends
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    n_bits += 6;
    if (n_bits < 8) continue;
    n_bits -= 8;
    bytes += static_cast<char>(bits >> n_bits & 255);
  }
  return bytes;
}

class GltfParser {
 public:
  GltfParser(std::string_view content, const std::string& path) : path_(path), merger_(mesh_) {
    if (content.size() >= 4 && little_endian<std::uint32_t>(content.data()) == gltf::kMagic)
      unpack(content);
    else
      json_ = Json::parse(content, nullptr, false);
    if (!json_.is_object() || !json_.contains("asset")) fail("is no glTF file; is the extension right?");
  }

  RawMesh parse() {
    refuse_compression();
    load_buffers();
    if (json_.contains("nodes") && !list("nodes").empty()) {
      for (const Json& node : roots())
        walk(index(node, "a node of the scene"), Eigen::Matrix4d::Identity(), 0);
    } else {
      for (const Json& mesh : list("meshes")) add_mesh(mesh, Eigen::Matrix4d::Identity());
    }
    if (n_other_modes_ > 0)
      mesh_.warnings.push_back(concat(n_other_modes_, " sets of points or lines were left out"));
    if (has_normals_ && normals_agree_)
      mesh_.normals = std::move(normals_);
    else if (has_normals_)
      mesh_.warnings.emplace_back("normals differ between the faces around a vertex and were left out");
    if (has_colours_) {
      const char* const kNames[] = {"red", "green", "blue"};
      const auto n = static_cast<Eigen::Index>(mesh_.positions.size() / 3);
      colours_.resize(static_cast<size_t>(3 * n), 255.0);
      for (int k = 0; k < 3; ++k)
        mesh_.vertex_values[kNames[k]] =
            Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<3>>(colours_.data() + k, n);
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(std::string_view problem) const { throw FileError(path_, 0, problem); }

  void unpack(std::string_view content) {
    if (content.size() < 20) fail("is cut off");
    if (little_endian<std::uint32_t>(content.data() + 4) != 2)
      fail(concat("is glTF of version ", little_endian<std::uint32_t>(content.data() + 4),
                  ", expected 2; export it anew"));
    for (size_t at = 12; at + 8 <= content.size();) {
      const size_t length = little_endian<std::uint32_t>(content.data() + at);
      const std::uint32_t kind = little_endian<std::uint32_t>(content.data() + at + 4);
      if (length > content.size() - at - 8) fail("is cut off; copy it again");
      const std::string_view chunk = content.substr(at + 8, length);
      if (kind == gltf::kJsonChunk && json_.is_null()) json_ = Json::parse(chunk, nullptr, false);
      if (kind == gltf::kBinaryChunk && binary_.empty()) binary_ = chunk;
      at += 8 + length + (4 - length % 4) % 4;
    }
  }

  void refuse_compression() const {
    for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"})
      for (const Json& required : list("extensionsRequired"))
        if (required == name) fail(concat("is compressed (", name, "); export it without compression"));
  }

  const Json& list(const char* name) const {
    static const Json kEmpty = Json::array();
    const auto found = json_.find(name);
    if (found == json_.end()) return kEmpty;
    if (!found->is_array()) fail(concat("'", name, "' must be a list"));
    return *found;
  }

  const Json& entry(const char* name, size_t number) const {
    const Json& all = list(name);
    if (number >= all.size())
      fail(concat("names number ", number, " of '", name, "', which has ", all.size()));
    if (!all[number].is_object()) fail(concat("number ", number, " of '", name, "' must be an object"));
    return all[number];
  }

  size_t index(const Json& json, std::string_view what) const {
    if (!json.is_number_unsigned()) fail(concat(what, " must be a whole number from 0"));
    // No file is longer than 4 GB; sums of such numbers do not wrap in 64 bits.
    if (json.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
      fail(concat(what, " is too large: ", json.get<std::uint64_t>()));
    return json.get<size_t>();
  }
  /// A member that is a whole number from 0, or `standard`.
  size_t member(const Json& json, const char* name, std::optional<size_t> standard = std::nullopt) const {
    const auto found = json.find(name);
    if (found != json.end()) return index(*found, concat("'", name, "'"));
    if (!standard) fail(concat("'", name, "' is missing"));
    return *standard;
  }

  void load_buffers() {
    for (const Json& buffer : list("buffers")) {
      if (!buffer.is_object()) fail("a buffer must be an object");
      const auto uri = buffer.find("uri");
      if (uri == buffer.end()) {
        buffers_.emplace_back(binary_);
      } else if (!uri->is_string()) {
        fail("the 'uri' of a buffer must be text");
      } else if (const std::string text = uri->get<std::string>(); text.rfind("data:", 0) == 0) {
        const size_t comma = text.find(',');
        buffers_.push_back(comma == std::string::npos ? std::string() : from_base64(text.substr(comma + 1)));
      } else {
        const size_t slash = path_.find_last_of("/\\");
        buffers_.push_back(
            read_file((slash == std::string::npos ? std::string() : path_.substr(0, slash + 1)) + text));
      }
      if (buffers_.back().size() < member(buffer, "byteLength"))
        fail("a buffer is shorter than it says; the file is cut off");
    }
  }

  /// Rows of `width` numbers; those that are normalised from −1 or 0 to 1.
  std::vector<double> numbers(size_t number, size_t width, const char* what) const {
    const Json& accessor = entry("accessors", number);
    if (accessor.contains("sparse")) fail("has sparse accessors, which are not read; export it without them");
    const size_t count = member(accessor, "count"), type = member(accessor, "componentType");
    const std::string shape = accessor.value("type", std::string());
    const size_t given = shape == "SCALAR" ? 1 : shape == "VEC3" ? 3 : shape == "VEC4" ? 4 : 0;
    if (given < width || (given != width && width != 3)) fail(concat(what, " have the type '", shape, "'"));
    const size_t size = type == gltf::kFloat || type == gltf::kUnsignedInt     ? 4
                        : type == gltf::kShort || type == gltf::kUnsignedShort ? 2
                        : type == gltf::kByte || type == gltf::kUnsignedByte   ? 1
                                                                               : 0;
    if (size == 0) fail(concat(what, " have the component type ", type, ", which glTF does not know"));
    const Json& view = entry("bufferViews", member(accessor, "bufferView"));
    const size_t buffer = member(view, "buffer");
    if (buffer >= buffers_.size()) fail(concat("names buffer ", buffer, ", of ", buffers_.size()));
    const std::uint64_t offset = member(view, "byteOffset", 0),
                        begin = offset + member(accessor, "byteOffset", 0);
    const size_t stride = member(view, "byteStride", given * size);
    const std::string& bytes = buffers_[buffer];
    if (stride > 65536 ||
        (count > 0 && begin + std::uint64_t{count - 1} * stride + given * size > bytes.size()))
      fail(concat(what, " reach beyond the end of their buffer; the file is cut off"));
    const bool normalised = accessor.value("normalized", false);
    std::vector<double> values;
    values.reserve(count * width);
    for (size_t i = 0; i < count; ++i)
      for (size_t k = 0; k < width; ++k)
        values.push_back(
            component(bytes.data() + begin + i * stride + k * size, static_cast<int>(type), normalised));
    return values;
  }

  static double component(const char* bytes, int type, bool normalised) {
    const auto scaled = [normalised](double value, double largest) {
      return normalised ? std::max(-1.0, value / largest) : value;
    };
    switch (type) {
      case gltf::kFloat:
        return little_endian<float>(bytes);
      case gltf::kByte:
        return scaled(little_endian<std::int8_t>(bytes), 127);
      case gltf::kUnsignedByte:
        return scaled(little_endian<std::uint8_t>(bytes), 255);
      case gltf::kShort:
        return scaled(little_endian<std::int16_t>(bytes), 32767);
      case gltf::kUnsignedShort:
        return scaled(little_endian<std::uint16_t>(bytes), 65535);
      default:
        return little_endian<std::uint32_t>(bytes);
    }
  }

  Json roots() const {
    if (const Json& scenes = list("scenes"); !scenes.empty())
      return entry("scenes", member(json_, "scene", 0)).value("nodes", Json::array());
    std::vector<char> is_child(list("nodes").size(), 0);
    for (const Json& node : list("nodes"))
      if (node.is_object())
        for (const Json& child : node.value("children", Json::array()))
          if (child.is_number_unsigned() && child.get<size_t>() < is_child.size())
            is_child[child.get<size_t>()] = 1;
    Json roots = Json::array();
    for (size_t n = 0; n < is_child.size(); ++n)
      if (!is_child[n]) roots.push_back(n);
    return roots;
  }

  std::vector<double> values_of(const Json& node, const char* name, std::vector<double> standard) const {
    const auto found = node.find(name);
    if (found == node.end()) return standard;
    if (!found->is_array() || found->size() != standard.size())
      fail(concat("'", name, "' of a node has a wrong size"));
    for (size_t k = 0; k < standard.size(); ++k) {
      if (!(*found)[k].is_number()) fail(concat("'", name, "' of a node must hold numbers"));
      standard[k] = (*found)[k].get<double>();
    }
    return standard;
  }

  Eigen::Matrix4d transform_of(const Json& node) const {
    if (node.contains("matrix")) {
      const std::vector<double> m = values_of(node, "matrix", std::vector<double>(16));
      return Eigen::Map<const Eigen::Matrix4d>(m.data());  // by columns, as glTF has it
    }
    const std::vector<double> t = values_of(node, "translation", {0, 0, 0}),
                              r = values_of(node, "rotation", {0, 0, 0, 1}),
                              s = values_of(node, "scale", {1, 1, 1});
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    transform.translate(Eigen::Vector3d(t[0], t[1], t[2]));
    transform.rotate(Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized());
    transform.scale(Eigen::Vector3d(s[0], s[1], s[2]));
    return transform.matrix();
  }

  void walk(size_t number, const Eigen::Matrix4d& above, int depth) {
    if (depth > kDeepest) fail("has nodes within nodes without end");
    const Json& node = entry("nodes", number);
    const Eigen::Matrix4d transform = above * transform_of(node);
    if (node.contains("mesh")) add_mesh(entry("meshes", member(node, "mesh")), transform);
    const Json children = node.value("children", Json::array());
    if (!children.is_array()) fail("the children of a node must be a list");
    if (n_visited_ += children.size(); n_visited_ > 1000000) fail("has more than a million nodes");
    for (const Json& child : children) walk(index(child, "a child of a node"), transform, depth + 1);
  }

  void add_mesh(const Json& mesh, const Eigen::Matrix4d& transform) {
    if (!mesh.is_object()) fail("a mesh must be an object");
    const Json primitives = mesh.value("primitives", Json::array());
    if (!primitives.is_array()) fail("the primitives of a mesh must be a list");
    for (const Json& primitive : primitives) {
      if (!primitive.is_object()) fail("a primitive must be an object");
      add_primitive(primitive, transform);
    }
  }

  void add_primitive(const Json& primitive, const Eigen::Matrix4d& transform) {
    const size_t mode = member(primitive, "mode", gltf::kTriangles);
    if (mode != gltf::kTriangles && mode != gltf::kStrip && mode != gltf::kFan) {
      ++n_other_modes_;
      return;
    }
    const Json attributes = primitive.value("attributes", Json::object());
    if (!attributes.is_object() || !attributes.contains("POSITION")) fail("a primitive has no positions");
    const std::vector<double> positions = numbers(member(attributes, "POSITION"), 3, "positions");
    const size_t n = positions.size() / 3;
    std::vector<double> normals, colours;
    if (attributes.contains("NORMAL")) normals = numbers(member(attributes, "NORMAL"), 3, "normals");
    if (attributes.contains("COLOR_0")) colours = numbers(member(attributes, "COLOR_0"), 3, "colours");
    if ((!normals.empty() && normals.size() != 3 * n) || (!colours.empty() && colours.size() != 3 * n))
      fail("a primitive has normals or colours for other than its positions");
    const std::vector<int> vertices = add_vertices(positions, normals, colours, transform);
    std::vector<size_t> corners;
    if (primitive.contains("indices")) {
      for (const double value : numbers(member(primitive, "indices"), 1, "indices")) {
        if (!(value < static_cast<double>(n)))
          fail(concat("a face names vertex ", value, ", but its primitive has ", n, "; the file is damaged"));
        corners.push_back(static_cast<size_t>(value));
      }
    } else {
      for (size_t i = 0; i < n; ++i) corners.push_back(i);
    }
    const bool turned = transform.topLeftCorner<3, 3>().determinant() < 0;  // mirrored
    const auto face = [&](size_t a, size_t b, size_t c) {
      if (turned) std::swap(b, c);
      add_face(mesh_, {vertices[corners[a]], vertices[corners[b]], vertices[corners[c]]});
    };
    for (size_t i = 2; i < corners.size(); i += mode == gltf::kTriangles ? 3 : 1) {
      if (mode == gltf::kTriangles) face(i - 2, i - 1, i);
      if (mode == gltf::kStrip) i % 2 == 0 ? face(i - 2, i - 1, i) : face(i - 1, i - 2, i);
      if (mode == gltf::kFan) face(0, i - 1, i);
    }
  }

  std::vector<int> add_vertices(const std::vector<double>& positions, const std::vector<double>& normals,
                                const std::vector<double>& colours, const Eigen::Matrix4d& transform) {
    const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
    const Eigen::Matrix3d turn =
        linear.determinant() != 0 ? Eigen::Matrix3d(linear.inverse().transpose()) : linear;
    std::vector<int> vertices;
    for (size_t i = 0; i < positions.size() / 3; ++i) {
      const Eigen::Vector3d p =
          linear * Eigen::Map<const Eigen::Vector3d>(&positions[3 * i]) + transform.topRightCorner<3, 1>();
      if (!p.allFinite()) fail(concat("vertex ", i, " has a coordinate that is not finite"));
      const size_t before = mesh_.positions.size();
      const int vertex = merger_.vertex(p.x(), -p.z(), p.y());
      const bool is_new = mesh_.positions.size() > before;
      vertices.push_back(vertex);
      const auto at = 3 * static_cast<size_t>(vertex);
      if (is_new) {
        normals_.resize(mesh_.positions.size(), 0.0);
        colours_.resize(mesh_.positions.size(), 255.0);
      }
      if (!normals.empty()) {
        Eigen::Vector3d q = turn * Eigen::Map<const Eigen::Vector3d>(&normals[3 * i]);
        q = Eigen::Vector3d(q.x(), -q.z(), q.y()).normalized();
        has_normals_ = true;
        Eigen::Map<Eigen::Vector3d> held(&normals_[at]);
        if (is_new)
          held = q;
        else
          normals_agree_ = normals_agree_ && (held - q).norm() < 1e-5;
      } else {
        normals_agree_ = false;
      }
      for (size_t k = 0; k < 3 && !colours.empty() && is_new; ++k)
        colours_[at + k] = 255 * colours[3 * i + k];
      has_colours_ = has_colours_ || !colours.empty();
    }
    return vertices;
  }

  std::string path_;
  Json json_;
  std::string binary_;
  std::vector<std::string> buffers_;
  RawMesh mesh_;
  ExactMerger merger_;
  std::vector<double> normals_, colours_;
  bool has_normals_ = false, normals_agree_ = true, has_colours_ = false;
  size_t n_other_modes_ = 0, n_visited_ = 0;
};

}  // namespace

bool begins_as_gltf(std::string_view content) {
  if (content.size() >= 4 && little_endian<std::uint32_t>(content.data()) == gltf::kMagic) return true;
  const std::string_view begin = trim(content.substr(0, 20000));
  return !begin.empty() && begin[0] == '{' && begin.find("\"asset\"") != std::string_view::npos &&
         (content.find("\"meshes\"") != std::string_view::npos);
}

RawMesh parse_gltf(std::string_view content, const std::string& path) {
  try {
    return GltfParser(content, path).parse();
  } catch (const Json::exception& error) {  // a member of another type than it must be
    throw FileError(path, 0, concat("is no sound glTF file: ", error.what()));
  }
}

}  // namespace batten::detail
