#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "batten/curves/cubic_spline.hpp"
#include "batten/simulation/traced_curve.hpp"

// Private to the room.
namespace batten::detail {

/// A cubic spline with continuous second derivatives through points and normals, by arc length.
class SplineCurve : public ArcLengthCurve {
 public:
  /// @param knots points in order, two at least; of a closed curve three, without the first repeated.
  SplineCurve(std::vector<Eigen::Vector3d> knots, bool closed);

  /// Normals at the knots, as many as `knots` (of a closed curve the first serves at the end too).
  void set_normals(std::vector<Eigen::Vector3d> normals);

  bool closed() const { return closed_; }
  std::size_t n_knots() const { return closed_ ? distances_.size() - 1 : distances_.size(); }
  double distance_of_knot(std::size_t i) const { return distances_[i]; }
  Eigen::Vector3d tangent_at_knot(std::size_t i) const;

  double length() const override { return distances_.back(); }
  /// @pre set_normals() was called.
  CurvePoint at(double distance) const override;

 private:
  bool closed_;
  CubicSpline spline_;
  std::optional<CubicSpline> normals_;
  std::vector<double> distances_;  ///< of the knots from the start
};

}  // namespace batten::detail
