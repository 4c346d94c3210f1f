#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/scan/joint.hpp"

namespace batten {

/// How a network may differ from what was found.
struct NetworkVariation {
  Points moves;  ///< of the vertices, n × 3
  Points turns;  ///< of the normals at the vertices, n × 3 rotation vectors, radians
};

/// How sure the points of a network are, after the rigid motion that takes it best onto the truth: neither
/// its place nor its direction in space counts. Lengths in the unit of the scan.
struct NetworkUncertainty {
  /// Per vertex: half the distance from the true point that 95.4 % of the cases keep to, as twice the
  /// standard deviation does for a single coordinate.
  Eigen::VectorXd deviations;
  /// Differences that are as likely as those of the truth from what was found, without a rigid motion. They
  /// hang together along and across the curves, as the errors do.
  std::vector<NetworkVariation> draws;
};

/// Draws that network_uncertainty() is meant for: they leave 7 % of doubt in a deviation.
constexpr int kUncertaintyDraws = 100;

/// Half the radius around 0 that 95.4 % of the vectors with this covariance lie within (chi-squared of the
/// same mean and variance, its quantile by [wilson1931]): exact within 2 % from one direction to three.
double deviation_of(const Eigen::Matrix3d& covariance);

/// The uncertainty of the network that integrate_steps() makes of the frames of an estimate (constant rate,
/// first differences), from the draws of that: each is integrated and moved rigidly back onto the network,
/// and the covariance of each vertex is taken. Vertices as in number_vertices(). Time and memory grow in
/// proportion to samples × draws.
/// @pre the estimate has at least two draws. @throws InvalidInput, SolverFailure, Cancelled.
NetworkUncertainty network_uncertainty(const JointEstimate& estimate, const Progress& progress = {});

}  // namespace batten
