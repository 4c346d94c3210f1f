#include "objects.hpp"

#include "arrays.hpp"

#include <limits>
#include <memory>
#include <utility>

#include <pybind11/stl.h>

#include "batten/core/choices.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::python {

namespace {

constexpr int kLargest = std::numeric_limits<int>::max();

bool flag_from(py::handle object, const std::string& name) {
  if (PyBool_Check(object.ptr())) return object.cast<bool>();
  if (py::hasattr(object, "dtype") && object.attr("dtype").attr("kind").cast<std::string>() == "b")
    return object.attr("item")().cast<bool>();
  throw InvalidInput(concat(name, " must be True or False, got ", py::repr(object).cast<std::string>()));
}

std::string text_from(py::handle object, const std::string& name) {
  if (object.is_none()) return {};
  if (!py::isinstance<py::str>(object))
    throw InvalidInput(concat(name, " must be text, got ", py::repr(object).cast<std::string>()));
  return object.cast<std::string>();
}

/// A list of as many entries as there are curves, or nothing where it is None.
std::optional<py::list> list_from(py::handle object, std::size_t n, const std::string& name) {
  if (object.is_none()) return std::nullopt;
  py::list list;
  try {
    list = py::list(py::reinterpret_borrow<py::object>(object));
  } catch (py::error_already_set&) {
    throw InvalidInput(concat(name, " must be a list of ", n, " entries"));
  }
  if (list.size() != n) throw InvalidInput(concat(name, " must have ", n, " entries, got ", list.size()));
  return list;
}

py::object given(py::handle object, const char* name) {
  return py::getattr(object, name);
}

constexpr auto choices_of(TangentConvention) {
  return choices<TangentConvention>("tangent convention", {{TangentConvention::Auto, "auto"},
                                                           {TangentConvention::AtSample, "at-sample"},
                                                           {TangentConvention::ToNext, "to-next"}});
}

TangentConvention tangents_from(const std::string& word) {
  constexpr auto table = choices_of(TangentConvention{});
  if (const auto found = table.find(word)) return *found;
  throw InvalidInput(concat("tangents must be auto, at-sample or to-next, got '", word, "'"));
}

ScanCurve scan_curve_from(py::handle curve, const std::string& name) {
  ScanCurve result;
  result.name = text_from(given(curve, "name"), name + ".name");
  result.boundary = flag_from(given(curve, "boundary"), name + ".boundary");
  result.closed = flag_from(given(curve, "closed"), name + ".closed");
  result.sharp = flag_from(given(curve, "sharp"), name + ".sharp");
  result.distances = numbers_from(given(curve, "distances"), -1, name + ".distances");
  const Eigen::Index n = result.distances.size();
  const auto vectors = [&](const char* field) {
    Points points = points_from(given(curve, field), concat(name, ".", field));
    if (points.rows() != n)
      throw InvalidInput(
          concat(name, ".", field, " must have ", n, " rows, one for each distance, got ", points.rows()));
    return points;
  };
  result.tangents = vectors("tangents");
  result.normals = vectors("normals");
  result.node_readings = integers_from(given(curve, "node_readings"), 0, n - 1, name + ".node_readings");
  result.node_ids = integers_from(given(curve, "node_ids"), kNoNodeNumber, kLargest, name + ".node_ids");
  if (result.node_ids.size() != result.node_readings.size())
    throw InvalidInput(concat(name, ".node_ids must have one entry for each of the ",
                              result.node_readings.size(), " node_readings, got ", result.node_ids.size()));
  result.turns = points_or_none(given(curve, "turns"), n, name + ".turns", Missing::Allowed);
  if (!given(curve, "turn_times").is_none())
    result.turn_times = numbers_from(given(curve, "turn_times"), n, name + ".turn_times", Missing::Allowed);
  return result;
}

py::dict curve_fields(ScanCurve&& curve) {
  py::dict fields;
  fields["name"] = curve.name;
  fields["boundary"] = curve.boundary;
  fields["closed"] = curve.closed;
  fields["sharp"] = curve.sharp;
  fields["distances"] = owned(std::move(curve.distances));
  fields["tangents"] = owned(std::move(curve.tangents));
  fields["normals"] = owned(std::move(curve.normals));
  fields["node_readings"] = owned(std::move(curve.node_readings));
  fields["node_ids"] = owned(std::move(curve.node_ids));
  fields["turns"] = owned_or_none(std::move(curve.turns));
  fields["turn_times"] =
      curve.turn_times.size() == 0 ? py::object(py::none()) : owned(std::move(curve.turn_times));
  return fields;
}

/// Faces of one size as an array, which is quick, or of several as a list.
void read_faces(const py::object& faces, Eigen::Index n, PolygonMesh& mesh) {
  if (py::isinstance<py::array>(faces) && faces.attr("ndim").cast<int>() == 2) {
    const auto columns = faces.attr("shape").attr("__getitem__")(1).cast<int>();
    mesh.corners = integers_from(faces.attr("reshape")(-1), 0, n - 1, "faces", columns);
    if (columns > 0)
      for (int end = columns; end <= static_cast<int>(mesh.corners.size()); end += columns)
        mesh.offsets.push_back(end);
    return;
  }
  py::list list;
  try {
    list = py::list(faces);
  } catch (py::error_already_set&) {
    throw InvalidInput("faces must be a list with the vertices of each face");
  }
  for (std::size_t f = 0; f < list.size(); ++f) {
    if (f % 1024 == 0 && PyErr_CheckSignals() != 0) throw py::error_already_set();
    const std::vector<int> corners = integers_from(list[f], 0, n - 1, concat("faces[", f, "]"));
    mesh.corners.insert(mesh.corners.end(), corners.begin(), corners.end());
    mesh.offsets.push_back(static_cast<int>(mesh.corners.size()));
  }
}

Eigen::Vector3d vector_from(py::handle object, const std::string& name) {
  const Eigen::VectorXd numbers = numbers_from(object, 3, name);
  return numbers;
}

}  // namespace

