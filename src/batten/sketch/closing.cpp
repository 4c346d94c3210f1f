#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/units.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/sketch/closing_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Of 54 circles of a study with a tracked pen the ends come to within 0.2 of the diameter, at up to 0.11 of
// the length from either end; of 54 lines none comes back.
constexpr double kReach = 0.16;       ///< of the length: how far from its ends a loop may close
constexpr double kReachOfLoop = 0.4;  ///< the same where the stroke is known to be a loop
constexpr double kGap = 0.25;         ///< of the size: the largest gap of a loop that heads on as it began
constexpr double kGapAhead = 0.32;    ///< the same where the gap lies on the way
constexpr double kAhead = 0.8;        ///< cosine between such a gap and the way
constexpr double kCornerGap = 0.08;   ///< the same where it closes at a corner
constexpr double kBesides = 0.35;     ///< of the size: how far what is cut off may lie from the loop
constexpr double kLeastLength = 1.9;  ///< of the size: any loop is longer, twice the size at least
constexpr double kSmoothTurn = 100 * kPi / 180, kCornerTurn = 140 * kPi / 180;
constexpr double kLeastAhead = -0.6;  ///< cosine between a wide gap and the way: omegas head away from it
constexpr double kDirection = 0.04;   ///< of the length: the arms of directions
constexpr double kExactSteps = 1.5;   ///< of the mean step between samples: no gap
constexpr double kHook = 0.08;        ///< of the length: where pens slip when they are set down or taken off
constexpr double kHeadsOn = 0.2;      ///< cosine between a step and the way behind the hook
constexpr double kLeastStep = 0.4;    ///< of the mean step: from the last sample to the first
constexpr double kTangent = 0.08;     ///< of the length: the window of the parabola at an end
constexpr double kCurvatureGain = 0.5;  ///< of the mean curvature, by the blend

/// A stroke as the search for its closing sees it.
class Loop {
 public:
  explicit Loop(const Points& points) : points_(points), arcs_(arc_lengths(points)) {
    // Furthest from the beginning, and furthest from that: within a factor of 1.2 of the diameter.
    Index furthest = 0;
    (points.rowwise() - points.row(0)).rowwise().norm().maxCoeff(&furthest);
    size_ = (points.rowwise() - points.row(furthest)).rowwise().norm().maxCoeff();
  }

  double length() const { return arcs_.back(); }
  double size() const { return size_; }
  double gap(const Closing& c) const { return (points_.row(c.first) - points_.row(c.last)).norm(); }
  double mean_step() const { return length() / static_cast<double>(points_.rows() - 1); }

  /// Without the hooks at both ends: steps that do not head the way that the stroke then takes.
  Closing without_hooks() const {
    const Index n = points_.rows();
    const Index front = behind_hook([](Index i) { return i; });
    const Index back = behind_hook([n](Index i) { return n - 1 - i; });
    return {front, n - 1 - back};
  }

  /// The nearest approach of the first `reach` of the length to the last, within some rows.
  Closing nearest_approach(const Closing& within, double reach) const {
    Closing best = within;
    double least = std::numeric_limits<double>::infinity();
    for (Index i = within.first; i < within.last && arc(i) <= reach * length(); ++i)
      for (Index j = within.last; j > i + 1 && arc(j) >= (1 - reach) * length(); --j) {
        const double squared = (points_.row(i) - points_.row(j)).squaredNorm();
        if (squared < least) {
          least = squared;
          best = {i, j};
        }
      }
    return best;
  }

  /// Whether what is cut off at both ends runs beside the loop, and is no tail of its own.
  bool keeps_beside(const Closing& c) const {
    const double reach = kBesides * size_;
    const auto is_near = [&](Index i) {
      for (Index j = c.first; j <= c.last; ++j)
        if ((points_.row(i) - points_.row(j)).squaredNorm() <= reach * reach) return true;
      return false;
    };
    for (Index i = 0; i < c.first; ++i)
      if (!is_near(i)) return false;
    for (Index i = c.last + 1; i < points_.rows(); ++i)
      if (!is_near(i)) return false;
    return true;
  }

