#include <limits>
#include <string>
#include <utility>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/render/corner_normals.hpp"

namespace batten::detail {

namespace {

// As `batten render` draws edges sharp.
constexpr double kCreaseAngle = radians(50);

Eigen::RowVector3d middle_of(const TriangleMesh& mesh, int triangle) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k) sum += mesh.positions.row(mesh.triangles(triangle, k));
  return sum / 3;
}

/// @param origin what drawn coordinates are less.
Json figures_of(const TriangleMesh& mesh, const Eigen::RowVector3d& origin) {
  const MeshQuality quality = mesh_quality(mesh.positions, mesh.triangles);
  const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  return {{"n_vertices", mesh.n_vertices()},
          {"n_triangles", mesh.n_triangles()},
          {"closed", topology.is_watertight()},
          {"n_borders", topology.n_boundary_loops},
          {"n_components", topology.n_components},
          {"genus", topology.genus() ? Json(*topology.genus()) : Json()},
          {"problems", topology.problems},
          {"smallest_angle", json_of(quality.min_angle)},
          {"mean_smallest_angle", json_of(quality.mean_min_angle)},
          {"largest_angle", json_of(quality.max_angle)},
          {"slivers", json_of(quality.slivers)},
          {"mean_aspect", json_of(quality.mean_aspect)},
          {"worst_aspect", json_of(quality.max_aspect)},
          {"worst", quality.worst_triangle < 0
                        ? Json()
                        : json_of(Eigen::RowVector3d(middle_of(mesh, quality.worst_triangle) - origin))},
          {"shortest_edge", json_of(quality.min_edge)},
          {"mean_edge", json_of(quality.mean_edge)},
          {"longest_edge", json_of(quality.max_edge)},
          {"regular", json_of(regular_share(mesh.triangles, mesh.n_vertices()))},
          {"area", json_of(surface_area(mesh.positions, mesh.triangles))},
          {"volume",
           topology.is_watertight() ? json_of(enclosed_volume(mesh.positions, mesh.triangles)) : Json()},
          {"diameter", json_of(diameter(Shape{mesh.positions, mesh.triangles, {}}))}};
}

}  // namespace

Eigen::VectorXd SplitMesh::spread(const Eigen::VectorXd& values) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(vertex.size()));
  for (std::size_t i = 0; i < vertex.size(); ++i) result[static_cast<Eigen::Index>(i)] = values[vertex[i]];
  return result;
}

Points SplitMesh::spread(const Points& points) const {
  Points result(static_cast<Eigen::Index>(vertex.size()), 3);
  for (std::size_t i = 0; i < vertex.size(); ++i)
    result.row(static_cast<Eigen::Index>(i)) = points.row(vertex[i]);
  return result;
}

SplitMesh split_at_creases(const TriangleMesh& mesh) {
  const Points corners = corner_normals(mesh, kCreaseAngle);
  SplitMesh split;
  split.triangles.resize(mesh.n_triangles(), 3);
  // The copies of a vertex are a list: next[copy] is the one after it, −1 the end; the first is the vertex.
  std::vector<int> next(at(mesh.n_vertices()), -1);
  std::vector<char> has_normal(at(mesh.n_vertices()), 0);
  std::vector<Eigen::RowVector3d> normals(at(mesh.n_vertices()), Eigen::RowVector3d::UnitZ());
  split.vertex.resize(at(mesh.n_vertices()));
  for (std::size_t v = 0; v < split.vertex.size(); ++v) split.vertex[v] = static_cast<int>(v);
  for (Eigen::Index i = 0; i < corners.rows(); ++i) {
    int copy = mesh.triangles(i / 3, i % 3);
    if (has_normal[at(copy)] == 0) {
      has_normal[at(copy)] = 1;
      normals[at(copy)] = corners.row(i);
    }
    while (normals[at(copy)] != corners.row(i)) {
      if (next[at(copy)] < 0) {
        next[at(copy)] = static_cast<int>(split.vertex.size());
        split.vertex.push_back(split.vertex[at(copy)]);
        next.push_back(-1);
        normals.emplace_back(corners.row(i));
      }
      copy = next[at(copy)];
    }
    split.triangles(i / 3, i % 3) = copy;
  }
  split.normals.resize(static_cast<Eigen::Index>(normals.size()), 3);
  for (std::size_t i = 0; i < normals.size(); ++i)
    split.normals.row(static_cast<Eigen::Index>(i)) = normals[i];
  return split;
}

Eigen::RowVector3d middle_of(const Points& points) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(kInfinity), high = -low;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) continue;
    low = low.cwiseMin(points.row(i));
    high = high.cwiseMax(points.row(i));
  }
  if (!(low[0] <= high[0])) return Eigen::RowVector3d::Zero();
  return 0.5 * (low + high);
}

void draw_mesh(Draft& draft, const TriangleMesh& mesh, const Eigen::RowVector3d& origin) {
  const SplitMesh split = split_at_creases(mesh);
  draft.add_points("positions", split.spread(mesh.positions), origin);
  draft.add_points("normals", split.normals, Eigen::RowVector3d::Zero());
  draft.add_triangles("triangles", split.triangles);
  draft.add_indices("vertex", split.vertex);
  draft.json["mesh"] = figures_of(mesh, origin);
}

