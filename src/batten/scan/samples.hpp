#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/scan/scan.hpp"

namespace batten {

/// Frames at chosen parameters of one curve: what the pre-filter makes and the regression smooths.
struct SampledCurve {
  std::string name;
  bool boundary = false;
  bool closed = false;  ///< the last sample is the same point as the first
  /// Of a closed curve: it runs on without a corner where it closes, so first and last frame are one unknown.
  bool smooth_seam = false;
  Eigen::VectorXd parameters;           ///< n, arc length from the start, increasing, in the unit of the scan
  std::vector<Eigen::Matrix3d> frames;  ///< n Darboux frames [t N B]
  Eigen::VectorXd weights;              ///< n, the number of readings that each sample stands for, ≥ 0
  /// n, or empty: what the pre-filter does to the frames beside averaging. Where the rate of turn changes by
  /// ω' along the curve, a frame is that of the curve turned by lag · ω' in its axes; square of the unit.
  Eigen::VectorXd lag;
  std::vector<int> node_samples;  ///< samples that lie at nodes, increasing
  std::vector<int> node_ids;      ///< their global numbers
  /// Of a device with a gyroscope, else empty: n × 3, rotation vectors from the sample before in the axes of
  /// the frame, with the bias; NaN where unknown. The first leads from the last sample of the curve before.
  Points turns;
  Eigen::VectorXd turn_times;  ///< n, or empty: seconds since that sample; NaN where unknown
  /// The surface has an edge here: at its nodes curves have normals of their own.
  bool sharp = false;

  int n_samples() const { return static_cast<int>(frames.size()); }
  double step(int k) const { return parameters[k + 1] - parameters[k]; }  ///< length of step k, k < n − 1
  double length() const { return parameters[n_samples() - 1] - parameters[0]; }
};

/// The curves of a scan, resampled.
struct SampledScan {
  std::vector<SampledCurve> curves;

  int n_samples() const;  ///< of all curves together
  double length() const;  ///< of all curves together
};

/// Which point of the network each sample is. Nodes come first, by increasing number, then the seams of
/// closed curves without nodes, then all other samples along the curves in their order.
struct VertexNumbering {
  std::vector<std::vector<int>> vertices;  ///< per curve and sample
  int n_nodes = 0;                         ///< vertices 0 … n_nodes − 1 are shared points
  int n_vertices = 0;
};
/// Linear in the samples.
VertexNumbering number_vertices(const SampledScan& scan);

/// The unknown frame that each sample has: its own, except for the last sample of a smooth closed curve.
struct FrameNumbering {
  std::vector<std::vector<int>> frames;  ///< per curve and sample
  int n_frames = 0;
  /// Pairs of unknown frames at one node whose normals must agree (Φ of S 3.29): every pair of visits.
  std::vector<std::pair<int, int>> node_pairs;
};
/// Linear in the samples.
FrameNumbering number_frames(const SampledScan& scan);

}  // namespace batten