NamedMesh mesh_from(py::handle mesh) {
  NamedMesh result;
  result.name = text_from(given(mesh, "name"), "name");
  TriangleMesh& made = result.file.mesh;
  made.positions = points_from(given(mesh, "positions"), "positions");
  const Eigen::Index n = made.n_vertices();
  made.triangles = triangles_from(given(mesh, "triangles"), n, "triangles");
  made.normals = points_or_none(given(mesh, "normals"), n, "normals");
  for (const auto& [key, value] : given(mesh, "values").cast<py::dict>()) {
    const std::string word = text_from(key, "the name of values");
    // Missing ones occur: distances of vertices that no face uses.
    made.vertex_values[word] = numbers_from(value, n, concat("values[", word, "]"), Missing::Allowed);
  }
  const py::object attributes = given(mesh, "_attributes");
  if (attributes.is_none()) return result;
  MeshAttributes& kept = result.file.attributes = attributes.cast<const Attributes&>().kept;
  // Of other triangles than those that there are now they say nothing.
  const auto m = static_cast<std::size_t>(made.n_triangles());
  for (const Eigen::VectorXd& values : kept.face_values)
    if (values.size() != made.n_triangles()) {
      kept.face_properties.clear();
      kept.face_values.clear();
      break;
    }
  for (MeshAttributes::Labels* labels : {&kept.objects, &kept.groups, &kept.materials})
    if (labels->of_face.size() != m) *labels = {};
  if (kept.texture_corners.rows() != made.n_triangles()) {
    kept.texture_corners = Triangles(0, 3);
    kept.texture.resize(0, 2);
  }
  return result;
}

