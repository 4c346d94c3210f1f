#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::Vector3d;

double noise_distance(const Stroke& stroke) {
  return std::sqrt(3.0) * 0.8 * stroke.noise;
}

Points without_repeats(const Points& points, double tolerance) {
  Points kept(points.rows(), 3);
  Index n = 0;
  for (Index i = 0; i < points.rows(); ++i)
    if (n == 0 || (points.row(i) - kept.row(n - 1)).norm() > tolerance) kept.row(n++) = points.row(i);
  kept.conservativeResize(n, 3);
  return kept;
}

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Vector3d StrokeWalk::at(double s) const {
  const double whole = arcs_.back();
  if (stroke_.closed) {
    s = std::fmod(s, whole);
    if (s < 0) s += whole;
  }
  s = std::clamp(s, 0.0, whole);
  const auto above = std::upper_bound(arcs_.begin(), arcs_.end(), s);
  auto i = static_cast<Index>(above - arcs_.begin()) - 1;
  i = std::clamp<Index>(i, 0, static_cast<Index>(arcs_.size()) - 2);
  const double span = arcs_[static_cast<size_t>(i) + 1] - arcs_[static_cast<size_t>(i)];
  const double t = span > 0 ? (s - arcs_[static_cast<size_t>(i)]) / span : 0;
  const Index j = (i + 1) % stroke_.points.rows();
  return (1 - t) * stroke_.points.row(i) + t * stroke_.points.row(j);
}

}  // namespace batten::detail