void draw_network(Draft& draft, const CurveNetwork& network, const Eigen::RowVector3d& origin) {
  draft.add_points("network.positions", network.positions, origin);
  if (network.has_normals()) draft.add_points("network.normals", network.normals, Eigen::RowVector3d::Zero());
  std::vector<int> vertices;
  Json curves = Json::array();
  for (const NetworkCurve& curve : network.curves) {
    curves.push_back({{"name", curve.name},
                      {"boundary", curve.boundary},
                      {"sharp", curve.sharp},
                      {"closed", curve.closed()},
                      {"first", vertices.size()},
                      {"n", curve.vertices.size()}});
    vertices.insert(vertices.end(), curve.vertices.begin(), curve.vertices.end());
  }
  draft.add_indices("network.vertices", vertices);
  draft.add_indices("network.nodes", network_topology(network).nodes);
  draft.json["curves"] = std::move(curves);
}

CurveNetwork curves_of(const PolylineMesh& model) {
  CurveNetwork network;
  std::vector<Eigen::RowVector3d> points;
  for (const SketchEdge& edge : model.edges()) {
    if (!edge.alive || !edge.drawn) continue;
    const Points& line = edge.polyline->points();
    NetworkCurve& curve = network.curves.emplace_back();
    curve.name = "c" + std::to_string(edge.curve);
    curve.boundary = edge.faces[0] < 0 || edge.faces[1] < 0;
    curve.sharp = edge.sharpness > 0;
    for (Eigen::Index i = 0; i < line.rows(); ++i) {
      curve.vertices.push_back(static_cast<int>(points.size()));
      points.emplace_back(line.row(i));
    }
  }
  network.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    network.positions.row(static_cast<Eigen::Index>(i)) = points[i];
  return network;
}

Eigen::RowVector3d draw_model(Draft& draft, const PolylineMesh& model) {
  const CurveNetwork network = curves_of(model);
  Json curves = Json::array();
  std::vector<int> vertices;
  std::size_t c = 0;
  for (const SketchEdge& edge : model.edges()) {
    if (!edge.alive || !edge.drawn) continue;
    const NetworkCurve& curve = network.curves[c++];
    curves.push_back({{"name", curve.name},
                      {"curve", edge.curve},
                      {"sharpness", edge.sharpness},
                      {"boundary", curve.boundary},
                      {"sharp", curve.sharp},
                      {"closed", false},
                      {"first", vertices.size()},
                      {"n", curve.vertices.size()},
                      {"ends", {edge.vertices[0], edge.vertices[1]}}});
    vertices.insert(vertices.end(), curve.vertices.begin(), curve.vertices.end());
  }
  const Eigen::RowVector3d origin = middle_of(network.positions);
  draft.json["origin"] = json_of(origin);
  draft.add_points("network.positions", network.positions, origin);
  draft.add_indices("network.vertices", vertices);
  draft.add_indices("network.nodes", {});
  draft.json["curves"] = std::move(curves);
  return origin;
}

void draw(Draft& draft, const Content& content) {
  if (const auto* mesh = std::get_if<SharedMesh>(&content)) {
    const Eigen::RowVector3d origin = middle_of((*mesh)->positions);
    draft.json["origin"] = json_of(origin);
    draw_mesh(draft, **mesh, origin);
  } else if (const auto* network = std::get_if<SharedNetwork>(&content)) {
    const Eigen::RowVector3d origin = middle_of((*network)->positions);
    draft.json["origin"] = json_of(origin);
    draw_network(draft, **network, origin);
  } else if (const auto* scan = std::get_if<SharedScan>(&content)) {
    Json curves = Json::array();
    for (const ScanCurve& curve : (*scan)->curves)
      curves.push_back({{"name", curve.name},
                        {"boundary", curve.boundary},
                        {"sharp", curve.sharp},
                        {"closed", curve.closed},
                        {"n_readings", curve.n_readings()},
                        {"n_nodes", curve.node_readings.size()},
                        {"length", curve.n_readings() > 0
                                       ? json_of(curve.distances[curve.n_readings() - 1] - curve.distances[0])
                                       : Json(0)}});
    draft.json["curves"] = std::move(curves);
  }
}

void add_report(Draft& draft, const RequestResult& result) {
  if (const auto* made = std::get_if<ScanNetwork>(&result)) {
    const ScanReport& report = made->report;
    draft.json["report"] = {{"lambda", json_of(report.lambda)},
                            {"mu", json_of(report.mu)},
                            {"weights_reason", report.weights_reason},
                            {"step", json_of(report.step)},
                            {"size", json_of(report.size)},
                            {"n_readings", report.n_readings},
                            {"n_samples", report.n_samples},
                            {"outliers", report.outliers},
                            {"distrusted", report.distrusted},
                            {"misfit_before", json_of(report.closure_misfit_before)},
                            {"misfit", json_of(report.closure_misfit)}};
  }
  if (const auto* mended = std::get_if<RepairedMesh>(&result)) {
    draft.json["done"] = mended->done;
    draft.json["flaws"] = mended->flaws;
    draft.json["warnings"] = mended->warnings;
  }
  const StageTimes times = times_of(result);
  Json stages = Json::array();
  for (const auto& [stage, seconds] : times.stages())
    stages.push_back({{"stage", stage}, {"seconds", seconds}});
  draft.json["times"] = std::move(stages);
}

}  // namespace batten::detail