  Vector3d direction(Index i) const {
    Index low = i, high = i;
    const double arm = kDirection * length();
    while (low > 0 && arc(i) - arc(low) < arm) --low;
    while (high + 1 < points_.rows() && arc(high) - arc(i) < arm) ++high;
    return (points_.row(high) - points_.row(low)).transpose().stableNormalized();
  }

  /// Whether the way from the end to the beginning continues either: exact loops do.
  bool heads_on(const Closing& c) const {
    const Vector3d ahead = (points_.row(c.first) - points_.row(c.last)).transpose();
    return ahead.isZero(0) || ahead.dot(direction(c.first)) > 0 || ahead.dot(direction(c.last)) > 0;
  }

  /// Whether it looks like a loop that closes there.
  bool closes(const Closing& c) const {
    const double way = arc(c.last) - arc(c.first), across = gap(c);
    if (way + across < kLeastLength * size_ || across > kGapAhead * size_ || !keeps_beside(c)) return false;
    const Vector3d beginning = direction(c.first), end = direction(c.last);
    const double turn = std::atan2(end.cross(beginning).norm(), end.dot(beginning));
    if (across <= kCornerGap * size_) return turn <= kCornerTurn;
    const Vector3d ahead = (points_.row(c.first) - points_.row(c.last)).transpose() / across;
    const double on_the_way = ahead.dot((beginning + end).stableNormalized());
    return turn <= kSmoothTurn && on_the_way > (across > kGap * size_ ? kAhead : kLeastAhead);
  }

 private:
  /// Rows to leave out at an end. @param row the rows in order from that end.
  template <typename Row>
  Index behind_hook(const Row& row) const {
    const double zone = kHook * length();
    const auto from_end = [&](Index i) { return std::abs(arc(row(i)) - arc(row(0))); };
    Index inner = 0, outer = 0;
    while (inner + 2 < points_.rows() && from_end(inner) < zone) ++inner;
    while (outer + 1 < points_.rows() && from_end(outer) < 2 * zone) ++outer;
    if (outer <= inner) return 0;
    const Vector3d way = (points_.row(row(outer)) - points_.row(row(inner))).transpose().stableNormalized();
    for (Index i = inner; i > 0; --i) {
      const Vector3d step = (points_.row(row(i)) - points_.row(row(i - 1))).transpose();
      if (step.dot(way) < kHeadsOn * step.norm()) return i;
    }
    return 0;
  }
  double arc(Index i) const { return arcs_[static_cast<std::size_t>(i)]; }

  const Points& points_;
  std::vector<double> arcs_;
  double size_ = 0;
};

/// Direction at the first row, forward, of a parabola fitted to the rows within `window` of it.
Vector3d direction_at_front(const Points& points, double window) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), right = Eigen::Matrix3d::Zero();
  double arc = 0;
  for (Index i = 0; i < points.rows() && (arc <= window || i < 4); ++i) {
    if (i > 0) arc += (points.row(i) - points.row(i - 1)).norm();
    const double t = arc / window;
    const Vector3d powers(1, t, t * t);
    normal += powers * powers.transpose();
    right += powers * points.row(i);
  }
  const Vector3d slope = normal.fullPivLu().solve(right).row(1).transpose();
  return slope.stableNormalized();
}

/// 1 at 0 and 0 from 1 on, without slope at either.
double fade(double x) {
  return x >= 1 ? 0 : (1 - x) * (1 - x) * (1 + 2 * x);
}

