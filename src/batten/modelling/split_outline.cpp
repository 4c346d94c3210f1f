#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/units.hpp"
#include "batten/modelling/plane_detail.hpp"
#include "batten/modelling/split_outline_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr int kSamples = 8;          ///< per side, for the outline
constexpr double kReflex = 10;       ///< degrees above 180 at which a corner counts as reflex
constexpr double kTurnedOver = 120;  ///< degrees between a part and its face
constexpr double kMostBent = 65;     ///< degrees between a corner and its face: 55 in an octant of a sphere
constexpr double kBarelyShown =
    0.7;                             ///< of its length: a piece of the outline of half a tube, flaring or not
constexpr double kLeastSine = 0.02;  ///< of the angle at which a diagonal leaves the border

bool properly_crosses(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double c_side = cross_in_plane(b - a, c - a), d_side = cross_in_plane(b - a, d - a);
  const double a_side = cross_in_plane(d - c, a - c), b_side = cross_in_plane(d - c, b - c);
  return ((c_side > 0) != (d_side > 0)) && ((a_side > 0) != (b_side > 0)) && c_side != 0 && d_side != 0 &&
         a_side != 0 && b_side != 0;
}

double distance_from_segment(const Vector2d& q, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0 ? std::clamp((q - a).dot(along) / squared, 0.0, 1.0) : 0;
  return (a + t * along - q).norm();
}

}  // namespace

SplitOutline::SplitOutline(const std::vector<SharedPolyline>& sides) : n_(static_cast<int>(sides.size())) {
  const Vector3d area = doubled_area(sides);
  normal_ = area.stableNormalized();
  origin_ = sides.front()->front();
  if (normal_.squaredNorm() > 0) {
    first_ = normal_.unitOrthogonal();
    second_ = normal_.cross(first_);
  } else {
    first_ = Vector3d::UnitX();
    second_ = Vector3d::UnitY();
  }
  double least_shown = 1;  // of a piece of the outline, in the plane
  for (int k = 0; k < n_; ++k) {
    const Polyline& side = *sides[at(k)];
    corners_.push_back(side.front());
    // Directions over a quarter of the length: bent faces run into their mean normal at the very end.
    out_.push_back((side.at(side.length() / 4) - side.front()).stableNormalized());
    back_.push_back((side.at(side.length() * 3 / 4) - side.back()).stableNormalized());
    const Points samples = side.sampled(kSamples);
    Vector3d swept = Vector3d::Zero();
    for (int i = 0; i < kSamples; ++i) {
      const Vector3d step = samples.row(i + 1) - samples.row(i);
      if (step.norm() > 0)
        least_shown = std::min(least_shown, (step - step.dot(normal_) * normal_).norm() / step.norm());
      const Vector3d p = samples.row(i).transpose() - origin_;
      swept += p.cross(Vector3d(samples.row(i + 1).transpose() - origin_));
      outline_.push_back(flat(samples.row(i)));
      heights_.push_back(p.dot(normal_));
    }
    swept_.push_back(swept);
  }
  is_simple_ = normal_.squaredNorm() > 0 && !is_bent();
  const size_t m = outline_.size();
  for (size_t i = 0; i < m && is_simple_; ++i)
    for (size_t j = i + 1; j < m && is_simple_; ++j)
      is_simple_ = !properly_crosses(outline_[i], outline_[(i + 1) % m], outline_[j], outline_[(j + 1) % m]);
  leaves_.assign(at(n_) * at(n_), -1);
  if (n_ <= 3) return;
  const FacePatch quad = associate_quad(sides);
  if (n_ > 4 && quad.has_four_corners && least_shown < kBarelyShown) is_simple_ = false;
  if (!is_simple_) follow_patch(quad);
}

bool SplitOutline::has_reflex_corner() const {
  for (int k = 0; k < n_; ++k)
    if (interior_angle(out_[at(k)], back_[at((k + n_ - 1) % n_)], normal_) > kPi + kReflex * kPi / 180)
      return true;
  return false;
}

