#pragma once
#include <Eigen/Core>

// The four-point rule of interpolatory subdivision. Private to the room.
namespace batten::detail {

/// The polynomial through `n` points over their knots, at t (Lagrange).
Eigen::RowVector3d interpolated(const double* knots, const Eigen::RowVector3d* points, int n, double t);

/// A point further along a row, and the knot interval that leads to it.
struct FurtherPoint {
  bool exists = false;
  Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
  double interval = 0;
};

/// The point halfway between p and q of a row: the cubic through four points, one beyond each end; at the end
/// of a row through the two beyond the other one; the parabola or the straight line where there are fewer.
/// `beyond(side, k)` gives the k-th point beyond p (side 0) or q (side 1), k = 0 or 1.
template <typename Beyond>
Eigen::RowVector3d four_point(const Eigen::RowVector3d& p, const Eigen::RowVector3d& q, double interval,
                              const Beyond& beyond) {
  const FurtherPoint before = beyond(0, 0), after = beyond(1, 0);
  double knots[4] = {0, interval, 0, 0};
  Eigen::RowVector3d points[4] = {p, q, Eigen::RowVector3d::Zero(), Eigen::RowVector3d::Zero()};
  int n = 2;
  const auto add = [&](double knot, const Eigen::RowVector3d& point) {
    knots[n] = knot;
    points[n++] = point;
  };
  if (before.exists) add(-before.interval, before.point);
  if (after.exists) add(interval + after.interval, after.point);
  if (before.exists != after.exists) {
    const FurtherPoint second = beyond(before.exists ? 0 : 1, 1);
    if (second.exists && before.exists) add(-before.interval - second.interval, second.point);
    if (second.exists && after.exists) add(interval + after.interval + second.interval, second.point);
  }
  return interpolated(knots, points, n, interval / 2);
}

}  // namespace batten::detail
