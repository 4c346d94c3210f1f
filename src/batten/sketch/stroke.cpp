#include "batten/sketch/stroke.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/sketch/closing_detail.hpp"
#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten {

namespace {

using detail::angle_between;
using detail::StrokeWalk;
using detail::without_repeats;
using Eigen::Index;
using Eigen::Vector3d;

constexpr Index kMostSamples = 1000;
constexpr double kWidestWindow = 0.06;  // of the length, where there is noise; else kCornerWindow
/// Noise turns arms of so many of its standard deviations by 0.12 radians or so, an eighth of a corner.
constexpr double kWindowOfNoise = 20;
/// Times the angle of a corner: at a seam that had to be joined a kink of less is how the hand came round.
constexpr double kCornerOfHand = 1.4;

struct Noise {
  double deviation = 0;  ///< standard deviation per coordinate
  /// It is that of a hand or a device: neighbours deviate in no relation. Exact strokes of few samples seem
  /// to have some too, but it goes on from each to the next.
  bool is_random = false;
};

/// How far samples lie from the cubic through two neighbours on either side, with chord lengths as
/// parameters, so that exact smooth strokes have none to fourth order.
Noise estimate_noise(const Points& points) {
  const Index n = points.rows();
  if (n < 8) return {};
  std::vector<double> residuals;
  const Index step = std::max<Index>(1, n / 4000);
  Vector3d last = Vector3d::Zero();
  double products = 0, squares_of_all = 0;
  for (Index i = 2; i + 2 < n; i += step) {
    double t[5] = {0, 0, 0, 0, 0};
    for (int k = 1; k < 5; ++k) t[k] = t[k - 1] + (points.row(i - 2 + k) - points.row(i - 3 + k)).norm();
    Vector3d guess = Vector3d::Zero();
    double squares = 1;
    for (const int k : {0, 1, 3, 4}) {
      double weight = 1;
      for (const int j : {0, 1, 3, 4})
        if (j != k) weight *= (t[2] - t[j]) / (t[k] - t[j]);
      guess += weight * points.row(i - 2 + k).transpose();
      squares += weight * weight;
    }
    const Vector3d residual = (points.row(i).transpose() - guess) / std::sqrt(squares);
    residuals.push_back(residual.norm());
    // In directions, so that a corner counts no more than any other place.
    const Vector3d direction = residual.stableNormalized();
    products += direction.dot(last);
    squares_of_all += direction.squaredNorm();
    last = direction;
  }
  constexpr double kMostCorrelation = 0.25;  // of random deviations it is about −0.6
  return {upper_median(residuals) / 1.538,   // the median of the length of a standard normal 3-vector
          products < kMostCorrelation * squares_of_all};
}

/// Means of runs of samples where there is noise to be averaged, single samples where there is none.
Points thinned(const Points& points, bool average) {
  const Index n = points.rows();
  if (n <= kMostSamples) return points;
  Points few(kMostSamples, 3);
  for (Index k = 0; k < kMostSamples; ++k) {
    const Index begin = k * n / kMostSamples, end = (k + 1) * n / kMostSamples;
    if (average)
      few.row(k) = points.middleRows(begin, end - begin).colwise().mean();
    else
      few.row(k) = points.row(k * (n - 1) / (kMostSamples - 1));
  }
  return few;
}

/// The length of a stroke by chords over a fiftieth of its samples: where samples are denser than the noise,
/// the way from each to the next is mostly noise.
double length_by_chords(const Points& points, bool closed) {
  const Index n = points.rows(), step = std::max<Index>(1, n / 50);
  double length = 0;
  Index at = 0;
  for (; at + step < n; at += step) length += (points.row(at + step) - points.row(at)).norm();
  length += (points.row(n - 1) - points.row(at)).norm();
  return closed ? length + (points.row(0) - points.row(n - 1)).norm() : length;
}

/// Gaussian of `sigma` samples. Open strokes are continued by point reflection, which keeps their ends.
Points smoothed(const Points& points, double sigma, bool closed) {
  const Index n = points.rows();
  const auto reach = std::min<Index>(static_cast<Index>(std::ceil(3 * sigma)), n - 1);
  Points result(n, 3);
  const auto at = [&](Index i) -> Vector3d {
    if (closed) return points.row((i % n + n) % n);
    if (i < 0) return 2 * points.row(0) - points.row(-i);
    if (i >= n) return 2 * points.row(n - 1) - points.row(2 * n - 2 - i);
    return points.row(i);
  };
  for (Index i = 0; i < n; ++i) {
    Vector3d sum = Vector3d::Zero();
    double weights = 0;
    for (Index k = -reach; k <= reach; ++k) {
      const double weight = std::exp(-0.5 * static_cast<double>(k * k) / (sigma * sigma));
      sum += weight * at(i + k);
      weights += weight;
    }
    result.row(i) = sum / weights;
  }
  return result;
}

std::vector<int> find_corners(const Stroke& stroke, double corner_angle) {
  const StrokeWalk walk(stroke);
  const double window = std::clamp(kWindowOfNoise * stroke.noise, detail::kCornerWindow * walk.length(),
                                   kWidestWindow * walk.length());
  // Half an arm is enough where there is no noise.
  const double clear_of_ends = std::clamp(kWindowOfNoise * stroke.noise, window / 2, window);
  const Index n = stroke.points.rows();
  std::vector<double> turns(static_cast<size_t>(n), 0);
  for (Index i = 0; i < n; ++i) {
    const double s = walk.arc(i);
    if (!stroke.closed && std::min(s, walk.length() - s) < clear_of_ends) continue;
    const Vector3d here = stroke.points.row(i);
    turns[static_cast<size_t>(i)] = angle_between(here - walk.at(s - window), walk.at(s + window) - here);
  }
  std::vector<int> corners;
  for (Index i = 0; i < n; ++i) {
    const double turn = turns[static_cast<size_t>(i)];
    if (turn < corner_angle) continue;
    bool is_peak = true;
    for (Index j = 0; j < n && is_peak; ++j) {
      double gap = std::abs(walk.arc(i) - walk.arc(j));
      if (stroke.closed) gap = std::min(gap, walk.length() - gap);
      const double other = turns[static_cast<size_t>(j)];
      if (j != i && gap < 1.5 * window && (other > turn || (other == turn && j < i))) is_peak = false;
    }
    if (is_peak) corners.push_back(static_cast<int>(i));
  }
  return corners;
}

/// Where a hand closes a loop the pen was set down and taken off: a corner within the window of the seam
/// counts only where the stroke also turns by `least_turn` from before the hooks that pens leave to behind
/// them.
void drop_hooks_at_seam(Stroke& stroke, double least_turn) {
  const StrokeWalk walk(stroke);
  const double inner = detail::kCornerWindow * walk.length(), outer = kWidestWindow * walk.length();
  const auto is_hook = [&](int corner) {
    const double s = walk.arc(corner);
    if (std::min(s, walk.length() - s) > outer) return false;
    return angle_between(walk.at(s - inner) - walk.at(s - inner - outer),
                         walk.at(s + inner + outer) - walk.at(s + inner)) < least_turn;
  };
  stroke.corners.erase(std::remove_if(stroke.corners.begin(), stroke.corners.end(), is_hook),
                       stroke.corners.end());
}

}  // namespace

