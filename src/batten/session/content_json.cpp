#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/content_json_detail.hpp"
#include "batten/session/json_fields_detail.hpp"

namespace batten::detail {

namespace {

constexpr auto tangent_words(TangentConvention) {
  return choices<TangentConvention>("convention of tangents", {{TangentConvention::Auto, "auto"},
                                                               {TangentConvention::AtSample, "at-sample"},
                                                               {TangentConvention::ToNext, "to-next"}});
}

Eigen::VectorXd vector_of(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

const Json::List& list_of(const Fields& fields, const std::string& name) {
  static const Json::List kNone;
  const Json& value = fields.require(name);
  if (value.is_list() && value.size() == 0) return kNone;
  const auto* list = value.get<Json::List>();
  if (!list) fields.fail(name, "a list of objects");
  return *list;
}

Json json_of_scan(const Scan& scan) {
  Json::List curves;
  for (const ScanCurve& curve : scan.curves) curves.push_back(json_of(curve));
  Json json;
  json.add("tangents", tangent_words(scan.tangents).word(scan.tangents));
  json.add("curves", std::move(curves));
  return json;
}

Scan scan_of(const Json& json) {
  const Fields fields(json, "the scan", {"tangents", "curves"});
  Scan scan;
  const std::string& word = fields.text_of(fields.require("tangents"), "tangents");
  const auto convention = tangent_words(TangentConvention::Auto).find(word);
  if (!convention) fields.fail("tangents", "\"auto\", \"at-sample\" or \"to-next\"");
  scan.tangents = *convention;
  for (const Json& stored : list_of(fields, "curves"))
    scan.curves.push_back(scan_curve_of(stored, concat("curve ", scan.curves.size() + 1, " of the scan")));
  return scan;
}

Json json_of_network(const CurveNetwork& network) {
  Json json;
  json.add("positions", flat_list(network.positions));
  json.add("normals", flat_list(network.normals));
  Json::List curves;
  for (const NetworkCurve& curve : network.curves) {
    Json stored;
    stored.add("name", curve.name);
    stored.add("boundary", curve.boundary);
    stored.add("vertices", flat_list(curve.vertices));
    curves.push_back(std::move(stored));
  }
  json.add("curves", std::move(curves));
  json.add("tagged_nodes", flat_list(network.tagged_nodes));
  return json;
}

CurveNetwork network_of(const Json& json) {
  const Fields fields(json, "the network", {"positions", "normals", "curves", "tagged_nodes"});
  CurveNetwork network;
  network.positions = fields.rows(fields.require("positions"), "positions");
  network.normals = fields.rows(fields.require("normals"), "normals");
  network.tagged_nodes = fields.integers(fields.require("tagged_nodes"), "tagged_nodes");
  for (const Json& stored : list_of(fields, "curves")) {
    const Fields curve(stored, concat("curve ", network.curves.size(), " of the network"),
                       {"name", "boundary", "vertices"});
    network.curves.push_back({curve.text_of(curve.require("name"), "name"), curve.flag("boundary"),
                              curve.integers(curve.require("vertices"), "vertices")});
  }
  return network;
}

Json json_of_mesh(const TriangleMesh& mesh) {
  Json json;
  json.add("positions", flat_list(mesh.positions));
  json.add("triangles", Json::Numbers(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size()));
  json.add("normals", flat_list(mesh.normals));
  Json values = Json::Object();
  for (const auto& [name, numbers] : mesh.vertex_values) values.add(name, flat_list(numbers));
  json.add("vertex_values", std::move(values));
  return json;
}

TriangleMesh mesh_of(const Json& json) {
  const Fields fields(json, "the mesh", {"positions", "triangles", "normals", "vertex_values"});
  TriangleMesh mesh;
  mesh.positions = fields.rows(fields.require("positions"), "positions");
  mesh.normals = fields.rows(fields.require("normals"), "normals");
  const std::vector<int> corners = fields.integers(fields.require("triangles"), "triangles");
  if (corners.size() % 3 != 0) fields.fail("triangles", "a list of 3 m whole numbers");
  mesh.triangles =
      Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  const auto* values = fields.require("vertex_values").get<Json::Object>();
  if (!values) fields.fail("vertex_values", "an object of lists");
  for (const auto& [name, numbers] : *values)
    mesh.vertex_values[name] = vector_of(fields.numbers(numbers, name));
  return mesh;
}

Json json_of_sensor(const SensorCalibration& sensor) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = sensor.matrix;
  Json json;
  json.add("offset", flat_list(sensor.offset));
  json.add("matrix", Json::Numbers(rows.data(), rows.data() + rows.size()));
  return json;
}

SensorCalibration sensor_of(const Json& json, const std::string& what) {
  const Fields fields(json, what, {"offset", "matrix"});
  const Points matrix = fields.rows(fields.require("matrix"), "matrix");
  if (matrix.rows() != 3) fields.fail("matrix", "9 numbers, row by row");
  return {fields.vector(fields.require("offset"), "offset"), matrix};
}

Json json_of_calibration(const Calibration& calibration) {
  Json json;
  json.add("accelerometer", json_of_sensor(calibration.accelerometer));
  json.add("magnetometer", json_of_sensor(calibration.magnetometer));
  json.add("gyroscope_bias", flat_list(calibration.gyroscope_bias));
  return json;
}

Calibration calibration_of(const Json& json) {
  const Fields fields(json, "the calibration", {"accelerometer", "magnetometer", "gyroscope_bias"});
  return {sensor_of(fields.require("accelerometer"), "the accelerometer"),
          sensor_of(fields.require("magnetometer"), "the magnetometer"),
          fields.vector(fields.require("gyroscope_bias"), "gyroscope_bias")};
}

Json json_of_view(const ViewState& view) {
  Json json;
  json.add("azimuth", view.azimuth);
  json.add("elevation", view.elevation);
  json.add("up", word_of(view.up));
  json.add("perspective", view.perspective);
  json.add("zoom", view.zoom);
  json.add("target", view.target ? flat_list(*view.target) : Json());
  json.add("shading", word_of(view.shading));
  Json::List hidden;
  for (const ObjectId id : view.hidden) hidden.emplace_back(id_text('o', id.number));
  json.add("hidden", std::move(hidden));
  return json;
}

ViewState view_of(const Json& json) {
  const Fields fields(json, "the view",
                      {"azimuth", "elevation", "up", "perspective", "zoom", "target", "shading", "hidden"});
  ViewState view;
  view.azimuth = fields.number("azimuth", view.azimuth);
  view.elevation = fields.number("elevation", view.elevation);
  if (const Json* up = fields.find("up")) view.up = fields.choice<UpAxis>(*up, "up");
  if (const Json* perspective = fields.find("perspective"))
    view.perspective = fields.flag_of(*perspective, "perspective");
  view.zoom = fields.number("zoom", view.zoom);
  if (const Json* target = fields.find("target"); target && !target->is_null())
    view.target = fields.vector(*target, "target");
  if (const Json* shading = fields.find("shading"))
    view.shading = fields.choice<ViewShading>(*shading, "shading");
  if (const Json* hidden = fields.find("hidden")) {
    if (!hidden->is_list()) fields.fail("hidden", "a list of ids of objects");
    for (std::size_t i = 0; i < hidden->size(); ++i)
      view.hidden.push_back({fields.id_of(hidden->at(i), "hidden", 'o', "a list such as [\"o3\"]")});
  }
  return view;
}

Json json_of_held(const SharedScan& scan) {
  return json_of_scan(*scan);
}
Json json_of_held(const SharedNetwork& network) {
  return json_of_network(*network);
}
Json json_of_held(const SharedModel& model) {
  return model ? json_of_model(*model) : Json(Json::Object());
}
Json json_of_held(const SharedMesh& mesh) {
  return json_of_mesh(*mesh);
}
Json json_of_held(const Calibration& calibration) {
  return json_of_calibration(calibration);
}
Json json_of_held(const ViewState& view) {
  return json_of_view(view);
}

}  // namespace

Json json_of(const ScanCurve& curve) {
  Json json;
  json.add("name", curve.name);
  json.add("boundary", curve.boundary);
  json.add("closed", curve.closed);
  json.add("node_readings", flat_list(curve.node_readings));
  json.add("node_ids", flat_list(curve.node_ids));
  json.add("distances", flat_list(curve.distances));
  json.add("tangents", flat_list(curve.tangents));
  json.add("normals", flat_list(curve.normals));
  return json;
}

ScanCurve scan_curve_of(const Json& json, const std::string& what) {
  const Fields fields(
      json, what,
      {"name", "boundary", "closed", "node_readings", "node_ids", "distances", "tangents", "normals"});
  ScanCurve curve;
  curve.name = fields.text_of(fields.require("name"), "name");
  curve.boundary = fields.flag("boundary");
  curve.closed = fields.flag("closed");
  curve.node_readings = fields.integers(fields.require("node_readings"), "node_readings");
  curve.node_ids = fields.integers(fields.require("node_ids"), "node_ids");
  curve.distances = vector_of(fields.numbers(fields.require("distances"), "distances"));
  curve.tangents = fields.rows(fields.require("tangents"), "tangents");
  curve.normals = fields.rows(fields.require("normals"), "normals");
  return curve;
}

Json json_of(const Content& content) {
  return std::visit([](const auto& held) { return json_of_held(held); }, content);
}

Content content_of(ObjectKind kind, const Json& json) {
  switch (kind) {
    case ObjectKind::Scan:
      return std::make_shared<const Scan>(scan_of(json));
    case ObjectKind::Network:
      return std::make_shared<const CurveNetwork>(network_of(json));
    case ObjectKind::Model:
      return json.size() == 0 ? SharedModel() : std::make_shared<const PolylineMesh>(model_of(json));
    case ObjectKind::Mesh:
      return std::make_shared<const TriangleMesh>(mesh_of(json));
    case ObjectKind::Calibration:
      return calibration_of(json);
    case ObjectKind::View:
      break;
  }
  return view_of(json);
}

}  // namespace batten::detail
