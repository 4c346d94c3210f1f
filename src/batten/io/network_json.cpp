#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_formats_detail.hpp"
#include "batten/mesh/normals.hpp"

namespace batten::detail {

namespace {

using Json = nlohmann::json;

constexpr const char* kFormatName = "batten-network";

/// A member of an object, with the place of both for the errors.
class Node {
 public:
  Node(const Json& json, std::string place, const std::string& path)
      : json_(&json), place_(std::move(place)), path_(&path) {}

  bool has(const char* key) const { return json_->is_object() && json_->contains(key); }
  size_t size() const { return json_->size(); }

  Node at(const char* key) const {
    if (!has(key)) fail(concat("has no '", key, "'"));
    return {json_->at(key), place_.empty() ? key : concat(place_, ".", key), *path_};
  }
  Node at(size_t index) const { return {json_->at(index), concat(place_, "[", index, "]"), *path_}; }
  const Node& array() const {
    if (!json_->is_array()) fail("must be a list");
    return *this;
  }
  std::string text() const {
    if (!json_->is_string()) fail("must be a text");
    return json_->get<std::string>();
  }
  bool boolean() const {
    if (!json_->is_boolean()) fail("must be true or false");
    return json_->get<bool>();
  }
  double number() const {
    if (!json_->is_number()) fail("must be a number");
    const double value = json_->get<double>();
    if (!std::isfinite(value)) fail("must be a finite number");
    return value;
  }
  int index(int low, Eigen::Index high) const {
    if (!json_->is_number_integer()) fail("must be an integer");
    const double value = json_->get<double>();  // wide enough to compare any integer
    if (value < low || value > static_cast<double>(high))
      fail(concat("is ", value, ", expected ", low, " to ", high));
    return static_cast<int>(value);
  }
  Points points() const {
    array();
    Points points(static_cast<Eigen::Index>(size()), 3);
    for (size_t i = 0; i < size(); ++i) {
      const Json& row = (*json_)[i];
      if (!row.is_array() || row.size() != 3) at(i).fail("must be a list of three numbers");
      for (size_t k = 0; k < 3; ++k) {
        if (!row[k].is_number()) at(i).at(k).fail("must be a number");
        const double value = row[k].get<double>();
        if (!std::isfinite(value)) at(i).at(k).fail("must be a finite number");
        points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = value;
      }
    }
    return points;
  }

  [[noreturn]] void fail(std::string_view problem) const {
    throw FileError(*path_, 0, concat(place_.empty() ? "the file" : "'" + place_ + "'", " ", problem));
  }