RefusedEdit::RefusedEdit(const std::string& reason, const std::string& remedy)
    : InvalidInput(reason + "; " + remedy), reason_(reason), remedy_(remedy) {}

std::vector<double> Stroke::arcs() const {
  std::vector<double> arcs = arc_lengths(points);
  if (closed) arcs.push_back(arcs.back() + (points.row(0) - points.row(points.rows() - 1)).norm());
  return arcs;
}

std::optional<std::string> StrokeOptions::problem() const {
  if (!(snap >= 0) || !std::isfinite(snap)) return concat("snap must be finite and at least 0, got ", snap);
  if (!(corner_angle > 0)) return concat("corner_angle must be above 0, got ", corner_angle);
  return std::nullopt;
}

Stroke prepare_stroke(const Points& points, const StrokeOptions& options) {
  for (Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw RefusedEdit(concat("point ", i, " of the stroke is not finite"), "leave this point out");
  // Squares of coordinates near the end of the range of double would overflow.
  if (points.rows() > 0 && points.cwiseAbs().maxCoeff() > 1e100)
    throw RefusedEdit("the stroke has coordinates beyond 1e100", "check the unit of the points");
  const double extent =
      points.rows() == 0 ? 0 : (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  if (extent <= 1e-12 * (points.rows() == 0 ? 1 : points.cwiseAbs().maxCoeff()))
    throw RefusedEdit(points.rows() == 0 ? "the stroke has no points" : "the stroke has no length",
                      "draw a stroke with two different points or more");
  // Later than the points, from which distances are often made.
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  Stroke stroke;
  stroke.points = without_repeats(points, 1e-12 * extent);
  stroke.noise = estimate_noise(stroke.points).deviation;
  stroke.points = without_repeats(thinned(stroke.points, stroke.noise > 1e-5 * extent), 1e-12 * extent);
  const Noise noise = estimate_noise(stroke.points);
  stroke.noise = noise.deviation;
  stroke.is_by_hand = noise.is_random;

  const double gap = (stroke.points.row(0) - stroke.points.row(stroke.points.rows() - 1)).norm();
  stroke.length = arc_lengths(stroke.points).back();
  stroke.closed = options.closed || (gap <= options.snap && stroke.length > 6 * options.snap);
  std::optional<detail::Closing> closing;
  if (stroke.closed)
    closing = detail::closing_of_loop(stroke.points);
  else if (options.recognise_loops)
    closing = detail::find_closing(stroke.points);
  bool joined = false;
  if (closing) {
    stroke.closed = true;
    detail::ClosedLoop loop = detail::closed_loop(stroke.points, *closing);
    stroke.points = std::move(loop.points);
    joined = loop.joined;
    const double spacing = arc_lengths(stroke.points).back() / static_cast<double>(stroke.points.rows());
    if ((stroke.points.row(0) - stroke.points.row(stroke.points.rows() - 1)).norm() < 0.5 * spacing)
      stroke.points.conservativeResize(stroke.points.rows() - 1, 3);
    if (stroke.points.rows() < 3)
      throw RefusedEdit("a closed stroke needs three different points", "draw it with three points or more");
  }
  const double spacing =
      length_by_chords(stroke.points, stroke.closed) / static_cast<double>(stroke.points.rows());
  if (stroke.noise > 0.05 * spacing) {
    const double sigma = std::clamp(2 * stroke.noise / spacing, 0.5, 12.0);
    stroke.points = smoothed(stroke.points, sigma, stroke.closed);
    stroke.points = without_repeats(stroke.points, 1e-12 * extent);
    stroke.noise *= 1 / std::sqrt(2 * std::sqrt(kPi) * std::max(sigma, 0.5));
  }
  stroke.length = stroke.arcs().back();
  if (stroke.points.rows() < (stroke.closed ? 3 : 2))
    throw RefusedEdit("the stroke is all noise around one place", "draw a longer stroke");
  stroke.corners = find_corners(stroke, options.corner_angle);
  if (stroke.closed && (joined || stroke.noise > 1e-5 * stroke.length))
    drop_hooks_at_seam(stroke, (joined ? kCornerOfHand : 1) * options.corner_angle);
  if (!stroke.closed) {  // a hook where the pen was set down or taken off, nearer to the end than any curve
    const std::vector<double> arcs = stroke.arcs();
    const auto is_hook = [&](int corner) {
      const double arc = arcs[static_cast<size_t>(corner)];
      return std::min(arc, stroke.length - arc) <= options.snap;
    };
    stroke.corners.erase(std::remove_if(stroke.corners.begin(), stroke.corners.end(), is_hook),
                         stroke.corners.end());
  }
  return stroke;
}

SelfContact self_contact(const Stroke& stroke, double distance) {
  SelfContact contact;
  const StrokeWalk walk(stroke);
  constexpr int kProbes = 512;
  const double apart = std::max(8 * distance, 4 * walk.length() / kProbes);
  Points probes(kProbes + 1, 3);
  for (int i = 0; i <= kProbes; ++i) probes.row(i) = walk.at(walk.length() * i / kProbes).transpose();
  // Between probes i, i + 1 and j, j + 1: closest points of the two segments.
  const double step = walk.length() / kProbes;
  for (int i = 0; i < kProbes; ++i)
    for (int j = i + 1; j < kProbes; ++j) {
      double gap = step * (j - i - 1);
      if (stroke.closed) gap = std::min(gap, walk.length() - step * (j - i + 1));
      if (gap < apart) continue;
      const Vector3d p = probes.row(i), q = probes.row(j);
      if ((p - q).squaredNorm() > (distance + 2 * step) * (distance + 2 * step)) continue;
      const Vector3d d = probes.row(i + 1).transpose() - p, e = probes.row(j + 1).transpose() - q, r = p - q;
      const double a = d.dot(d), b = e.dot(e), c = d.dot(e), f = e.dot(r), g = d.dot(r);
      const double det = a * b - c * c;
      double s = det > 1e-12 * a * b ? std::clamp((c * f - g * b) / det, 0.0, 1.0) : 0;
      const double t = b > 0 ? std::clamp((c * s + f) / b, 0.0, 1.0) : 0;
      s = a > 0 ? std::clamp((c * t - g) / a, 0.0, 1.0) : 0;
      const double found = (p + s * d - q - t * e).norm();
      if (found > distance) continue;
      return {true, p + s * d, found};
    }
  return contact;
}

}  // namespace batten