py::dict fields_of(MeshFile&& file) {
  py::dict fields, values;
  fields["positions"] = owned(std::move(file.mesh.positions));
  fields["triangles"] = owned(std::move(file.mesh.triangles));
  fields["normals"] = owned_or_none(std::move(file.mesh.normals));
  for (auto& [name, numbers] : file.mesh.vertex_values) values[py::str(name)] = owned(std::move(numbers));
  fields["values"] = values;
  fields["_attributes"] = py::cast(Attributes{std::move(file.attributes)});
  return fields;
}

KnownNetwork network_from(py::handle object) {
  KnownNetwork result;
  CurveNetwork& network = result.network;
  network.positions = points_from(given(object, "positions"), "positions");
  const Eigen::Index n = network.positions.rows();
  network.normals = points_or_none(given(object, "normals"), n, "normals");
  network.unit = text_from(given(object, "unit"), "unit");
  network.tagged_nodes = integers_from(given(object, "nodes"), 0, n - 1, "nodes");
  py::list curves;
  try {
    curves = py::list(given(object, "curves"));
  } catch (py::error_already_set&) {
    throw InvalidInput("curves must be a list with the vertices of each curve");
  }
  const auto boundary = list_from(given(object, "boundary"), curves.size(), "boundary");
  const auto names = list_from(given(object, "names"), curves.size(), "names");
  const auto sharp = list_from(given(object, "sharp"), curves.size(), "sharp");
  const auto left = list_from(given(object, "left_normals"), curves.size(), "left_normals");
  const auto right = list_from(given(object, "right_normals"), curves.size(), "right_normals");
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const auto entry = [&](const char* list) { return concat(list, "[", c, "]"); };
    NetworkCurve curve;
    curve.vertices = integers_from(curves[c], 0, n - 1, entry("curves"));
    const auto k = static_cast<Eigen::Index>(curve.vertices.size());
    if (boundary) curve.boundary = flag_from((*boundary)[c], entry("boundary"));
    if (names) curve.name = text_from((*names)[c], entry("names"));
    if (sharp) curve.sharp = flag_from((*sharp)[c], entry("sharp"));
    if (left) curve.left_normals = points_or_none((*left)[c], k, entry("left_normals"));
    if (right) curve.right_normals = points_or_none((*right)[c], k, entry("right_normals"));
    network.curves.push_back(std::move(curve));
  }
  if (const py::object uncertainty = given(object, "uncertainty"); !uncertainty.is_none())
    result.uncertainty = numbers_from(uncertainty, n, "uncertainty");
  return result;
}

py::dict fields_of(CurveNetwork&& network) {
  py::dict fields;
  py::list curves, boundary, names, sharp, left, right;
  bool has_sides = false;
  for (NetworkCurve& curve : network.curves) {
    curves.append(owned(std::move(curve.vertices)));
    boundary.append(curve.boundary);
    names.append(curve.name);
    sharp.append(curve.sharp);
    has_sides = has_sides || curve.left_normals.rows() > 0 || curve.right_normals.rows() > 0;
    left.append(owned_or_none(std::move(curve.left_normals)));
    right.append(owned_or_none(std::move(curve.right_normals)));
  }
  fields["positions"] = owned(std::move(network.positions));
  fields["curves"] = curves;
  fields["normals"] = owned_or_none(std::move(network.normals));
  fields["boundary"] = boundary;
  fields["names"] = names;
  fields["sharp"] = sharp;
  fields["left_normals"] = has_sides ? py::object(left) : py::object(py::none());
  fields["right_normals"] = has_sides ? py::object(right) : py::object(py::none());
  fields["nodes"] = owned(std::move(network.tagged_nodes));
  fields["unit"] = network.unit;
  return fields;
}

Scan scan_from(py::handle object) {
  Scan scan;
  scan.unit = text_from(given(object, "unit"), "unit");
  scan.tangents = tangents_from(text_from(given(object, "tangents"), "tangents"));
  py::list curves;
  try {
    curves = py::list(given(object, "curves"));
  } catch (py::error_already_set&) {
    throw InvalidInput("curves must be a list of ScanCurve");
  }
  const py::object kind = py::module_::import("batten").attr("ScanCurve");
  for (std::size_t c = 0; c < curves.size(); ++c) {
    if (!py::isinstance(curves[c], kind)) throw InvalidInput(concat("curves[", c, "] must be a ScanCurve"));
    scan.curves.push_back(scan_curve_from(curves[c], concat("curves[", c, "]")));
  }
  return scan;
}

