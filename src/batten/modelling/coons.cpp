#include "batten/modelling/coons.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/units.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Internal angles at the corners of a face, in [0, 2π).
std::vector<double> internal_angles(const std::vector<SharedPolyline>& sides) {
  const Vector3d normal = doubled_area(sides).stableNormalized();
  std::vector<double> angles;
  for (size_t k = 0; k < sides.size(); ++k) {
    const Vector3d out = sides[k]->direction_at_front();
    const Vector3d back = sides[(k + sides.size() - 1) % sides.size()]->direction_at_back();
    const Vector3d cross = out.cross(back);
    double angle = std::atan2(cross.norm(), out.dot(back));
    // Where a face is bent, the cross product may be nearly in its mean plane; a corner is taken as reflex
    // only where it clearly points the other way.
    if (cross.dot(normal) < -0.3 * cross.norm()) angle = 2 * kPi - angle;
    angles.push_back(angle);
  }
  return angles;
}

/// Angles up to the first make a corner of a side, from the second on a side goes on, if it is not reflex.
constexpr double kCornerUpTo = 130 * kPi / 180, kJointFrom = 145 * kPi / 180, kJointUpTo = 215 * kPi / 180;

SharedPolyline point(const Vector3d& position) {
  Points points(2, 3);
  points << position.transpose(), position.transpose();
  return std::make_shared<Polyline>(std::move(points));
}

}  // namespace

Vector3d CoonsPatch::at(double u, double v) const {
  const auto on = [&](int side, double t) {
    const Polyline& polyline = *sides_[static_cast<size_t>(side)];
    return polyline.at(t * polyline.length());
  };
  const auto corner = [&](int side) { return sides_[static_cast<size_t>(side)]->front(); };
  return (1 - v) * on(0, u) + v * on(2, 1 - u) + u * on(1, v) + (1 - u) * on(3, 1 - v) -
         (1 - u) * (1 - v) * corner(0) - u * (1 - v) * corner(1) - u * v * corner(2) -
         (1 - u) * v * corner(3);
}

Points CoonsPatch::along(const Vector2d& from, const Vector2d& to, int n) const {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / n;
    const Vector2d place = (1 - t) * from + t * to;
    points.row(i) = at(place.x(), place.y()).transpose();
  }
  return points;
}

Vector2d CoonsPatch::nearest(const Vector3d& query) const {
  constexpr int kGrid = 16;
  Vector2d best(0.5, 0.5);
  double distance = (at(0.5, 0.5) - query).squaredNorm();
  for (int j = 0; j <= kGrid; ++j)
    for (int i = 0; i <= kGrid; ++i) {
      const Vector2d place(static_cast<double>(i) / kGrid, static_cast<double>(j) / kGrid);
      const double here = (at(place.x(), place.y()) - query).squaredNorm();
      if (here < distance) {
        distance = here;
        best = place;
      }
    }
  // The patch has kinks where the polylines do, so derivatives are taken over a small distance.
  constexpr double kStep = 1e-3;
  for (int round = 0; round < 20; ++round) {
    const double u = std::clamp(best.x(), kStep, 1 - kStep), v = std::clamp(best.y(), kStep, 1 - kStep);
    Eigen::Matrix<double, 3, 2> slope;
    slope << (at(u + kStep, v) - at(u - kStep, v)) / (2 * kStep),
        (at(u, v + kStep) - at(u, v - kStep)) / (2 * kStep);
    const Eigen::Matrix2d normal = slope.transpose() * slope;
    if (!(normal.determinant() > 1e-12 * normal.trace() * normal.trace())) break;
    const Vector2d move = normal.inverse() * slope.transpose() * (query - at(best.x(), best.y()));
    Vector2d next = best;
    double reached = distance;
    for (double share = 1; share > 0.1; share /= 2) {
      const Vector2d trial = (best + share * move).cwiseMax(0.0).cwiseMin(1.0);
      const double here = (at(trial.x(), trial.y()) - query).squaredNorm();
      if (here < reached) {
        reached = here;
        next = trial;
        break;
      }
    }
    if (!(reached < distance)) break;
    distance = reached;
    best = next;
  }
  return best;
}