int SplitOutline::flaws_of_diagonal(int i, int j) const {
  if ((i + 1) % n_ == j || (j + 1) % n_ == i) return 0;
  if (!is_simple_) return diagonals_[entry(i, j)].along_border ? 3 : 0;
  int& known = leaves_[at(std::min(i, j)) * at(n_) + at(std::max(i, j))];
  if (known < 0) {
    const Vector2d a = flat(corner(i)), b = flat(corner(j));
    known = 0;
    for (int s = 0; s <= kSamples && known == 0; ++s) {
      const double t = (s + 0.5) / (kSamples + 1);
      const Vector2d q = (1 - t) * a + t * b;
      if (!contains(q) || clearance(q) < kLeastSine * std::min(t, 1 - t) * (b - a).norm()) known = 3;
    }
    if (known == 0 && crosses_outline(a, b)) known = 3;
  }
  return known;
}

bool SplitOutline::leaves(const Points& curve) const {
  for (Index k = 0; k + 1 < curve.rows(); ++k) {
    if (k > 0 && !contains(flat(curve.row(k)))) return true;
    // Its ends lie on the outline: the first and last segments are let off.
    if (k > 0 && k + 2 < curve.rows() && crosses_outline(flat(curve.row(k)), flat(curve.row(k + 1))))
      return true;
  }
  return false;
}

SplitCost SplitOutline::cost_of_part(const int* part, int size) const {
  SplitCost cost;
  Vector3d area = Vector3d::Zero();
  double perimeter = 0;
  for (int k = 0; k < size; ++k) {
    const int i = part[k], j = part[(k + 1) % size];
    const Vector3d chord = corner(j) - corner(i);
    perimeter += chord.norm();
    area += is_side(i, j)        ? swept_[at(i)]
            : diagonals_.empty() ? Vector3d((corner(i) - origin_).cross(corner(j) - origin_))
                                 : diagonals_[entry(i, j)].swept;
  }
  const Vector3d normal = area.stableNormalized();
  cost.planarity = std::atan2(normal.cross(normal_).norm(), normal.dot(normal_));
  if (cost.planarity > kTurnedOver * kPi / 180 || area.norm() < 1e-6 * perimeter * perimeter) cost.flaws += 2;
  const double regular = kPi * (size - 2) / size;
  for (int k = 0; k < size; ++k) {
    const int here = part[k], next = part[(k + 1) % size], last = part[(k + size - 1) % size];
    const Vector3d to_next = is_side(here, next) ? out_[at(here)] : leaving(here, next);
    const Vector3d to_last = is_side(last, here) ? back_[at(last)] : leaving(here, last);
    const double curved = interior_angle(to_next, to_last, normal);
    const double straight = interior_angle(direction(here, next), direction(here, last), normal);
    // Only where both say so: sides that bulge out make corners of chords reflex, and faces that bend by
    // more than a right angle make ends of their sides look so.
    if (std::min(curved, straight) > kPi + kReflex * kPi / 180) ++cost.flaws;
    cost.shape += std::abs(curved - regular) / size;
  }
  return cost;
}

void SplitOutline::follow_patch(const FacePatch& quad) {
  diagonals_.resize(at(n_) * at(n_));
  for (int i = 0; i < n_; ++i)
    for (int j = 0; j < n_; ++j) {
      if (i == j) continue;
      Over& over = diagonals_[entry(i, j)];
      over.along_border = quad.on_one_side(i, j);
      const Points line = quad.patch.along(quad.parameters[at(i)], quad.parameters[at(j)], kSamples);
      over.swept.setZero();
      for (int k = 0; k < kSamples; ++k)
        over.swept += (line.row(k).transpose() - origin_).cross(line.row(k + 1).transpose() - origin_);
      over.leaving = (line.row(kSamples / 4) - line.row(0)).transpose().stableNormalized();
    }
}

Vector3d SplitOutline::leaving(int from, int to) const {
  return diagonals_.empty() ? direction(from, to) : diagonals_[entry(from, to)].leaving;
}

bool SplitOutline::is_bent() const {
  for (int k = 0; k < n_; ++k) {
    const Vector3d cross = out_[at(k)].cross(back_[at((k + n_ - 1) % n_)]);
    // Straight corners have no plane of their own; reflex ones have the other sign.
    if (cross.norm() > 0.17 && std::abs(cross.dot(normal_)) < std::cos(kMostBent * kPi / 180) * cross.norm())
      return true;
  }
  return false;
}

