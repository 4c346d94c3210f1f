#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/sketch/stroke.hpp"

// Private to the room.
namespace batten::detail {

/// How far a corner looks to either side, of the length of its stroke.
inline constexpr double kCornerWindow = 0.02;
/// How closely curves follow strokes without noise, of the length.
inline constexpr double kStrokeFitError = 5e-6;

/// The distance of samples from the truth, three coordinates together, that the noise of one makes likely.
/// What was smoothed lies a little closer.
double noise_distance(const Stroke& stroke);

/// The points whose distance from the last one kept is more than `tolerance`.
Points without_repeats(const Points& points, double tolerance);

/// The angle between two vectors, 0 to π.
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// A stroke as a function of arc length; closed ones are periodic, open ones end at their ends.
class StrokeWalk {
 public:
  /// @param stroke must outlive this.
  explicit StrokeWalk(const Stroke& stroke) : stroke_(stroke), arcs_(stroke.arcs()) {}

  /// The place at arc length s.
  Eigen::Vector3d at(double s) const;
  /// Arc length at row i.
  double arc(Eigen::Index i) const { return arcs_[static_cast<size_t>(i)]; }
  double length() const { return arcs_.back(); }

 private:
  const Stroke& stroke_;
  std::vector<double> arcs_;
};

}  // namespace batten::detail
