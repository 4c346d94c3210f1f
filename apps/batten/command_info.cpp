#include "command.hpp"
#include "model_file.hpp"
#include "stroke_arguments.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/network/diagnosis.hpp"
#include "batten/operators/mesh_variation.hpp"
#include "batten/pipeline/repaired_mesh.hpp"

namespace batten::cli {

namespace {

Json row_json(const Eigen::RowVector3d& row) {
  return {row(0), row(1), row(2)};
}

/// Numbers as a person reads them: "12 vertices", "1 face".
std::string counted(long n, const std::string& one, const std::string& many) {
  return concat(n, " ", n == 1 ? one : many);
}

void add_box(const Points& positions, Outcome& outcome) {
  if (positions.rows() == 0) return;
  outcome.figures["diameter"] = bounding_box_diagonal(positions);
  outcome.figures["box_min"] = row_json(positions.colwise().minCoeff());
  outcome.figures["box_max"] = row_json(positions.colwise().maxCoeff());
  outcome.lines.push_back(concat("diameter ", bounding_box_diagonal(positions)));
}

/// What is found out about a mesh before anything is said.
struct MeshFindings {
  MeshTopology topology;
  MeshQuality quality;
  std::vector<int> degenerate, folded;
  std::vector<std::pair<int, int>> crossings;
};

MeshFindings examine(const TriangleMesh& mesh, StageTimes& times) {
  MeshFindings found;
  {
    ScopedStage stage(times, "topology");
    found.topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  }
  {
    ScopedStage stage(times, "quality");
    found.quality = mesh_quality(mesh.positions, mesh.triangles);
    found.degenerate = degenerate_triangles(mesh.positions, mesh.triangles);
    if (mesh.normals.rows() > 0)
      found.folded = folded_triangles(mesh.positions, mesh.triangles, mesh.normals);
  }
  {
    ScopedStage stage(times, "self-intersections");
    found.crossings = self_intersections(mesh.positions, mesh.triangles, kMostListedIntersections);
  }
  return found;
}

void add_mesh_topology(const TriangleMesh& mesh, const MeshTopology& topology, Outcome& outcome) {
  Json& f = outcome.figures;
  f["edges"] = topology.n_edges;
  f["components"] = topology.n_components;
  f["boundary_loops"] = topology.n_boundary_loops;
  f["euler_characteristic"] = topology.euler_characteristic;
  const auto genus = topology.genus();
  f["genus"] = genus ? Json(*genus) : Json(nullptr);
  f["watertight"] = topology.is_watertight();
  f["manifold"] = topology.is_manifold();
  f["oriented"] = topology.is_oriented();
  f["unused_vertices"] = topology.n_unused_vertices;
  f["normals"] = mesh.normals.rows() > 0;
  Json values = Json::array();
  for (const auto& [name, column] : mesh.vertex_values) values.push_back(name);
  f["vertex_values"] = values;
  outcome.lines.push_back(concat("mesh: ", counted(mesh.n_vertices(), "vertex", "vertices"), ", ",
                                 counted(mesh.n_triangles(), "face", "faces"), ", ",
                                 counted(topology.n_edges, "edge", "edges")));
  outcome.lines.push_back(concat(counted(topology.n_components, "component", "components"), ", ",
                                 counted(topology.n_boundary_loops, "boundary loop", "boundary loops"),
                                 ", Euler characteristic ", topology.euler_characteristic,
                                 genus ? concat(", genus ", *genus) : std::string(),
                                 topology.is_watertight() ? ", watertight" : ""));
}

/// Area, volume, angles and edges. @pre the mesh has faces.
void add_mesh_measures(const TriangleMesh& mesh, const MeshFindings& found, Outcome& outcome) {
  Json& f = outcome.figures;
  const MeshQuality& quality = found.quality;
  f["area"] = surface_area(mesh.positions, mesh.triangles);
  outcome.lines.push_back(concat("area ", surface_area(mesh.positions, mesh.triangles)));
  if (found.topology.is_watertight()) {
    f["volume"] = enclosed_volume(mesh.positions, mesh.triangles);
    outcome.lines.back() += concat(", volume ", enclosed_volume(mesh.positions, mesh.triangles));
  }
  // JSON has no infinity: the aspect of a triangle without area is left out.
  const auto finite = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  f["quality"] = {{"min_angle_deg", degrees(quality.min_angle)},
                  {"mean_min_angle_deg", degrees(quality.mean_min_angle)},
                  {"max_angle_deg", degrees(quality.max_angle)},
                  {"slivers", quality.slivers},
                  {"regular_vertices", regular_share(mesh.triangles, mesh.n_vertices())},
                  {"area_variance", finite(area_variance(mesh.positions, mesh.triangles))},
                  {"mean_aspect", finite(quality.mean_aspect)},
                  {"max_aspect", finite(quality.max_aspect)},
                  {"min_edge", quality.min_edge},
                  {"mean_edge", quality.mean_edge},
                  {"max_edge", quality.max_edge}};
  outcome.lines.push_back(concat("angles ", degrees(quality.min_angle), " to ", degrees(quality.max_angle),
                                 " degrees, mean smallest ", degrees(quality.mean_min_angle), ", ",
                                 100 * quality.slivers, " % of the faces below 20 degrees"));
  outcome.lines.push_back(
      concat("edges ", quality.min_edge, " to ", quality.max_edge, ", mean ", quality.mean_edge));
}

/// What is wrong with a mesh, a sentence each.
std::vector<std::string> mesh_diagnosis(const TriangleMesh& mesh, const MeshFindings& found) {
  std::vector<std::string> diagnosis = found.topology.problems;
  if (TriangleMesh welded = mesh; weld_soup(welded))
    diagnosis.push_back(concat("every face has vertices of its own, ",
                               mesh.n_vertices() - welded.n_vertices(),
                               " too many; batten repair IN -o OUT welds them"));
  if (found.topology.is_watertight() && enclosed_volume(mesh.positions, mesh.triangles) < 0)
    diagnosis.emplace_back("the mesh is inside out; batten repair IN -o OUT turns it over");
  if (found.topology.n_unused_vertices > 0)
    diagnosis.push_back(concat(counted(found.topology.n_unused_vertices, "vertex belongs", "vertices belong"),
                               " to no face"));
  if (!found.degenerate.empty())
    diagnosis.push_back(concat(counted(static_cast<long>(found.degenerate.size()), "face has", "faces have"),
                               " no area, the first is face ", found.degenerate[0],
                               "; batten repair IN -o OUT leaves them out"));
  if (!found.folded.empty())
    diagnosis.push_back(concat(counted(static_cast<long>(found.folded.size()), "face points", "faces point"),
                               " against the normals of the vertices, the first is face ", found.folded[0]));
  if (!found.crossings.empty())
    diagnosis.push_back(concat(found.crossings.size() == kMostListedIntersections ? "at least " : "",
                               counted(static_cast<long>(found.crossings.size()), "pair", "pairs"),
                               " of faces intersect, the first are faces ", found.crossings[0].first, " and ",
                               found.crossings[0].second));
  return diagnosis;
}

void add_mesh(const TriangleMesh& mesh, Outcome& outcome) {
  const MeshFindings found = examine(mesh, outcome.times);
  add_mesh_topology(mesh, found.topology, outcome);
  add_box(mesh.positions, outcome);
  if (mesh.n_triangles() > 0) add_mesh_measures(mesh, found, outcome);
  Json& f = outcome.figures;
  f["degenerate_faces"] = found.degenerate.size();
  if (mesh.normals.rows() > 0) f["folded_faces"] = found.folded.size();
  f["self_intersections"] = found.crossings.size();
  const std::vector<std::string> diagnosis = mesh_diagnosis(mesh, found);
  f["diagnosis"] = diagnosis;
  for (const std::string& sentence : diagnosis) outcome.lines.push_back("- " + sentence);
  if (diagnosis.empty()) outcome.lines.emplace_back("nothing to complain about");
}

/// Closed walks that the border curves form: parts of the border in which every vertex has two edges.
int count_boundary_loops(const CurveNetwork& network) {
  std::map<int, std::vector<int>> neighbours;
  for (const NetworkCurve& curve : network.curves)
    for (size_t k = 1; curve.boundary && k < curve.vertices.size(); ++k) {
      neighbours[curve.vertices[k]].push_back(curve.vertices[k - 1]);
      neighbours[curve.vertices[k - 1]].push_back(curve.vertices[k]);
    }
  std::set<int> seen;
  int n = 0;
  for (const auto& [seed, ignored] : neighbours) {
    if (!seen.insert(seed).second) continue;
    std::vector<int> part{seed};
    bool closed = true;
    for (size_t k = 0; k < part.size(); ++k) {
      const std::vector<int>& next = neighbours[part[k]];
      closed = closed && next.size() == 2;
      for (const int v : next)
        if (seen.insert(v).second) part.push_back(v);
    }
    n += closed;
  }
  return n;
}

/// What the strokes of a network without normals amount to, counted as `surface` counts it; the counts of the
/// file as it is move to "stored".
void add_sketch_counts(const CurveNetwork& network, const Context& context, Outcome& outcome) {
  Json& f = outcome.figures;
  StrokeNetwork made;
  try {
    made = stroke_network(network, {}, context.progress);
  } catch (const InvalidInput& problem) {
    outcome.lines.push_back(concat("no patches: ", problem.what()));
    return;
  }
  Outcome reading;
  report_strokes(made, reading);
  outcome.times.add(reading.times);
  f.update(reading.figures);
  outcome.lines.insert(outcome.lines.end(), reading.lines.begin(), reading.lines.end());
  for (const char* count : {"nodes", "segments", "components"}) f["stored"][count] = f[count];
  const NetworkTopology topology = network_topology(made.network);
  f["nodes"] = topology.nodes.size();
  f["segments"] = topology.segments.size();
  f["components"] = topology.n_components;
  f["cycles"] = made.estimate.cycles.size();
  f["genus"] = made.estimate.n_handles;
  outcome.lines.push_back(
      concat("as a surface: ", counted(static_cast<long>(topology.nodes.size()), "node", "nodes"), ", ",
             counted(static_cast<long>(topology.segments.size()), "segment", "segments"), ", ",
             counted(static_cast<long>(made.estimate.cycles.size()), "cycle", "cycles"), ", ",
             counted(topology.n_components, "component", "components"), ", genus ", made.estimate.n_handles));
}

/// Lengths of the curves of a network and of the steps from vertex to vertex.
struct NetworkLengths {
  double total = 0, shortest = 0, longest = 0;  ///< curves
  double min_step = 0, max_step = 0;
  long n_steps = 0;
};

NetworkLengths measure_lengths(const CurveNetwork& network) {
  NetworkLengths lengths;
  for (size_t c = 0; c < network.curves.size(); ++c) {
    double length = 0;
    const std::vector<int>& vertices = network.curves[c].vertices;
    for (size_t k = 1; k < vertices.size(); ++k) {
      const double step =
          (network.positions.row(vertices[k]) - network.positions.row(vertices[k - 1])).norm();
      length += step;
      lengths.min_step = lengths.n_steps == 0 ? step : std::min(lengths.min_step, step);
      lengths.max_step = std::max(lengths.max_step, step);
      ++lengths.n_steps;
    }
    lengths.total += length;
    lengths.shortest = c == 0 ? length : std::min(lengths.shortest, length);
    lengths.longest = std::max(lengths.longest, length);
  }
  return lengths;
}

/// What is wrong with a network: its figures, and a line each.
Json add_findings(const std::vector<NetworkFinding>& findings, Outcome& outcome) {
  Json list = Json::array();
  for (const NetworkFinding& finding : findings) {
    Json entry = {{"defect", defect_name(finding.defect)}, {"sentence", finding.sentence}};
    if (finding.curve >= 0) entry["curve"] = finding.curve;
    if (finding.other_curve >= 0) entry["other_curve"] = finding.other_curve;
    if (finding.vertex >= 0) {
      entry["vertex"] = finding.vertex;
      entry["position"] = row_json(finding.position.transpose());
      entry["distance"] = finding.distance;
    }
    list.push_back(entry);
    outcome.lines.push_back(concat("- ", defect_name(finding.defect), ": ", finding.sentence));
  }
  return list;
}

void add_network(const CurveNetwork& network, const Context& context, Outcome& outcome) {
  NetworkTopology topology;
  std::vector<NetworkFinding> findings;
  Json cycles = nullptr;
  {
    ScopedStage stage(outcome.times, "topology");
    topology = network_topology(network);
    try {
      if (network.has_normals()) cycles = find_cycles(network).cycles.size();
    } catch (const InvalidInput&) {
      // The diagnosis says why.
    }
  }
  {
    ScopedStage stage(outcome.times, "diagnosis");
    findings = diagnose_network(network);
  }
  const NetworkLengths lengths = measure_lengths(network);
  const auto n_boundary = std::count_if(network.curves.begin(), network.curves.end(),
                                        [](const NetworkCurve& c) { return c.boundary; });
  Json& f = outcome.figures;
  f["curves"] = network.curves.size();
  f["boundary_curves"] = n_boundary;
  f["nodes"] = topology.nodes.size();
  f["segments"] = topology.segments.size();
  f["cycles"] = cycles;
  f["components"] = topology.n_components;
  f["boundary_loops"] = count_boundary_loops(network);
  f["normals"] = network.has_normals();
  f["unit"] = network.unit;
  f["length"] = lengths.total;
  f["curve_length_min"] = lengths.shortest;
  f["curve_length_max"] = lengths.longest;
  f["step_min"] = lengths.min_step;
  f["step_mean"] = lengths.n_steps > 0 ? lengths.total / static_cast<double>(lengths.n_steps) : 0;
  f["step_max"] = lengths.max_step;
  outcome.lines.push_back(concat(
      "network: ", counted(static_cast<long>(network.curves.size()), "curve", "curves"), " (", n_boundary,
      " on the border), ", counted(static_cast<long>(topology.nodes.size()), "node", "nodes"), ", ",
      counted(static_cast<long>(topology.segments.size()), "segment", "segments"), ", ",
      counted(network.positions.rows(), "vertex", "vertices"),
      network.has_normals() ? "" : " without normals"));
  outcome.lines.push_back(
      concat(counted(topology.n_components, "component", "components"),
             cycles.is_null() ? std::string() : concat(", ", counted(cycles.get<long>(), "cycle", "cycles")),
             ", ", counted(count_boundary_loops(network), "boundary loop", "boundary loops")));
  add_box(network.positions, outcome);
  outcome.lines.push_back(concat("length ", lengths.total, ", curves ", lengths.shortest, " to ",
                                 lengths.longest, ", steps ", lengths.min_step, " to ", lengths.max_step));
  if (!network.has_normals() && !network.curves.empty()) add_sketch_counts(network, context, outcome);
  f["diagnosis"] = add_findings(findings, outcome);
  if (findings.empty()) outcome.lines.emplace_back("nothing to complain about");
}

void add_scan(const LogScan& read, Outcome& outcome) {
  const Scan& scan = read.scan;
  long n_readings = 0, n_closed = 0, n_boundary = 0, n_segments = 0;
  double total = 0, shortest = 0, longest = 0;
  std::set<int> nodes;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const ScanCurve& curve = scan.curves[c];
    n_readings += curve.n_readings();
    n_closed += curve.closed;
    n_boundary += curve.boundary;
    nodes.insert(curve.node_ids.begin(), curve.node_ids.end());
    if (!curve.node_ids.empty()) n_segments += static_cast<long>(curve.node_ids.size()) - 1;
    const double length = curve.distances(curve.distances.size() - 1) - curve.distances(0);
    total += length;
    shortest = c == 0 ? length : std::min(shortest, length);
    longest = std::max(longest, length);
  }
  Json& f = outcome.figures;
  f["curves"] = scan.curves.size();
  f["boundary_curves"] = n_boundary;
  f["closed_curves"] = n_closed;
  f["nodes"] = nodes.size();
  f["segments"] = n_segments;
  f["readings"] = n_readings;
  f["unit"] = scan.unit;
  f["length"] = total;
  f["curve_length_min"] = shortest;
  f["curve_length_max"] = longest;
  f["mean_spacing"] = n_readings > static_cast<long>(scan.curves.size())
                          ? total / static_cast<double>(n_readings - static_cast<long>(scan.curves.size()))
                          : 0;
  const char* const conventions[] = {"auto", "at-sample", "to-next"};
  f["tangents"] = conventions[static_cast<int>(scan.tangents)];
  for (const std::string& warning : read.warnings) outcome.warnings.push_back(warning);
  outcome.lines.push_back(concat(
      "scan: ", counted(static_cast<long>(scan.curves.size()), "curve", "curves"), " (", n_boundary,
      " on the border, ", n_closed, " closed), ", counted(static_cast<long>(nodes.size()), "node", "nodes"),
      ", ", counted(n_segments, "segment", "segments"), ", ", counted(n_readings, "reading", "readings")));
  outcome.lines.push_back(concat("length ", total, ", curves ", shortest, " to ", longest));
}

void add_sensor(const SensorCalibration& sensor, const std::string& name, Outcome& outcome) {
  Json matrix = Json::array();
  for (int i = 0; i < 3; ++i) matrix.push_back(row_json(sensor.matrix.row(i)));
  outcome.figures[name] = {{"offset", row_json(sensor.offset.transpose())}, {"matrix", matrix}};
  outcome.lines.push_back(concat(name, ": offset ", sensor.offset.transpose()));
}

bool is_calibration(const std::string& path) {
  if (input_extension(path) != "json") return false;
  const Json json = Json::parse(read_file(path), nullptr, false);
  return json.is_object() && json.contains("format") && json["format"] == "batten calibration";
}

Outcome run_info(const std::string& path, const std::string& columns, const Context& context) {
  Outcome outcome;
  outcome.figures["file"] = path;
  const std::string extension = input_extension(path);
  if (extension == "rawnet" || extension == "csv" || !columns.empty()) {
    outcome.figures["kind"] = "scan";
    LogScan scan;
    {
      ScopedStage stage(outcome.times, "read");
      scan = read_scan(path, {}, columns);
    }
    add_scan(scan, outcome);
    return outcome;
  }
  if (is_calibration(path)) {
    outcome.figures["kind"] = "calibration";
    const Calibration calibration = read_calibration(path);
    outcome.lines.emplace_back("calibration of a device");
    add_sensor(calibration.accelerometer, "accelerometer", outcome);
    add_sensor(calibration.magnetometer, "magnetometer", outcome);
    outcome.figures["gyroscope_bias"] = row_json(calibration.gyroscope_bias.transpose());
    return outcome;
  }
  Model model;
  {
    ScopedStage stage(outcome.times, "read");
    model = read_model(path, outcome.warnings);
  }
  const Json counts = describe(model);
  for (const auto& [key, value] : counts.items()) outcome.figures[key] = value;
  if (model.mesh)
    add_mesh(*model.mesh, outcome);
  else
    add_network(*model.network, context, outcome);
  return outcome;
}

}  // namespace

void add_info(CLI::App& app) {
  auto path = std::make_shared<std::string>(), columns = std::make_shared<std::string>();
  CLI::App* command =
      add_command(app, "info", "Count, measure and diagnose a mesh, a network, a scan or a calibration.",
                  "batten info net.json --json",
                  [path, columns](Context& context) { return run_info(*path, *columns, context); });
  command->add_option("FILE", *path, "Mesh, network, scan or calibration")->required();
  add_columns_option(*command, *columns);
}

}  // namespace batten::cli