/// Appends `n` points between the last row and the first, on a cubic that follows an arc of that turn.
void bridge(Points& loop, const Vector3d& leaving, const Vector3d& arriving, Index n) {
  if (n < 1) return;
  const Index m = loop.rows();
  const Vector3d from = loop.row(m - 1), to = loop.row(0);
  const double turn = std::atan2(leaving.cross(arriving).norm(), leaving.dot(arriving));
  const double chord = (to - from).norm();
  const double speed = turn > 1e-6 ? 2 * chord * std::tan(turn / 4) / std::sin(turn / 2) : chord;
  loop.conservativeResize(m + n, 3);
  for (Index k = 1; k <= n; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(n + 1);
    const double h01 = t * t * (3 - 2 * t), h10 = t * (1 - t) * (1 - t), h11 = t * t * (t - 1);
    loop.row(m + k - 1) =
        ((1 - h01) * from + h01 * to + speed * (h10 * leaving + h11 * arriving)).transpose();
  }
}

}  // namespace

std::optional<Closing> find_closing(const Points& points) {
  if (points.rows() < 8) return std::nullopt;
  const Loop loop(points);
  const Closing drawn = loop.without_hooks(), closing = loop.nearest_approach(drawn, kReach);
  if (!loop.closes(closing)) return std::nullopt;
  // A tail that still comes nearer where the search ends is none that a hand leaves over.
  if (loop.gap(loop.nearest_approach(drawn, 1.4 * kReach)) < 0.7 * loop.gap(closing)) return std::nullopt;
  return closing;
}

Closing closing_of_loop(const Points& points) {
  const Closing ends{0, points.rows() - 1};
  if (points.rows() < 8) return ends;
  const Loop loop(points);
  if (loop.gap(ends) <= kExactSteps * loop.mean_step() && loop.heads_on(ends)) return ends;
  const Closing drawn = loop.without_hooks();
  for (double reach = kReachOfLoop; reach > kHook; reach *= 0.6) {
    const Closing closing = loop.nearest_approach(drawn, reach);
    if (loop.keeps_beside(closing)) return closing;
  }
  return drawn;
}

ClosedLoop closed_loop(const Points& points, const Closing& closing) {
  ClosedLoop result{points.middleRows(closing.first, closing.last - closing.first + 1),
                    closing.first > 0 || closing.last + 1 < points.rows()};
  Points& loop = result.points;
  const double length = arc_lengths(loop).back(), step = length / static_cast<double>(loop.rows() - 1);
  const auto gap = [&] { return Vector3d((loop.row(0) - loop.row(loop.rows() - 1)).transpose()); };
  if (loop.rows() < 8 || (!result.joined && gap().norm() <= kExactSteps * step)) return result;
  result.joined = true;
  const auto beginning = [&] { return direction_at_front(loop, kTangent * length); };
  const auto end = [&] { return Vector3d(-direction_at_front(loop.colwise().reverse(), kTangent * length)); };
  const Vector3d t0 = beginning(), t1 = end();
  if (std::atan2(t1.cross(t0).norm(), t1.dot(t0)) > kSmoothTurn) return result;  // closes at a corner
  const Vector3d way = (t0 + t1).normalized();
  // The last samples may lie past the first: the way from them back would be a fold.
  while (loop.rows() > 8 && gap().dot(way) < kLeastStep * step) loop.conservativeResize(loop.rows() - 1, 3);
  const double ahead = gap().dot(way);
  const Vector3d aside = gap() - ahead * way;
  // A fade of half the offset over a length l has a second derivative of at most 3 |aside| / l².
  const double radius = length / (2 * kPi);
  const double blend =
      std::clamp(std::sqrt(3 * aside.norm() * radius / kCurvatureGain), 4 * step, length / 4);
  const std::vector<double> arcs = arc_lengths(loop);
  for (Index i = 0; i < loop.rows(); ++i) {
    const double arc = arcs[static_cast<std::size_t>(i)];
    loop.row(i) += (0.5 * (fade((arcs.back() - arc) / blend) - fade(arc / blend)) * aside).transpose();
  }
  bridge(loop, end(), beginning(), static_cast<Index>(std::lround(ahead / step)) - 1);
  return result;
}

}  // namespace batten::detail
