#include "batten/pipeline/implicit_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/implicit/field_mesh.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {

namespace {

constexpr double kSampleStep = 0.004;  // of the samples of strokes, in diameters
/// Parts of the surface that are not worth naming, ÷ its area.
constexpr double kLeastUnsure = 0.005;
constexpr std::size_t kMostUnsure = 3;
/// Strokes farther than this from the surface are not on it, in diameters: 95th percentile and largest.
constexpr double kFarP95 = 0.02, kFarMax = 0.05;

std::vector<UnsurePlace> unsure_places(const TriangleMesh& mesh, const StrokeSamples& samples,
                                       double diameter) {
  Segments dots(samples.positions.rows(), 2);  // samples lie nearer together than it matters here
  for (Eigen::Index i = 0; i < dots.rows(); ++i) dots.row(i).setConstant(static_cast<int>(i));
  const Eigen::VectorXd distance =
      distances(SegmentTree(samples.positions, dots).closest(mesh.positions)) / diameter;
  DisjointSets parts(static_cast<int>(mesh.n_vertices()));
  const auto is_far = [&](int v) { return distance[v] > kUnsureDistance; };
  for (const auto& t : mesh.triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      if (is_far(t[k]) && is_far(t[(k + 1) % 3])) parts.unite(t[k], t[(k + 1) % 3]);
  const Eigen::VectorXd areas = face_areas(mesh.positions, mesh.triangles);
  std::map<int, UnsurePlace> by_part;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (const int v : mesh.triangles.row(f)) {
      if (!is_far(v)) continue;
      UnsurePlace& place = by_part[parts.root(v)];
      place.area += areas[f] / (3 * areas.sum());
      if (distance[v] > place.distance) {
        place.distance = distance[v];
        place.position = mesh.positions.row(v);
      }
    }
  std::vector<UnsurePlace> places;
  for (const auto& [part, place] : by_part)
    if (place.area > kLeastUnsure) places.push_back(place);
  std::stable_sort(places.begin(), places.end(),
                   [](const UnsurePlace& a, const UnsurePlace& b) { return a.area > b.area; });
  return places;
}

void check(ImplicitSurface& made, const StrokeSamples& samples, bool closed, const Progress& progress) {
  NetworkSurface& surface = made.surface;
  const ScopedStage stage(surface.times, "check");
  surface.topology = mesh_topology(surface.mesh.triangles, surface.mesh.n_vertices());
  surface.quality = mesh_quality(surface.mesh.positions, surface.mesh.triangles);
  surface.crossing_pairs = self_intersections(surface.mesh.positions, surface.mesh.triangles,
                                              kMostListedIntersections, progress.part("check", 0, 0.6))
                               .size();
  const Eigen::VectorXd distance =
      distances(TriangleTree(surface.mesh.positions, surface.mesh.triangles).closest(samples.positions)) /
      surface.diameter;
  std::vector<double> sorted(distance.data(), distance.data() + distance.size());
  made.stroke_distance_p95 = percentile(sorted, 0.95);
  made.stroke_distance_max = distance.maxCoeff();
  const MeshTopology& topology = surface.topology;
  if (!topology.problems.empty()) surface.flaws.push_back(topology.problems.front());
  if (closed && topology.n_boundary_loops > 0)
    surface.flaws.push_back(concat("the surface has ", topology.n_boundary_loops,
                                   " openings, where the strokes do not say how it closes"));
  if (surface.crossing_pairs > 0)
    surface.flaws.push_back(concat(surface.crossing_pairs, " pairs of triangles cross"));
  if (made.stroke_distance_p95 > kFarP95 || made.stroke_distance_max > kFarMax) {
    Eigen::Index worst = 0;
    distance.maxCoeff(&worst);
    surface.flaws.push_back(concat("strokes are off the surface, by ", 100 * made.stroke_distance_max,
                                   " % of the diameter at ", samples.positions(worst, 0), ", ",
                                   samples.positions(worst, 1), ", ", samples.positions(worst, 2),
                                   " (stroke ", samples.stroke[at(worst)], ")"));
  }
  made.unsure = unsure_places(surface.mesh, samples, surface.diameter);
  for (std::size_t k = 0; k < std::min(kMostUnsure, made.unsure.size()); ++k) {
    const UnsurePlace& place = made.unsure[k];
    surface.warnings.push_back(
        concat(100 * place.area, " % of the surface around ", place.position.x(), ", ", place.position.y(),
               ", ", place.position.z(), " lie up to ", 100 * place.distance,
               " % of the diameter from every stroke; a stroke there would decide it"));
  }
  if (topology.n_components > 1)
    surface.warnings.push_back(concat("the strokes became ", topology.n_components,
                                      " bodies; a stroke between them would join them"));
}

}  // namespace

std::optional<std::string> ImplicitSurfaceOptions::problem() const {
  if (edge_length && !(edge_length->value > 0 && std::isfinite(edge_length->value)))
    return concat("edge_length must be positive, got ", edge_length->value);
  if (!(max_triangles > 0)) return concat("max_triangles must be positive, got ", max_triangles);
  return field.problem();
}

ImplicitSurface implicit_surface(const CurveNetwork& strokes, const ImplicitSurfaceOptions& options,
                                 const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  ImplicitSurface made;
  NetworkSurface& surface = made.surface;
  surface.diameter = bounding_box_diagonal(strokes.positions);
  surface.n_curves = strokes.curves.size();
  if (!(surface.diameter > 0)) throw InvalidInput("the strokes lie at one place");
  const double edge = options.edge_length ? options.edge_length->in_file_units(surface.diameter)
                                          : kImplicitEdge * surface.diameter;
  const StrokeSamples samples = stroke_samples(strokes, kSampleStep * surface.diameter);
  made.field = stroke_field(samples, options.field, progress);
  surface.times.add(made.field.times);
  const StrokeField& field = made.field.field;
  {
    const ScopedStage stage(surface.times, "mesh");
    LevelSetOptions level;
    level.edge_length = edge;
    level.max_triangles = options.max_triangles;
    level.closed = options.field.closed;
    surface.mesh = field_mesh(field, samples, level, progress);
    if (surface.mesh.n_triangles() == 0)
      throw InvalidInput("no surface was found through the strokes; more strokes around the body are needed");
    surface.mesh.normals.resize(surface.mesh.n_vertices(), 3);
    for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
      Eigen::Vector3d gradient;
      field.value(surface.mesh.positions.row(v).transpose(), gradient);
      surface.mesh.normals.row(v) = gradient.normalized();
    }
  }
  check(made, samples, options.field.closed, progress);
  return made;
}

}  // namespace batten
