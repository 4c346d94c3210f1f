#pragma once
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten::test {

/// Rows of `from` moved onto the rows of `to` by the best rotation (and scale) and translation.
inline Points aligned(const Points& from, const Points& to, bool scale = false) {
  const Eigen::RowVector3d a = from.colwise().mean(), b = to.colwise().mean();
  const Points A = from.rowwise() - a, B = to.rowwise() - b;
  const Eigen::Matrix3d R = nearest_rotation(B.transpose() * A);
  const double s = scale ? (B.array() * (A * R.transpose()).array()).sum() / A.squaredNorm() : 1;
  return (s * A * R.transpose()).rowwise() + b;
}

/// Where each vertex of a network is in truth, by the share of the length of its curve.
inline Points true_points(const TracedNetwork& traced, const ScanNetwork& result) {
  Points truth(result.network.positions.rows(), 3);
  for (size_t c = 0; c < traced.curves.size(); ++c) {
    const SampledCurve& curve = result.samples.curves[c];
    const ArcLengthCurve& path = *traced.curves[c].path;
    for (int k = 0; k < curve.n_samples(); ++k)
      truth.row(result.network.curves[c].vertices[static_cast<size_t>(k)]) =
          path.at(curve.parameters[k] / curve.length() * path.length()).position.transpose();
  }
  return truth;
}

/// Mean distance of the vertices of a network to the true curves after registration by closest points, in
/// parts of the diameter. The start is the correspondence by arc length.
inline double network_error(const TracedNetwork& traced, const ScanNetwork& result, bool scale = false) {
  const CurveNetwork truth = truth_network(traced, 0.001 * traced.diameter);
  std::vector<std::array<int, 2>> edges;
  for (const NetworkCurve& curve : truth.curves)
    for (size_t i = 0; i + 1 < curve.vertices.size(); ++i)
      edges.push_back({curve.vertices[i], curve.vertices[i + 1]});
  Segments segments(static_cast<Eigen::Index>(edges.size()), 2);
  for (size_t i = 0; i < edges.size(); ++i)
    segments.row(static_cast<Eigen::Index>(i)) << edges[i][0], edges[i][1];
  const SegmentTree tree(truth.positions, segments);
  Points target = true_points(traced, result);
  double mean = 0;
  for (int i = 0; i < 40; ++i) {
    const Points moved = aligned(result.network.positions, target, scale);
    const std::vector<ClosestPoint> closest = tree.closest(moved);
    mean = 0;
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
      target.row(v) = closest[v].point.transpose();
      mean += std::sqrt(closest[v].squared_distance) / static_cast<double>(moved.rows());
    }
  }
  return mean / traced.diameter;
}

inline SimulateOptions noisy_device(int seed) {
  SimulateOptions options;
  options.seed = seed;
  options.orientation_noise = radians(2);
  options.drift = radians(1);
  options.odometer_error = 0.003;
  return options;
}

}  // namespace batten::test
