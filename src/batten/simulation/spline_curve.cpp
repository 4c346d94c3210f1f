#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/curves/polyline.hpp"
#include "batten/simulation/spline_curve_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

Points rows(const std::vector<Vector3d>& vectors) {
  Points points(static_cast<Eigen::Index>(vectors.size()), 3);
  for (size_t i = 0; i < vectors.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = vectors[i].transpose();
  return points;
}

CubicSpline spline_through(std::vector<Vector3d> knots, bool closed) {
  if (closed) knots.push_back(knots.front());
  Points points = rows(knots);
  std::vector<double> arcs = arc_lengths(points);
  return {std::move(arcs), std::move(points), closed};
}

}  // namespace

SplineCurve::SplineCurve(std::vector<Vector3d> knots, bool closed)
    : closed_(closed), spline_(spline_through(std::move(knots), closed)) {
  distances_.push_back(0);
  for (Eigen::Index i = 0; i < spline_.n_pieces(); ++i)
    distances_.push_back(distances_.back() + spline_.length(i));
}

void SplineCurve::set_normals(std::vector<Vector3d> normals) {
  if (closed_) normals.push_back(normals.front());
  normals_.emplace(spline_.knots(), rows(normals), closed_);
}

Vector3d SplineCurve::tangent_at_knot(std::size_t i) const {
  const auto piece = static_cast<Eigen::Index>(i);
  return piece < spline_.n_pieces() ? spline_.derivative(piece, 0).normalized()
                                    : spline_.derivative(piece - 1, 1).normalized();
}

CurvePoint SplineCurve::at(double distance) const {
  const double s = std::clamp(distance, 0.0, length());
  const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, s);
  const auto knot = static_cast<size_t>(after - distances_.begin()) - 1;
  const auto piece = static_cast<Eigen::Index>(knot);
  const double target = s - distances_[knot];
  double t = target / (distances_[knot + 1] - distances_[knot]);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const double error = spline_.length(piece, t) - target;
    if (std::abs(error) <= 1e-14 * length()) break;
    t = std::clamp(t - error / spline_.speed(piece, t), 0.0, 1.0);
  }
  CurvePoint point;
  point.position = spline_.at(piece, t);
  point.tangent = spline_.derivative(piece, t).normalized();
  const Vector3d normal = normals_->at(piece, t);
  point.normal = (normal - normal.dot(point.tangent) * point.tangent).normalized();
  return point;
}

}  // namespace batten::detail
