#include "simulated_scans.hpp"

#include <algorithm>
#include <utility>

#include "batten/core/units.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/registration.hpp"
#include "batten/simulation/mesh_sections.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten::experiments {

namespace {

/// Of 2.09 m: fine enough that facets are off by less than a hundredth of the errors that are measured.
constexpr double kConeEdge = 0.008;
/// Points of what was made that are matched; errors of both are far larger than what more would change.
constexpr Eigen::Index kMatchedPoints = 500;

/// Distances that are right at nodes and at both ends, and in between as even as the hand was: S 3.7.3,
/// "measured segment lengths".
void measure_segments(ScanCurve& curve, const Eigen::VectorXd& truth) {
  std::vector<Eigen::Index> ends(curve.node_readings.begin(), curve.node_readings.end());
  ends.push_back(0);
  ends.push_back(curve.n_readings() - 1);
  std::sort(ends.begin(), ends.end());
  const Eigen::VectorXd given = curve.distances;
  for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
    const Eigen::Index a = ends[e], b = ends[e + 1];
    const double length = given[b] - given[a];
    for (Eigen::Index i = a; i <= b; ++i) {
      const double t = length > 0 ? (given[i] - given[a]) / length : 0;
      curve.distances[i] = truth[a] + t * (truth[b] - truth[a]);
    }
  }
}

}  // namespace

ScannedObject::ScannedObject(std::string given_name, TracedNetwork given_traced, Shape given_surface)
    : name(std::move(given_name)),
      traced(std::move(given_traced)),
      surface(std::move(given_surface)),
      tree(surface),
      diameter(batten::diameter(surface)) {}

double total_length(const TracedNetwork& traced) {
  double length = 0;
  for (const TracedCurve& curve : traced.curves) length += curve.path->length();
  return length;
}

ScannedObject scanned_cone() {
  const TriangleMesh mesh = shape_mesh(AnalyticShape::Cone, kConeEdge);
  return {"cone", trace_shape(AnalyticShape::Cone), {mesh.positions, mesh.triangles, {}}};
}

ScannedObject scanned_lilium(const TriangleMesh& lilium, int planes) {
  TriangleMesh mesh = lilium;
  const double width = mesh.positions.col(0).maxCoeff() - mesh.positions.col(0).minCoeff();
  mesh.positions /= width;
  // Its height is along the axis in which it extends least.
  const Eigen::RowVector3d extent = mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff();
  Eigen::Index up = 0;
  extent.minCoeff(&up);
  MeshSectionOptions sections;
  sections.planes = planes;
  sections.axes = up == 0 ? "yz" : up == 1 ? "xz" : "xy";
  return {"lilium", trace_mesh(mesh, sections), {mesh.positions, mesh.triangles, {}}};
}

Scan acquired_scan(const ScannedObject& object, Acquisition acquisition, int readings, std::uint64_t seed) {
  SimulateOptions options;
  options.seed = seed;
  options.step = total_length(object.traced) / (readings * object.traced.diameter);
  options.orientation_noise = radians(2);
  options.drift = radians(1);
  if (acquisition == Acquisition::Device) {
    options.odometer_error = 0.003;
  } else {
    options.speed_variation = 0.2;
    if (acquisition == Acquisition::PhoneEstimated) options.curve_length_error = 0.1;
  }
  SimulatedScan simulated = simulate_scan(object.traced, options);
  if (acquisition == Acquisition::PhoneMeasured)
    for (std::size_t c = 0; c < simulated.scan.curves.size(); ++c)
      measure_segments(simulated.scan.curves[c], simulated.true_distances[c]);
  return std::move(simulated.scan);
}

TruthDistances distances_from_truth(const Shape& made, const Shape& truth, const ShapeTree& tree) {
  RegistrationOptions options;
  options.samples = kMatchedPoints;
  const Registration registration = register_shapes(made, truth, options);
  const std::vector<int> used = used_vertices(made);
  Points points(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t i = 0; i < used.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = made.positions.row(used[i]);
  const Eigen::VectorXd found = distances(tree.closest(registration.transform(points)));
  const DistanceFigures figures = distance_figures(found);
  const double scale = 100 / diameter(truth);
  return {scale * figures.mean, scale * figures.rms, scale * figures.max, scale * found.minCoeff()};
}

TruthDistances distances_from_truth(const Shape& made, const ScannedObject& object) {
  return distances_from_truth(made, object.surface, object.tree);
}

}  // namespace batten::experiments