py::dict fields_of(Scan&& scan) {
  py::dict fields;
  py::list curves;
  for (ScanCurve& curve : scan.curves) curves.append(curve_fields(std::move(curve)));
  fields["curves"] = curves;
  fields["unit"] = scan.unit;
  fields["tangents"] = std::string(choices_of(TangentConvention{}).word(scan.tangents));
  return fields;
}

SensorLog log_from(py::handle object) {
  SensorLog log;
  log.time = numbers_from(given(object, "time"), -1, "time", Missing::Allowed);
  const Eigen::Index n = log.time.size();
  const py::list curves = given(object, "curves");
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const std::string name = concat("curves[", c, "]");
    const auto curve = curves[c].cast<py::dict>();
    LogCurve made;
    made.number =
        static_cast<int>(integers_from(py::make_tuple(curve["number"]), 0, kLargest, name + "['number']")[0]);
    made.name = text_from(curve["name"], name + "['name']");
    made.boundary = flag_from(curve["boundary"], name + "['boundary']");
    made.closed = flag_from(curve["closed"], name + "['closed']");
    made.sharp = flag_from(curve["sharp"], name + "['sharp']");
    log.curves.push_back(made);
  }
  const auto numbers = [&](const char* field, long long most) {
    std::vector<int> list = integers_from(given(object, field), SensorLog::kNone, most, field);
    if (static_cast<Eigen::Index>(list.size()) != n)
      throw InvalidInput(concat(field, " must have ", n, " entries, one for each time, got ", list.size()));
    return list;
  };
  log.curve = numbers("curve", static_cast<long long>(curves.size()) - 1);
  log.node = numbers("node", kLargest);
  log.distance = numbers_from(given(object, "distance"), n, "distance", Missing::Allowed);
  const auto vectors = [&](const char* field) {
    Points points = points_from(given(object, field), field, Missing::Allowed);
    if (points.rows() != n) throw InvalidInput(concat(field, " must have ", n, " rows, got ", points.rows()));
    return points;
  };
  log.accelerometer = vectors("accelerometer");
  log.magnetometer = vectors("magnetometer");
  log.gyroscope = vectors("gyroscope");
  log.axes.forward = vector_from(given(object, "forward"), "forward");
  log.axes.normal = vector_from(given(object, "normal"), "normal");
  return log;
}

py::dict fields_of(SensorLog&& log) {
  py::dict fields;
  py::list curves;
  for (const LogCurve& curve : log.curves) {
    py::dict entry;
    entry["number"] = curve.number;
    entry["name"] = curve.name;
    entry["boundary"] = curve.boundary;
    entry["closed"] = curve.closed;
    entry["sharp"] = curve.sharp;
    curves.append(entry);
  }
  fields["time"] = owned(std::move(log.time));
  fields["curves"] = curves;
  fields["curve"] = owned(std::move(log.curve));
  fields["node"] = owned(std::move(log.node));
  fields["distance"] = owned(std::move(log.distance));
  fields["accelerometer"] = owned(std::move(log.accelerometer));
  fields["magnetometer"] = owned(std::move(log.magnetometer));
  fields["gyroscope"] = owned(std::move(log.gyroscope));
  fields["forward"] = owned(Eigen::VectorXd(log.axes.forward));
  fields["normal"] = owned(Eigen::VectorXd(log.axes.normal));
  return fields;
}