double SplitOutline::interior_angle(const Vector3d& next, const Vector3d& last, const Vector3d& normal) {
  const double angle = std::atan2(next.cross(last).dot(normal), next.dot(last));
  // In the plane of the part; what sticks out of it changes little for parts that are nearly plane.
  return angle < -1e-9 ? angle + 2 * kPi : angle;
}

bool SplitOutline::contains(const Vector2d& q) const {  // by the number of crossings with a ray
  bool inside = false;
  for (size_t i = 0, m = outline_.size(); i < m; ++i) {
    const Vector2d &a = outline_[i], &b = outline_[(i + 1) % m];
    if ((a.y() > q.y()) != (b.y() > q.y()) &&
        q.x() < a.x() + (q.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

double SplitOutline::clearance(const Vector2d& q) const {
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0, m = outline_.size(); i < m; ++i)
    least = std::min(least, distance_from_segment(q, outline_[i], outline_[(i + 1) % m]));
  return least;
}

bool SplitOutline::crosses_outline(const Vector2d& a, const Vector2d& b) const {
  // Ends that are corners touch the outline there; a thousandth is left off on either side.
  const Vector2d p = a + 1e-3 * (b - a), q = b + 1e-3 * (a - b);
  for (size_t i = 0, m = outline_.size(); i < m; ++i)
    if (properly_crosses(p, q, outline_[i], outline_[(i + 1) % m])) return true;
  return false;
}

Points SplitOutline::lifted(const Vector2d& from, const Vector2d& to, int n_segments) const {
  // A quadric over the plane, fitted to the outline; the faintest pull keeps what the outline does not
  // determine (a circle does not tell 1 from x² + y²) at zero.
  const double size = std::max((outline_.front() - outline_[outline_.size() / 2]).norm(), 1e-300);
  const auto terms = [&](const Vector2d& q) {
    const double x = q.x() / size, y = q.y() / size;
    Eigen::Matrix<double, 6, 1> row;
    row << 1, x, y, x * x, x * y, y * y;
    return row;
  };
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  for (size_t i = 0; i < outline_.size(); ++i) {
    const auto row = terms(outline_[i]);
    A += row * row.transpose();
    b += row * heights_[i];
  }
  const double pull = 1e-6 * static_cast<double>(outline_.size());
  A.diagonal().array() += Eigen::Array<double, 6, 1>(1e-9, 1e-9, 1e-9, 1, 1, 1) * pull;
  const Eigen::Matrix<double, 6, 1> quadric = A.ldlt().solve(b);
  std::vector<double> rest(outline_.size());
  for (size_t i = 0; i < outline_.size(); ++i) rest[i] = heights_[i] - terms(outline_[i]).dot(quadric);
  // Mean value interpolation of the rest ([hormann2006], without their special cases: the ends
  // are corners and set exactly below).
  const auto interpolated = [&](const Vector2d& q) {
    double sum = 0, total = 0;
    const size_t m = outline_.size();
    const auto half_tangent = [&](const Vector2d& a, const Vector2d& c) {
      const double r = a.norm() * c.norm();
      const double denominator = r + a.dot(c), numerator = cross_in_plane(a, c);
      return std::abs(denominator) > 1e-14 * r ? numerator / denominator : 0.0;
    };
    for (size_t i = 0; i < m; ++i) {
      const Vector2d before = outline_[(i + m - 1) % m] - q, here = outline_[i] - q,
                     after = outline_[(i + 1) % m] - q;
      const double r = here.norm();
      if (r < 1e-12 * size) return rest[i];
      const double weight = (half_tangent(before, here) + half_tangent(here, after)) / r;
      sum += weight * rest[i];
      total += weight;
    }
    return std::abs(total) > 0 ? sum / total : 0.0;
  };
  Points points(n_segments + 1, 3);
  for (int k = 0; k <= n_segments; ++k) {
    const double t = static_cast<double>(k) / n_segments;
    const Vector2d q = (1 - t) * from + t * to;
    const double height = terms(q).dot(quadric) + interpolated(q);
    points.row(k) = (origin_ + q.x() * first_ + q.y() * second_ + height * normal_).transpose();
  }
  return points;
}

}  // namespace batten::detail
