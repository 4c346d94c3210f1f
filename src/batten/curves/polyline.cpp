#include "batten/curves/polyline.hpp"

#include <algorithm>

namespace batten {

namespace {

Box box_of(const Points& points, Eigen::Index first, Eigen::Index last) {
  const auto rows = points.middleRows(first, last - first + 1);
  return {rows.colwise().minCoeff(), rows.colwise().maxCoeff()};
}

}  // namespace

std::vector<double> arc_lengths(const Points& points) {
  std::vector<double> arcs(static_cast<size_t>(points.rows()), 0);
  for (Eigen::Index i = 1; i < points.rows(); ++i)
    arcs[static_cast<size_t>(i)] =
        arcs[static_cast<size_t>(i) - 1] + (points.row(i) - points.row(i - 1)).norm();
  return arcs;
}

Polyline::Polyline(Points points) : points_(std::move(points)) {
  const Eigen::Index n = points_.rows();
  arcs_ = arc_lengths(points_);
  box_ = box_of(points_, 0, n - 1);
  for (Eigen::Index first = 0; first < n - 1; first += kBlock)
    blocks_.push_back(box_of(points_, first, std::min(first + kBlock, n - 1)));
}

Eigen::Index Polyline::segment_at(double arc_length) const {
  const auto above = std::upper_bound(arcs_.begin(), arcs_.end(), arc_length);
  const Eigen::Index segment = static_cast<Eigen::Index>(above - arcs_.begin()) - 1;
  return std::clamp<Eigen::Index>(segment, 0, points_.rows() - 2);
}

Eigen::Vector3d Polyline::at(double arc_length) const {
  if (arc_length <= 0) return front();
  if (arc_length >= length()) return back();
  const Eigen::Index i = segment_at(arc_length);
  const double span = arc(i + 1) - arc(i);
  const double t = span > 0 ? (arc_length - arc(i)) / span : 0;
  return (1 - t) * points_.row(i) + t * points_.row(i + 1);
}

Points Polyline::sampled(int n) const {
  Points samples(n + 1, 3);
  for (int i = 0; i <= n; ++i) samples.row(i) = at(length() * i / n);
  samples.row(n) = points_.row(points_.rows() - 1);
  return samples;
}

Eigen::Vector3d Polyline::direction_at_front() const {
  return (at(length() / 20) - front()).stableNormalized();
}

Eigen::Vector3d Polyline::direction_at_back() const {
  return (at(length() * 19 / 20) - back()).stableNormalized();
}

std::pair<SharedPolyline, SharedPolyline> cut(const Polyline& polyline, double arc_length,
                                              const Eigen::Vector3d& at) {
  const Points& points = polyline.points();
  const Eigen::Index i = polyline.segment_at(arc_length), n = points.rows();
  // A point of the polyline that the cut falls on is not repeated.
  const double tiny = 1e-9 * polyline.length();
  const Eigen::Index keep_first = arc_length - polyline.arc(i) <= tiny && i > 0 ? i : i + 1;
  const Eigen::Index from_second = polyline.arc(i + 1) - arc_length <= tiny && i + 2 < n ? i + 2 : i + 1;
  Points first(keep_first + 1, 3), second(n - from_second + 1, 3);
  first.topRows(keep_first) = points.topRows(keep_first);
  first.row(keep_first) = at.transpose();
  second.row(0) = at.transpose();
  second.bottomRows(n - from_second) = points.bottomRows(n - from_second);
  return {std::make_shared<Polyline>(std::move(first)), std::make_shared<Polyline>(std::move(second))};
}

SharedPolyline reversed(const Polyline& polyline) {
  return std::make_shared<Polyline>(Points(polyline.points().colwise().reverse()));
}

SharedPolyline joined(const Polyline& first, const Polyline& second) {
  Points points(first.n_points() + second.n_points() - 1, 3);
  points.topRows(first.n_points()) = first.points();
  points.bottomRows(second.n_points() - 1) = second.points().bottomRows(second.n_points() - 1);
  return std::make_shared<Polyline>(std::move(points));
}

}  // namespace batten
