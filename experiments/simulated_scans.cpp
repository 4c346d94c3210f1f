#include "simulated_scans.hpp"

#include <algorithm>
#include <utility>

#include "batten/core/units.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/registration.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/mesh_sections.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten::experiments {

namespace {

/// Of 2.09 m: fine enough that facets are off by less than a hundredth of the errors that are measured.
constexpr double kConeEdge = 0.008;
/// Points of what was made that are matched, about.
constexpr std::size_t kMatchedPoints = 1000;

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

/// The motion that makes the squared distances of points from a surface least, by Levenberg–Marquardt on the
/// distances from the closest points; from a start that is right to a few per cent. Turns that do not show,
/// about the axis of a cone, are held back by the damping.
SimilarityTransform onto_surface(const Points& positions, const std::vector<int>& used, const Truth& truth,
                                 SimilarityTransform motion) {
  constexpr int kIterations = 40;
  const std::size_t stride = std::max<std::size_t>(1, used.size() / kMatchedPoints);
  const auto cost_of = [&](const SimilarityTransform& tried) {
    double sum = 0;
    for (std::size_t i = 0; i < used.size(); i += stride)
      sum += truth.tree.closest(tried(Eigen::Vector3d(positions.row(used[i])))).squared_distance;
    return sum;
  };
  double cost = cost_of(motion), damping = 1e-4;
  for (int iteration = 0; iteration < kIterations && damping < 1; ++iteration) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    const Eigen::Vector3d centre = motion(Eigen::Vector3d(positions.row(used.front())));
    for (std::size_t i = 0; i < used.size(); i += stride) {
      const Eigen::Vector3d p = motion(Eigen::Vector3d(positions.row(used[i])));
      const Eigen::Vector3d offset = p - truth.tree.closest(p).point;
      const double distance = offset.norm();
      if (distance == 0) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << (p - centre).cross(offset) / (distance * truth.diameter), offset / distance;
      A += row * row.transpose();
      b -= row * distance;
    }
    A.diagonal().array() += damping * A.trace();
    const Eigen::Matrix<double, 6, 1> step = A.ldlt().solve(b);
    SimilarityTransform move;
    move.rotation = so3_exp(step.head<3>() / truth.diameter);
    move.translation = centre + step.tail<3>() - move.rotation * centre;
    const double moved_cost = cost_of(move * motion);
    if (moved_cost > cost) {
      damping *= 10;
      continue;
    }
    motion = move * motion;
    const bool is_at_rest = cost - moved_cost <= 1e-6 * cost;
    cost = moved_cost;
    damping = std::max(damping / 3, 1e-6);
    if (is_at_rest) break;
  }
  return motion;
}

}  // namespace

Truth::Truth(Shape given_shape, Points given_nodes)
    : shape(std::move(given_shape)),
      nodes(std::move(given_nodes)),
      tree(shape),
      diameter(batten::diameter(shape)) {}

ScannedObject::ScannedObject(std::string given_name, TracedNetwork given_traced, Shape surface)
    : name(std::move(given_name)),
      traced(std::move(given_traced)),
      truth(std::move(surface), traced.node_positions) {}

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

TruthDistances distances_from_truth(const Shape& made, const Points& nodes, const Truth& truth) {
  SimilarityTransform motion = fit_transform(nodes, truth.nodes, RegistrationKind::Rigid);
  const std::vector<int> used = used_vertices(made);
  if (truth.shape.is_surface()) motion = onto_surface(made.positions, used, truth, motion);
  Points points(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t i = 0; i < used.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = made.positions.row(used[i]);
  const Eigen::VectorXd found = distances(truth.tree.closest(motion(points)));
  const DistanceFigures figures = distance_figures(found);
  const double scale = 100 / truth.diameter;
  return {scale * figures.mean, scale * figures.rms, scale * figures.max, scale * found.minCoeff()};
}

TruthDistances distances_from_truth(const Shape& made, const Truth& truth) {
  return distances_from_truth(made, made.positions.topRows(truth.nodes.rows()), truth);
}

}  // namespace batten::experiments
