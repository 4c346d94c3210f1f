#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/subdivision/cage_level_detail.hpp"
#include "batten/subdivision/cage_polylines_detail.hpp"

namespace batten::detail {

namespace {

/// Takes over the polylines of the cage, as their edges run.
void add_polylines(CageLevel& level, const ControlCage& cage) {
  const CageTopology& topology = level.topology;
  level.polyline.assign(topology.edges.size(), -1);
  const double diameter = bounding_box_diagonal(cage.mesh.positions);
  for (const EdgePolyline& polyline : cage.polylines) {
    const int e = edge_between(topology, cage.mesh, polyline.from, polyline.to, "the polyline");
    const auto name = [&] {
      return concat("the polyline between vertices ", polyline.from, " and ", polyline.to);
    };
    if (polyline.points.rows() < 2) throw InvalidInput(name() + " needs two points at least");
    if (!polyline.points.allFinite()) throw InvalidInput(name() + " has a point that is not finite");
    constexpr double kAtVertex = 1e-6;  // of the diameter; drawn curves are snapped to their vertices
    if ((polyline.points.row(0) - level.point(polyline.from)).norm() > kAtVertex * diameter ||
        (polyline.points.bottomRows(1) - level.point(polyline.to)).norm() > kAtVertex * diameter)
      throw InvalidInput(name() + " does not begin and end at these vertices; snap its ends to them");
    if (level.polyline[at(e)] >= 0) throw InvalidInput(name() + " is given twice; keep one of both");
    level.polyline[at(e)] = static_cast<int>(level.polylines.size());
    level.polylines.push_back(polyline.points);
    if (topology.edges[at(e)][0] != polyline.from)
      level.polylines.back() = Points(polyline.points.colwise().reverse());
  }
}

void set_intervals(CageLevel& level, double exponent) {
  const CageTopology& topology = level.topology;
  const size_t n = topology.edges.size();
  level.interval.resize(n);
  double sum = 0;
  for (size_t e = 0; e < n; ++e) {
    const double length =
        level.polyline[e] >= 0
            ? lengths_along(level.polylines[at(level.polyline[e])]).back()
            : (level.point(topology.edges[e][1]) - level.point(topology.edges[e][0])).norm();
    level.interval[e] = std::pow(length, exponent);
    sum += level.interval[e];
  }
  // Edges without length would put two points on one knot.
  constexpr double kLeast = 1e-4;
  const double least = sum > 0 ? kLeast * sum / static_cast<double>(n) : 1.0;
  for (double& interval : level.interval) interval = std::max(interval, least);
}

}  // namespace

void find_kinds(CageLevel& level, bool smooth_corners) {
  const size_t n = static_cast<size_t>(level.mesh.positions.rows());
  std::vector<int> n_sharp(n, 0), n_edges(n, 0);
  for (size_t e = 0; e < level.topology.edges.size(); ++e)
    for (const int v : level.topology.edges[e]) {
      ++n_edges[at(v)];
      n_sharp[at(v)] += level.is_sharp(static_cast<int>(e));
    }
  level.kind.resize(n);
  for (size_t v = 0; v < n; ++v) {
    const bool border_corner = level.topology.is_border[v] != 0 && n_edges[v] == 2 && !smooth_corners;
    if (level.vertex_sharpness[v] > 0 || n_sharp[v] > 2 || border_corner)
      level.kind[v] = VertexKind::Corner;
    else
      level.kind[v] = n_sharp[v] == 2   ? VertexKind::Crease
                      : n_sharp[v] == 1 ? VertexKind::Dart
                                        : VertexKind::Smooth;
  }
}

void spokes_around(const CageLevel& level, int vertex, std::vector<CageSpoke>& spokes) {
  spokes.clear();
  const int first = level.topology.corner_of_vertex[at(vertex)];
  int c = first;
  do {
    spokes.push_back({level.edge(c), level.end_vertex(c)});
    const int before = level.topology.previous[at(c)];
    c = level.topology.opposite(before);
    if (c < 0) spokes.push_back({level.edge(before), level.vertex(before)});
  } while (c >= 0 && c != first);
}

Eigen::RowVector3d centroid(const CageLevel& level, int face) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int c = level.mesh.offsets[at(face)]; c < level.mesh.offsets[at(face) + 1]; ++c)
    sum += level.point(level.vertex(c));
  return sum / level.n_corners(face);
}

CageLevel base_level(const ControlCage& cage, const CageTopology& topology,
                     const SubdivisionOptions& options) {
  CageLevel level;
  level.mesh = cage.mesh;
  level.topology = topology;
  level.edge_sharpness = edge_sharpness(cage, topology);
  level.vertex_sharpness = vertex_sharpness(cage);
  add_polylines(level, cage);
  set_intervals(level, options.knot_exponent);
  find_kinds(level, options.smooth_corners);
  return level;
}

}  // namespace batten::detail