bool FacePatch::on_one_side(int corner, int other) const {
  const Vector2d& p = parameters[static_cast<size_t>(corner)];
  const Vector2d& q = parameters[static_cast<size_t>(other)];
  return (p.x() == q.x() && (p.x() == 0 || p.x() == 1)) || (p.y() == q.y() && (p.y() == 0 || p.y() == 1));
}

int pole_of_triangle(const std::array<double, 3>& lengths) {
  int pole = 0;
  double best = -1;
  for (int k = 0; k < 3; ++k) {
    const double out = lengths[static_cast<size_t>(k)], in = lengths[static_cast<size_t>((k + 2) % 3)];
    const double likeness = std::min(out, in) / std::max(std::max(out, in), 1e-300);
    if (likeness > best * (1 + 1e-9)) {
      best = likeness;
      pole = k;
    }
  }
  return pole;
}

Vector3d doubled_area(const std::vector<SharedPolyline>& sides) {
  const Vector3d origin = sides.front()->front();
  Vector3d sum = Vector3d::Zero();
  for (const SharedPolyline& side : sides)
    for (Index i = 0; i + 1 < side->n_points(); ++i)
      sum +=
          (side->points().row(i).transpose() - origin).cross(side->points().row(i + 1).transpose() - origin);
  return sum;
}

FacePatch associate_quad(const std::vector<SharedPolyline>& sides) {
  const size_t n = sides.size();
  if (n == 2) {
    std::array<SharedPolyline, 4> halves;
    for (size_t k = 0; k < 2; ++k) {
      const double middle = sides[k]->length() / 2;
      if (middle > 0)
        std::tie(halves[2 * k], halves[2 * k + 1]) = cut(*sides[k], middle, sides[k]->at(middle));
      else
        halves[2 * k] = halves[2 * k + 1] = sides[k];
    }
    return {CoonsPatch(halves), {Vector2d(0, 0), Vector2d(1, 1)}};
  }
  if (n == 3) {
    const auto pole =
        static_cast<size_t>(pole_of_triangle({sides[0]->length(), sides[1]->length(), sides[2]->length()}));
    FacePatch face{
        CoonsPatch({point(sides[pole]->front()), sides[pole], sides[(pole + 1) % 3], sides[(pole + 2) % 3]}),
        std::vector<Vector2d>(3)};
    face.parameters[pole] = {0.5, 0};
    face.parameters[(pole + 1) % 3] = {1, 1};
    face.parameters[(pole + 2) % 3] = {0, 1};
    return face;
  }
  const std::vector<double> angles = internal_angles(sides);
  std::vector<size_t> order(n);
  for (size_t k = 0; k < n; ++k) order[k] = k;
  // Angles equal to rounding count as equal, so that the choice does not depend on where the model lies.
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::round(angles[a] * 1e6) < std::round(angles[b] * 1e6);
  });
  const bool has_four_corners =
      angles[order[3]] <= kCornerUpTo &&
      (n == 4 || (angles[order[4]] >= kJointFrom && angles[order[n - 1]] <= kJointUpTo));
  std::array<size_t, 4> corners{order[0], order[1], order[2], order[3]};
  std::sort(corners.begin(), corners.end());
  static const std::array<Vector2d, 5> kSquare{Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1),
                                               Vector2d(0, 0)};
  std::array<SharedPolyline, 4> joint;
  std::vector<Vector2d> parameters(n);
  for (size_t q = 0; q < 4; ++q) {
    const size_t first = corners[q], last = corners[(q + 1) % 4];
    double total = 0, walked = 0;
    for (size_t k = first; k != last; k = (k + 1) % n) total += sides[k]->length();
    for (size_t k = first; k != last; k = (k + 1) % n) {
      const double t = k == first ? 0 : walked / std::max(total, 1e-300);
      parameters[k] = kSquare[q] + t * (kSquare[q + 1] - kSquare[q]);  // exactly 0 or 1 across the side
      joint[q] = k == first ? sides[k] : joined(*joint[q], *sides[k]);
      walked += sides[k]->length();
    }
  }
  return {CoonsPatch(joint), std::move(parameters), has_four_corners};
}

}  // namespace batten
