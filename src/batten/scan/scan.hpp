#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// What the tangent of reading i means (docs/methods.md#positions).
enum class TangentConvention {
  Auto,      ///< tell the two apart from the data (T·N and closure); the report says which was taken
  AtSample,  ///< the direction of the curve at the reading: what a device measures
  ToNext,    ///< the direction from reading i to reading i + 1: what exports of drawn curves store
};

/// The number of a node that is marked and has none: infer_nodes() finds one.
constexpr int kNoNodeNumber = -1;

/// The readings along one curve. A closed curve repeats its first node at the end.
struct ScanCurve {
  std::string name;
  bool boundary = false;
  bool closed = false;
  std::vector<int> node_readings;  ///< 0-based indices of the readings taken at nodes, increasing
  std::vector<int> node_ids;       ///< the global number of each of these nodes, or kNoNodeNumber; as many
  Eigen::VectorXd distances;       ///< n, along the curve from its start, not decreasing
  Points tangents;                 ///< n × 3 unit vectors in the world frame
  Points normals;                  ///< n × 3 unit vectors in the world frame, outward
  /// Of a device with a gyroscope, else empty: n × 3, rotation vectors from the reading before in the axes of
  /// the Darboux frame, X_i = X_{i−1} exp(g_i), with the bias; NaN where unknown. The first leads from the
  /// last reading of the curve before, NaN on the first curve.
  Points turns;
  Eigen::VectorXd turn_times;  ///< n, or empty: seconds since that reading; NaN for the very first
  bool sharp = false;          ///< the surface has an edge here; see NetworkCurve::sharp

  Eigen::Index n_readings() const { return distances.size(); }
};

/// Orientations and distances along curves on an object: what a device records and rawnet files hold.
struct Scan {
  std::vector<ScanCurve> curves;
  TangentConvention tangents = TangentConvention::Auto;
  std::string unit;  ///< of the distances, as written in the file, or empty (metres)
};

/// "curve 3" or "curve 3 'rim'", 1-based as users count: how errors and warnings name a curve.
std::string curve_label(const Scan& scan, int curve);

/// Whether every node has its number.
enum class NodeNumbers { Needed, MayMiss };

/// Checks what every method below assumes. @throws InvalidInput naming curve, reading or node, and the
/// remedy: no curves, fewer than two readings, sizes that differ, NaN, zero tangents, tangent parallel to
/// normal, decreasing distances, node lists that are not increasing, a closed curve whose last node is not
/// its first, and where numbers are needed nodes without one and parts that are not connected.
void check_scan(const Scan& scan, NodeNumbers numbers = NodeNumbers::Needed);

}  // namespace batten
