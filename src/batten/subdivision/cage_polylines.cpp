#include <algorithm>
#include <cmath>

#include "batten/subdivision/cage_polylines_detail.hpp"

namespace batten::detail {

using Row = Eigen::RowVector3d;

std::vector<double> lengths_along(const Points& points) {
  std::vector<double> lengths(static_cast<size_t>(points.rows()), 0.0);
  for (Eigen::Index k = 1; k < points.rows(); ++k)
    lengths[static_cast<size_t>(k)] =
        lengths[static_cast<size_t>(k) - 1] + (points.row(k) - points.row(k - 1)).norm();
  return lengths;
}

Row point_along(const Points& points, double fraction) {
  const std::vector<double> lengths = lengths_along(points);
  const double wanted = fraction * lengths.back();
  for (Eigen::Index k = 1; k < points.rows(); ++k) {
    const double begin = lengths[static_cast<size_t>(k) - 1], end = lengths[static_cast<size_t>(k)];
    if (wanted <= end && end > begin)
      return points.row(k - 1) + (wanted - begin) / (end - begin) * (points.row(k) - points.row(k - 1));
  }
  return points.row(points.rows() - 1);
}

double nearest_fraction(const Points& points, const Row& query) {
  const std::vector<double> lengths = lengths_along(points);
  double best = -1, fraction = 0.5;
  for (Eigen::Index k = 1; k < points.rows(); ++k) {
    const Row along = points.row(k) - points.row(k - 1);
    const double squared = along.squaredNorm();
    const double t =
        squared > 0 ? std::clamp((query - points.row(k - 1)).dot(along) / squared, 0.0, 1.0) : 0.0;
    const double distance = (points.row(k - 1) + t * along - query).squaredNorm();
    if (best < 0 || distance < best) {
      best = distance;
      if (lengths.back() > 0)
        fraction = (lengths[static_cast<size_t>(k) - 1] + t * std::sqrt(squared)) / lengths.back();
    }
  }
  return fraction;
}

std::pair<Points, Points> cut_polyline(const Points& points, double fraction) {
  const std::vector<double> lengths = lengths_along(points);
  const double wanted = fraction * lengths.back();
  const Row middle = point_along(points, fraction);
  Eigen::Index n_before = 1;
  while (n_before + 1 < points.rows() && lengths[static_cast<size_t>(n_before)] < wanted) ++n_before;
  Eigen::Index n_after = points.rows() - n_before;
  // A point of the polyline at the cut itself is not kept twice.
  if (n_after > 1 && lengths[static_cast<size_t>(n_before)] <= wanted) --n_after;
  Points first(n_before + 1, 3), second(n_after + 1, 3);
  first.topRows(n_before) = points.topRows(n_before);
  first.row(n_before) = middle;
  second.row(0) = middle;
  second.bottomRows(n_after) = points.bottomRows(n_after);
  return {std::move(first), std::move(second)};
}

}  // namespace batten::detail