ControlCage cage_from(py::handle object) {
  ControlCage cage;
  cage.mesh.positions = points_from(given(object, "positions"), "positions");
  const Eigen::Index n = cage.mesh.positions.rows();
  read_faces(given(object, "faces"), n, cage.mesh);
  // Pairs of what is sharp and how much; infinity is for ever.
  const auto sharpness = [](py::handle value, const std::string& name) {
    double number = 0;
    try {
      number = value.cast<double>();
    } catch (py::cast_error&) {
      number = std::numeric_limits<double>::quiet_NaN();
    }
    if (!(number >= 0))
      throw InvalidInput(concat(name, " must be at least 0, got ", py::repr(value).cast<std::string>()));
    return number;
  };
  const auto edge = [&](py::handle key, const std::string& name) {
    const std::vector<int> ends = integers_from(key, 0, n - 1, name);
    if (ends.size() != 2) throw InvalidInput(concat(name, " must name two vertices, got ", ends.size()));
    return std::pair(ends[0], ends[1]);
  };
  for (const auto& [key, value] : given(object, "sharp_edges").cast<py::dict>()) {
    const std::string name = concat("sharp_edges[", py::repr(key).cast<std::string>(), "]");
    const auto [from, to] = edge(key, name);
    cage.sharp_edges.push_back({from, to, sharpness(value, name)});
  }
  for (const auto& [key, value] : given(object, "sharp_vertices").cast<py::dict>()) {
    const std::string name = concat("sharp_vertices[", py::repr(key).cast<std::string>(), "]");
    cage.sharp_vertices.push_back(
        {integers_from(py::make_tuple(key), 0, n - 1, name)[0], sharpness(value, name)});
  }
  for (const auto& [key, value] : given(object, "polylines").cast<py::dict>()) {
    const std::string name = concat("polylines[", py::repr(key).cast<std::string>(), "]");
    const auto [from, to] = edge(key, name);
    cage.polylines.push_back({from, to, points_from(value, name)});
  }
  return cage;
}

py::dict fields_of(ControlCage&& cage) {
  py::dict fields, edges, vertices, polylines;
  const std::vector<int>& offsets = cage.mesh.offsets;
  const auto m = static_cast<std::size_t>(cage.mesh.n_faces());
  bool all_quads = m > 0;
  for (std::size_t f = 0; f < m; ++f) all_quads = all_quads && offsets[f + 1] - offsets[f] == 4;
  if (all_quads) {
    fields["faces"] = owned(std::move(cage.mesh.corners)).attr("reshape")(static_cast<py::ssize_t>(m), 4);
  } else {
    py::list faces;
    for (std::size_t f = 0; f < m; ++f)
      faces.append(owned(std::vector<int>(cage.mesh.corners.begin() + offsets[f],
                                          cage.mesh.corners.begin() + offsets[f + 1])));
    fields["faces"] = faces;
  }
  fields["positions"] = owned(std::move(cage.mesh.positions));
  for (const SharpEdge& sharp : cage.sharp_edges)
    edges[py::make_tuple(sharp.from, sharp.to)] = sharp.sharpness;
  for (const SharpVertex& sharp : cage.sharp_vertices) vertices[py::int_(sharp.vertex)] = sharp.sharpness;
  for (EdgePolyline& line : cage.polylines)
    polylines[py::make_tuple(line.from, line.to)] = owned(std::move(line.points));
  fields["sharp_edges"] = edges;
  fields["sharp_vertices"] = vertices;
  fields["polylines"] = polylines;
  return fields;
}

bool is_mesh(py::handle object) {
  const py::module_ package = py::module_::import("batten");
  if (py::isinstance(object, package.attr("Mesh"))) return true;
  if (py::isinstance(object, package.attr("Network"))) return false;
  throw InvalidInput("must be a Mesh, a Network or a pair of positions and triangles, got " +
                     py::repr(py::type::handle_of(object)).cast<std::string>());
}

void add_objects(py::module_& module) {
  py::class_<Attributes>(module, "Attributes",
                         "What a file says of a mesh beyond its arrays; kept for writing.");
}

}  // namespace batten::python