 private:
  const Json* json_;
  std::string place_;
  const std::string* path_;
};

Json parsed(const std::string& content, const std::string& path) {
  try {
    return Json::parse(content);
  } catch (const Json::parse_error& error) {
    const size_t stop = std::min(content.size(), error.byte > 0 ? error.byte - 1 : size_t{0});
    const auto line =
        1 + std::count(content.begin(), content.begin() + static_cast<std::ptrdiff_t>(stop), '\n');
    throw FileError(path, static_cast<long>(line),
                    stop >= content.size() ? "the JSON text ends too early; the file is truncated"
                                           : "this is no valid JSON; is the file damaged?");
  } catch (const Json::exception&) {  // a number that no double holds
    throw FileError(path, 0, "holds a number out of range");
  }
}

/// The normals on one side of a sharp curve: unit, one per vertex, or none.
Points side_normals(const Node& curve, const char* key, size_t count) {
  if (!curve.has(key)) return Points(0, 3);
  const Node node = curve.at(key);
  Points normals = node.points();
  if (normals.rows() != 0 && static_cast<size_t>(normals.rows()) != count)
    node.fail(concat("has ", normals.rows(), " rows for ", count, " vertices"));
  for (Eigen::Index k = 0; k < normals.rows(); ++k) {
    if (!(normals.row(k).squaredNorm() > 0)) node.at(static_cast<size_t>(k)).fail("has length 0");
    if (std::abs(normals.row(k).squaredNorm() - 1) > 1e-12) normals.row(k).normalize();
  }
  return normals;
}

CurveNetwork read_own(const Node& root) {
  if (const Node version = root.at("version"); version.number() != 1)
    version.fail("is not 1; the file is from a newer program");
  CurveNetwork network;
  network.positions = root.at("positions").points();
  const Eigen::Index n = network.positions.rows();
  if (root.has("normals")) {
    const Node normals = root.at("normals");
    network.normals = normals.points();
    if (network.normals.rows() != 0 && network.normals.rows() != n)
      normals.fail(concat("has ", network.normals.rows(), " rows for ", n, " positions"));
  }
  if (root.has("unit")) network.unit = root.at("unit").text();
  const Node curves = root.at("curves").array();
  for (size_t c = 0; c < curves.size(); ++c) {
    const Node node = curves.at(c);
    NetworkCurve curve;
    if (node.has("name")) curve.name = node.at("name").text();
    if (node.has("boundary")) curve.boundary = node.at("boundary").boolean();
    const Node vertices = node.at("vertices").array();
    if (vertices.size() < 2) vertices.fail("needs at least two vertices");
    for (size_t k = 0; k < vertices.size(); ++k) curve.vertices.push_back(vertices.at(k).index(0, n - 1));
    if (node.has("sharp")) curve.sharp = node.at("sharp").boolean();
    curve.left_normals = side_normals(node, "left_normals", curve.vertices.size());
    curve.right_normals = side_normals(node, "right_normals", curve.vertices.size());
    network.curves.push_back(std::move(curve));
  }
  if (root.has("tagged_nodes")) {
    const Node nodes = root.at("tagged_nodes").array();
    for (size_t k = 0; k < nodes.size(); ++k) network.tagged_nodes.push_back(nodes.at(k).index(0, n - 1));
  }
  return network;
}

/// The mesh that curves on a mesh refer to: `A.obj` for `A_curves.json`, or the one named by "shape".
std::string mesh_beside(const std::string& path, const std::string& shape) {
  namespace fs = std::filesystem;
  const fs::path file(path);
  std::string stem = file.stem().string();
  constexpr std::string_view kSuffix = "_curves";
  if (stem.size() > kSuffix.size() && std::string_view(stem).substr(stem.size() - kSuffix.size()) == kSuffix)
    stem.resize(stem.size() - kSuffix.size());
  // Only the last part of the name: a file must not point out of its folder.
  const std::string safe_shape = fs::path(shape).filename().string();
  for (const std::string& name : {stem, safe_shape})
    for (const char* extension : {".obj", ".ply", ".off"}) {
      const fs::path candidate = file.parent_path() / (name + extension);
      std::error_code error;
      if (!name.empty() && fs::is_regular_file(candidate, error)) return candidate.string();
    }
  throw FileError(path, 0, concat("holds curves on a mesh, which must stand beside it as ", stem, ".obj"));
}

RawNetwork read_curves_on_mesh(const Node& root, const std::string& path) {
  RawNetwork raw;
  const std::string mesh_path = mesh_beside(path, root.has("shape") ? root.at("shape").text() : "");
  TriangleMesh mesh = read_mesh(mesh_path);
  const Points normals =
      mesh.normals.rows() > 0 ? mesh.normals : vertex_normals(mesh.positions, mesh.triangles);
  const Node curves = root.at("SS").array();
  std::vector<Eigen::RowVector3d> positions, curve_normals;
  for (size_t c = 0; c < curves.size(); ++c) {
    const Node faces = curves.at(c).at("FI").array(), weights = curves.at(c).at("B").array();
    if (faces.size() != weights.size() || faces.size() < 2)
      curves.at(c).fail(
          concat("has ", faces.size(), " faces (FI) and ", weights.size(),
                 " rows of barycentric coordinates (B), expected as many of both and at least two"));
    NetworkCurve curve;
    curve.name = concat("curve ", c);
    for (size_t k = 0; k < faces.size(); ++k) {
      const int face = faces.at(k).index(1, mesh.n_triangles()) - 1;
      const Node row = weights.at(k).array();
      if (row.size() != 3) row.fail("must be a list of three numbers");
      Eigen::RowVector3d position = Eigen::RowVector3d::Zero(), normal = Eigen::RowVector3d::Zero();
      for (int corner = 0; corner < 3; ++corner) {
        const double weight = row.at(static_cast<size_t>(corner)).number();
        position += weight * mesh.positions.row(mesh.triangles(face, corner));
        normal += weight * normals.row(mesh.triangles(face, corner));
      }
      if (!(normal.norm() > 0)) row.fail("has no normal there; is the mesh folded?");
      if (!curve.vertices.empty()) {
        if (position == positions.back()) continue;  // the walk rests
        if (k + 1 == faces.size() && curve.vertices.size() > 2 &&
            position == positions[static_cast<size_t>(curve.vertices.front())]) {
          curve.vertices.push_back(curve.vertices.front());
          continue;
        }
      }
      curve.vertices.push_back(static_cast<int>(positions.size()));
      positions.push_back(position);
      curve_normals.push_back(normal.normalized());
    }
    if (curve.vertices.size() < 2) curves.at(c).fail("has fewer than two different points");
    raw.network.curves.push_back(std::move(curve));
  }
  raw.network.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
  raw.network.normals.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (size_t i = 0; i < positions.size(); ++i) {
    raw.network.positions.row(static_cast<Eigen::Index>(i)) = positions[i];
    raw.network.normals.row(static_cast<Eigen::Index>(i)) = curve_normals[i];
  }
  raw.warnings.push_back(
      concat("the curves lie on ", mesh_path, "; where they cross they share no vertex (see --weld)"));
  return raw;
}

void append_rows(std::string& text, const Points& rows) {
  text += '[';
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    text += i > 0 ? ",\n  [" : "\n  [";
    for (int k = 0; k < 3; ++k) {
      if (k > 0) text += ", ";
      text += exact_decimal(rows(i, k));
    }
    text += ']';
  }
  text += ']';
}

void append_integers(std::string& text, const std::vector<int>& values) {
  text += '[';
  for (size_t k = 0; k < values.size(); ++k) {
    if (k > 0) text += ", ";
    text += std::to_string(values[k]);
  }
  text += ']';
}

/// JSON text is UTF-8; bytes of a name that are not become U+FFFD.
std::string json_text(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

RawNetwork parse_json_network(const std::string& content, const std::string& path) {
  const Json json = parsed(content, path);
  const Node root(json, "", path);
  if (root.has("SS")) return read_curves_on_mesh(root, path);
  if (!root.has("format") || root.at("format").text() != kFormatName)
    root.fail(concat("is no curve network; expected an object with \"format\": \"", kFormatName,
                     "\" (see docs/files.md)"));
  RawNetwork raw;
  raw.network = read_own(root);
  return raw;
}

Eigen::VectorXd parse_json_uncertainty(const std::string& content, const std::string& path) {
  const Json json = parsed(content, path);
  const Node root(json, "", path);
  if (!root.has("uncertainty")) return {};
  const Node values = root.at("uncertainty").array();
  const size_t n = root.at("positions").array().size();
  if (values.size() != n) values.fail(concat("has ", values.size(), " values for ", n, " positions"));
  Eigen::VectorXd uncertainty(static_cast<Eigen::Index>(n));
  for (size_t v = 0; v < n; ++v) {
    const double value = values.at(v).number();
    if (value < 0) values.at(v).fail("must be at least 0");
    uncertainty[static_cast<Eigen::Index>(v)] = value;
  }
  return uncertainty;
}

std::string json_network_text(const CurveNetwork& network, const Eigen::VectorXd& uncertainty) {
  std::string text =
      concat("{\n \"format\": \"", kFormatName, "\",\n \"version\": 1,\n \"unit\": ", json_text(network.unit),
             ",\n \"positions\": ");
  append_rows(text, network.positions);
  text += ",\n \"normals\": ";
  append_rows(text, network.normals);
  text += ",\n \"curves\": [";
  for (size_t c = 0; c < network.curves.size(); ++c) {
    const NetworkCurve& curve = network.curves[c];
    text += concat(c > 0 ? ",\n  {\"name\": " : "\n  {\"name\": ", json_text(curve.name),
                   ", \"boundary\": ", curve.boundary ? "true" : "false", ", \"vertices\": ");
    append_integers(text, curve.vertices);
    if (curve.sharp) text += ", \"sharp\": true";
    if (curve.left_normals.rows() > 0) append_rows(text += ", \"left_normals\": ", curve.left_normals);
    if (curve.right_normals.rows() > 0) append_rows(text += ", \"right_normals\": ", curve.right_normals);
    text += '}';
  }
  text += "],\n \"tagged_nodes\": ";
  append_integers(text, network.tagged_nodes);
  if (uncertainty.size() > 0) {
    text += ",\n \"uncertainty\": [";
    for (Eigen::Index v = 0; v < uncertainty.size(); ++v)
      text += (v > 0 ? ", " : "") + exact_decimal(uncertainty[v]);
    text += ']';
  }
  return text + "\n}\n";
}

}  // namespace batten::detail
