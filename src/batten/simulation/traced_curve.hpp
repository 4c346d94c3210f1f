#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

/// A point of a curve on a surface with its Darboux frame, without error.
struct CurvePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d tangent;  ///< unit, forward along the curve
  Eigen::Vector3d normal;   ///< unit, outward, at right angles to the tangent
};

/// A curve known as a function of its arc length.
class ArcLengthCurve {
 public:
  virtual ~ArcLengthCurve() = default;
  /// Of the whole curve, in the unit of its shape.
  virtual double length() const = 0;
  /// @param distance from the start; 0 … length(), values outside are moved to the nearer end.
  virtual CurvePoint at(double distance) const = 0;
};

/// A function of space with its gradient: f(x), and ∇f written to `gradient`.
using ImplicitFunction = std::function<double(const Eigen::Vector3d& x, Eigen::Vector3d& gradient)>;

/// Where to trace: from `start` along the common zeros of a surface and of a cutting surface.
struct TraceRequest {
  ImplicitFunction surface;      ///< its gradient points outward
  ImplicitFunction cut;          ///< a plane or another surface
  Eigen::Vector3d start;         ///< near the curve; on it where the curve is open
  Eigen::Vector3d towards;       ///< the direction in which to leave the start
  bool closed = true;            ///< back to the start, or else to `end`
  Eigen::Vector3d end{0, 0, 0};  ///< on the curve; of open curves alone
  double step = 0;               ///< between knots, small against the radius of curvature; above 0
};

/// Traces the intersection of two surfaces. Points satisfy both equations to rounding (Newton's method);
/// arc length is integrated by Gauss's rule with a relative error below 1e-12 for smooth surfaces.
/// @throws InvalidInput when Newton's method does not converge or the curve does not come to its end.
std::shared_ptr<const ArcLengthCurve> trace_intersection(const TraceRequest& request);

/// One curve of an object that is known exactly.
struct TracedCurve {
  std::string name;
  bool boundary = false;
  bool closed = false;
  std::shared_ptr<const ArcLengthCurve> path;
  /// Where the curve meets others, increasing. A closed curve with nodes begins at one: 0 … length().
  std::vector<double> node_distances;
  std::vector<int> node_ids;  ///< as many; rows of TracedNetwork::node_positions
};

/// Curves on an object, with their crossings: what simulate_scan() reads.
struct TracedNetwork {
  std::string name;
  double diameter = 0;  ///< of the surface: the diagonal of its bounding box
  std::vector<TracedCurve> curves;
  Points node_positions;  ///< n × 3
  Points node_normals;    ///< n × 3 unit outward normals of the surface
  std::vector<std::string> warnings;
};

/// The curves as polylines with exact positions and normals, at most `step` apart.
/// At 0.05 % of the diameter the polylines stay within 1e-6 diameters of curves with radii above 3 %.
/// @throws InvalidInput when step is not positive.
CurveNetwork truth_network(const TracedNetwork& traced, double step);

}  // namespace batten
