#include "batten/sketch/stroke.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/curves/bspline.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/sketch/closing_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr Index kMostSamples = 1000;
constexpr double kWindow = 0.02;  // of the length: how far a corner looks to either side
constexpr double kWidestWindow = 0.06;
/// Noise turns arms of so many of its standard deviations by 0.12 radians or so, an eighth of a corner.
constexpr double kWindowOfNoise = 20;
/// Times the angle of a corner: at a seam that had to be joined a kink of less is how the hand came round.
constexpr double kCornerOfHand = 1.4;
constexpr double kChordError = 1e-5;  // of the length
constexpr double kFitError = 5e-6;    // of the length; of strokes without noise
constexpr double kClearOfHolds = 10;  // times how far a held point lies off the stroke
/// Four held points in a row that are nearer to each other than this share of the length are too dense for a
/// spline to go through all of them: with about one in every span the system is close to singular, with more
/// it has no solution, and the curve swings, each by more than those that it crosses.
constexpr double kDenseFour = 0.07;

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

Points without_repeats(const Points& points, double tolerance) {
  Points kept(points.rows(), 3);
  Index n = 0;
  for (Index i = 0; i < points.rows(); ++i)
    if (n == 0 || (points.row(i) - kept.row(n - 1)).norm() > tolerance) kept.row(n++) = points.row(i);
  kept.conservativeResize(n, 3);
  return kept;
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

/// A stroke as a function of arc length; closed ones are periodic.
class ArcWalk {
 public:
  explicit ArcWalk(const Stroke& stroke) : stroke_(stroke), arcs_(stroke.arcs()) {}

  Vector3d at(double s) const {
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
  double arc(Index i) const { return arcs_[static_cast<size_t>(i)]; }
  double length() const { return arcs_.back(); }

 private:
  const Stroke& stroke_;
  std::vector<double> arcs_;
};

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::vector<int> find_corners(const Stroke& stroke, double corner_angle) {
  const ArcWalk walk(stroke);
  const double window =
      std::clamp(kWindowOfNoise * stroke.noise, kWindow * walk.length(), kWidestWindow * walk.length());
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
  const ArcWalk walk(stroke);
  const double inner = kWindow * walk.length(), outer = kWidestWindow * walk.length();
  const auto is_hook = [&](int corner) {
    const double s = walk.arc(corner);
    if (std::min(s, walk.length() - s) > outer) return false;
    return angle_between(walk.at(s - inner) - walk.at(s - inner - outer),
                         walk.at(s + inner + outer) - walk.at(s + inner)) < least_turn;
  };
  stroke.corners.erase(std::remove_if(stroke.corners.begin(), stroke.corners.end(), is_hook),
                       stroke.corners.end());
}

struct Sample {
  double t, weight;
  Vector3d point;
};

/// A cubic spline over [0, 1], and what is added to it between held points.
struct Spline {
  int spans = 1;
  bool periodic = false;
  Points control;
  /// In order of t; `point` is what is missing there. From one to the next it changes without overshoot and
  /// with no slope at either end, so that it is never more than the larger of the two.
  std::vector<Sample> offsets;

  Vector3d at(double t) const {
    const CubicBasis basis = cubic_basis(t * spans, spans, periodic);
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) sum += basis.values[k] * control.row(index(basis.first + k)).transpose();
    return offsets.empty() ? sum : sum + offset_at(t);
  }
  Vector3d offset_at(double t) const {
    const auto above = std::upper_bound(offsets.begin(), offsets.end(), t,
                                        [](double value, const Sample& sample) { return value < sample.t; });
    const bool before_all = above == offsets.begin(), after_all = above == offsets.end();
    const Sample &one = before_all ? offsets.back() : *(above - 1),
                 &next = after_all ? offsets.front() : *above;
    if (!periodic && (before_all || after_all)) return before_all ? next.point : one.point;
    const double t0 = before_all ? one.t - 1 : one.t, t1 = after_all ? next.t + 1 : next.t;
    const double s = t1 > t0 ? (t - t0) / (t1 - t0) : 0, rise = s * s * (3 - 2 * s);
    return (1 - rise) * one.point + rise * next.point;
  }
  Index index(int k) const { return periodic ? k % control.rows() : k; }
};

/// Least squares with equality constraints, solved with their multipliers.
/// @param bending weight of the second differences of control points beside all samples together.
Spline least_squares_spline(const std::vector<Sample>& samples, const std::vector<Sample>& held, int spans,
                            bool periodic, double bending) {
  Spline spline;
  spline.spans = spans;
  spline.periodic = periodic;
  const Index m = periodic ? spans : spans + 3, c = static_cast<Index>(held.size());
  spline.control.setZero(m, 3);
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + c, m + c);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(m + c, 3);
  for (const Sample& sample : samples) {
    const CubicBasis basis = cubic_basis(sample.t * spans, spans, periodic);
    for (int a = 0; a < 4; ++a) {
      const Index i = spline.index(basis.first + a);
      for (int b = 0; b < 4; ++b)
        system(i, spline.index(basis.first + b)) += sample.weight * basis.values[a] * basis.values[b];
      right.row(i) += sample.weight * basis.values[a] * sample.point.transpose();
    }
  }
  for (Index k = 0; k + 2 < m + (periodic ? 2 : 0); ++k) {
    const Index ids[3] = {k % m, (k + 1) % m, (k + 2) % m};
    const double row[3] = {1, -2, 1};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) system(ids[a], ids[b]) += bending * row[a] * row[b];
  }
  for (Index k = 0; k < c; ++k) {
    const Sample& hold = held[static_cast<size_t>(k)];
    const CubicBasis basis = cubic_basis(hold.t * spans, spans, periodic);
    for (int a = 0; a < 4; ++a) {
      const Index i = spline.index(basis.first + a);
      system(m + k, i) += basis.values[a];
      system(i, m + k) += basis.values[a];
    }
    right.row(m + k) = hold.point.transpose();
  }
  spline.control = system.partialPivLu().solve(right).topRows(m);
  return spline;
}

/// What a spline is asked for.
struct FitAims {
  double tolerance;  ///< root mean square distance from the samples
  double bending;    ///< see least_squares_spline()
  /// At most one span for every two samples or so: more would follow their noise and swing between them.
  bool noisy;
};

/// The spline with as few spans as follow the samples, held at points that are not dense.
Spline spline_through(const std::vector<Sample>& samples, const std::vector<Sample>& held, bool periodic,
                      const FitAims& aims) {
  Spline best;
  const int most_spans = static_cast<int>(samples.size()) / (aims.noisy ? 4 : 1);
  double closest_holds = 1;
  for (size_t i = 0; i < held.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      double gap = std::abs(held[i].t - held[j].t);
      if (periodic) gap = std::min(gap, 1 - gap);
      closest_holds = std::min(closest_holds, gap);
    }
  for (int spans = periodic ? 8 : 4; spans <= 128; spans *= 2) {
    best = least_squares_spline(samples, held, spans, periodic, aims.bending);
    double squares = 0, weights = 0, worst_hold = 0;
    for (const Sample& sample : samples) {
      squares += sample.weight * (best.at(sample.t) - sample.point).squaredNorm();
      weights += sample.weight;
    }
    for (const Sample& hold : held) worst_hold = std::max(worst_hold, (best.at(hold.t) - hold.point).norm());
    const bool holds =
        best.control.allFinite() && worst_hold <= aims.tolerance && closest_holds * spans >= 0.5;
    const bool follows = squares <= aims.tolerance * aims.tolerance * weights;
    if (holds && (follows || (aims.noisy ? spans > most_spans : spans >= most_spans))) break;
  }
  return best;
}

/// The spline with as few spans as follow the samples. Where held points are dense, they are samples like
/// the others, and what the spline then misses them by is added to it.
/// @param held in order of t; ends of open strokes among them.
Spline fitted_spline(const std::vector<Sample>& samples, const std::vector<Sample>& held, bool periodic,
                     const FitAims& aims) {
  const bool dense = [&] {
    for (size_t i = 0; i + 3 < held.size(); ++i)
      if (held[i + 3].t - held[i].t < kDenseFour) return true;
    return false;
  }();
  if (!dense) return spline_through(samples, held, periodic, aims);
  std::vector<Sample> all = samples, ends;
  for (size_t i = 0; i < held.size(); ++i) {
    if (!periodic && (i == 0 || i + 1 == held.size())) {
      ends.push_back(held[i]);
      continue;
    }
    all.push_back(held[i]);
    const double before = i > 0 ? held[i - 1].t : held.back().t - 1;
    const double after = i + 1 < held.size() ? held[i + 1].t : held.front().t + 1;
    all.back().weight = (after - before) / 2;
  }
  Spline spline = spline_through(all, ends, periodic, aims);
  std::vector<Sample> offsets = held;
  for (Sample& offset : offsets) offset.point -= spline.at(offset.t);
  spline.offsets = std::move(offsets);
  return spline;
}

/// Samples of hands depend on each other: so many in a row count as one, and no stroke as more than so many.
constexpr double kSamplesOfTremor = 4, kMostSamplesOfHand = 80;
/// A corner has a place and two directions of its own: so many parameters, beside those of its parts.
constexpr double kParametersOfCorner = 3;

/// How many samples of so many count.
double free_samples(Index n) {
  return std::max(2.0, std::min(static_cast<double>(n), kMostSamplesOfHand) / kSamplesOfTremor);
}

/// A free spline through samples, with what the Bayesian information criterion wants to know of it.
struct FreeFit {
  Spline spline;
  double rest = 0;  ///< mean square distance from the samples
  double parameters = 0;
};

/// A span without a sample, or an end of one of half its length, goes where it likes.
bool leaves_spans_empty(const std::vector<Sample>& samples, int spans) {
  double last = 0;
  for (const Sample& sample : samples) {
    if ((sample.t - last) * spans > (last == 0 ? 0.5 : 1)) return true;
    last = sample.t;
  }
  return (1 - last) * spans > 0.5;
}

/// The one that the criterion prefers. @param noise the least root mean square distance that is believed.
FreeFit likeliest_spline(const std::vector<Sample>& samples, bool periodic, double noise) {
  constexpr std::size_t kFewSamples = 8;  // do not tell how they bend: they are nearly straight
  static constexpr std::array<int, 13> kSpans{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96};
  const double n_free = free_samples(static_cast<Index>(samples.size()));
  FreeFit best;
  double least = std::numeric_limits<double>::infinity();
  for (const int spans : kSpans) {
    const double parameters = periodic ? spans : spans + 3;
    if (periodic && spans < 4) continue;
    if (std::isfinite(least) &&
        (parameters > 0.6 * static_cast<double>(samples.size()) || leaves_spans_empty(samples, spans)))
      break;
    Spline spline =
        least_squares_spline(samples, {}, spans, periodic, samples.size() < kFewSamples ? 1e-2 : 1e-9);
    double squares = 0, weights = 0;
    for (const Sample& sample : samples) {
      squares += sample.weight * (spline.at(sample.t) - sample.point).squaredNorm();
      weights += sample.weight;
    }
    const double rest = std::max(squares / weights, noise * noise);
    const double criterion = n_free * std::log(rest) + parameters * std::log(n_free);
    if (!spline.control.allFinite() || !(criterion < least)) continue;
    least = criterion;
    best = {std::move(spline), rest, parameters};
  }
  return best;
}

Points sampled(const Spline& spline, double t0, double t1, int n) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    double t = t0 + (t1 - t0) * i / n;
    if (t > 1) t = spline.periodic ? t - 1 : 1;
    points.row(i) = spline.at(t).transpose();
  }
  return points;
}

/// How often a part of a spline has to be sampled so that chords keep within kChordError of the length.
int samples_needed(const Spline& spline, double t0, double t1, double length) {
  const int probes = 8 + static_cast<int>(4 * spline.spans * (t1 - t0));
  const Points points = sampled(spline, t0, t1, probes);
  double turning = 0, own = 0;
  for (Index i = 1; i < points.rows(); ++i) {
    own += (points.row(i) - points.row(i - 1)).norm();
    if (i + 1 < points.rows())
      turning += angle_between(points.row(i) - points.row(i - 1), points.row(i + 1) - points.row(i));
  }
  return std::clamp(static_cast<int>(std::ceil(std::sqrt(turning * own / (8 * kChordError * length)))), 16,
                    1000);
}

}  // namespace

RefusedEdit::RefusedEdit(const std::string& reason, const std::string& remedy)
    : InvalidInput(reason + "; " + remedy), reason_(reason), remedy_(remedy) {}

std::vector<double> Stroke::arcs() const {
  std::vector<double> arcs = arc_lengths(points);
  if (closed) arcs.push_back(arcs.back() + (points.row(0) - points.row(points.rows() - 1)).norm());
  return arcs;
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

namespace {

/// Noise of this share of the length is that of a hand or a device.
bool is_noisy(const Stroke& stroke) {
  return std::sqrt(3.0) * 0.8 * stroke.noise > kFitError * stroke.length;
}

/// Offsets at places of a stroke, and between them a share of each without overshoot.
Points offsets_along(const Stroke& stroke, const std::vector<Sample>& offsets) {
  Spline field;
  field.periodic = stroke.closed;
  field.offsets = offsets;
  const std::vector<double> arcs = stroke.arcs();
  Points result(stroke.points.rows(), 3);
  for (Index i = 0; i < result.rows(); ++i)
    result.row(i) = field.offset_at(arcs[static_cast<size_t>(i)] / arcs.back()).transpose();
  return result;
}

/// A neat stroke that goes through its held points. @param held gets the arcs that they then have.
Stroke through_held(Stroke stroke, std::vector<HeldPoint>& held) {
  const ArcWalk walk(stroke);
  const double length = walk.length();
  std::vector<Sample> offsets;
  for (const HeldPoint& hold : held)
    offsets.push_back({hold.arc / length, 1, hold.position - walk.at(hold.arc)});
  const auto is_off = [&](const Sample& offset) { return offset.point.norm() > kFitError * length; };
  if (std::none_of(offsets.begin(), offsets.end(), is_off)) return stroke;
  // Rows at the held points, so that their arcs are known afterwards.
  const std::vector<double> arcs = stroke.arcs();
  std::vector<std::pair<double, int>> order;  // arc, row of the stroke or ~held
  for (Index i = 0; i < stroke.points.rows(); ++i)
    order.emplace_back(arcs[static_cast<size_t>(i)], static_cast<int>(i));
  for (size_t k = 0; k < held.size(); ++k) order.emplace_back(held[k].arc, ~static_cast<int>(k));
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const Points moved = stroke.points + offsets_along(stroke, offsets);
  const double least_step = 1e-3 * length / static_cast<double>(stroke.points.rows());
  Stroke result = stroke;
  result.points.resize(static_cast<Index>(order.size()), 3);
  result.corners.clear();
  std::vector<Index> row_of_held(held.size());
  Index n = 0;
  double last = -1;
  bool last_is_held = false;
  for (const auto& [arc, what] : order) {
    const bool is_held = what < 0;
    const bool is_corner = !is_held && std::count(stroke.corners.begin(), stroke.corners.end(), what) > 0;
    if (n > 0 && arc - last <= least_step && !(is_held && last_is_held)) {  // one row for both
      if (is_held) {
        result.points.row(n - 1) = held[static_cast<size_t>(~what)].position.transpose();
        row_of_held[static_cast<size_t>(~what)] = n - 1;
        last_is_held = true;
      }
      if (is_corner) result.corners.push_back(static_cast<int>(n - 1));
      continue;
    }
    if (is_corner) result.corners.push_back(static_cast<int>(n));
    if (is_held) row_of_held[static_cast<size_t>(~what)] = n;
    result.points.row(n++) =
        is_held ? held[static_cast<size_t>(~what)].position.transpose() : moved.row(what).eval();
    last = arc;
    last_is_held = is_held;
  }
  result.points.conservativeResize(n, 3);
  const std::vector<double> new_arcs = result.arcs();
  result.length = new_arcs.back();
  for (size_t k = 0; k < held.size(); ++k) {
    const bool at_end = !stroke.closed && row_of_held[k] + 1 == n;
    held[k].arc = at_end ? result.length : new_arcs[static_cast<size_t>(row_of_held[k])];
  }
  return result;
}

}  // namespace

namespace {

/// A stroke in parts from corner to corner, each a free spline.
class NeatParts {
 public:
  explicit NeatParts(const Stroke& stroke)
      : stroke_(stroke), arcs_(stroke.arcs()), n_(stroke.points.rows()), corners_(stroke.corners) {
    choose();
  }

  /// Takes away corners that the Bayesian information criterion does without, one by one.
  void drop_doubtful_corners() {
    while (!corners_.empty()) {
      const double now = criterion();
      double least = now;
      size_t best = corners_.size();
      const std::vector<int> all = corners_;
      for (size_t k = 0; k < all.size(); ++k) {
        corners_ = all;
        corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(k));
        choose();
        if (const double without = criterion(); without < least) {
          least = without;
          best = k;
        }
      }
      corners_ = all;
      if (best < all.size()) corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(best));
      choose();
      if (best == all.size()) return;
    }
  }

  /// The parts joined half way where they meet.
  Stroke joined() const {
    std::vector<Spline> splines;
    for (const auto& range : ranges_) splines.push_back(fit_of(range).spline);
    const size_t n_parts = splines.size();
    std::vector<std::array<Vector3d, 2>> ends;
    for (const Spline& spline : splines) ends.push_back({spline.at(0), spline.at(1)});
    for (size_t b = 0; b < n_parts && !is_periodic(); ++b) {
      const bool joins_before = b > 0 || stroke_.closed, joins_after = b + 1 < n_parts || stroke_.closed;
      Vector3d at_start = Vector3d::Zero(), at_end = Vector3d::Zero();
      if (joins_before) at_start = (ends[(b + n_parts - 1) % n_parts][1] - ends[b][0]) / 2;
      if (joins_after) at_end = (ends[(b + 1) % n_parts][0] - ends[b][1]) / 2;
      splines[b].offsets = {{0, 1, at_start}, {1, 1, at_end}};
    }
    Stroke neat = stroke_;
    neat.is_neat = true;
    neat.noise = 0;
    neat.corners.clear();
    std::vector<Vector3d> rows;
    constexpr Index kLeastRows = 24;
    for (size_t b = 0; b < n_parts; ++b) {
      if (!is_periodic() && (b > 0 || stroke_.closed)) neat.corners.push_back(static_cast<int>(rows.size()));
      const Index count =
          std::max(ranges_[b].second - ranges_[b].first, is_periodic() ? 4 * kLeastRows : kLeastRows);
      for (Index k = 0; k < count; ++k)
        rows.push_back(splines[b].at(static_cast<double>(k) / static_cast<double>(count)));
    }
    if (!stroke_.closed) rows.push_back(splines.back().at(1));
    neat.points.resize(static_cast<Index>(rows.size()), 3);
    for (size_t k = 0; k < rows.size(); ++k) neat.points.row(static_cast<Index>(k)) = rows[k].transpose();
    neat.length = neat.arcs().back();
    return neat;
  }

 private:
  using Range = std::pair<Index, Index>;  // rows, from break to break; a closed stroke comes round

  bool is_periodic() const { return stroke_.closed && corners_.empty(); }
  double arc_of(Index row) const {
    if (row < 0) return arcs_[static_cast<size_t>(row + n_)] - stroke_.length;
    return row < n_ ? arcs_[static_cast<size_t>(row)] : arcs_[static_cast<size_t>(row - n_)] + stroke_.length;
  }

  void choose() {
    std::vector<Index> breaks(corners_.begin(), corners_.end());
    if (!stroke_.closed) {
      breaks.insert(breaks.begin(), 0);
      breaks.push_back(n_ - 1);
    } else if (breaks.empty()) {
      breaks = {0, n_};
    } else {
      breaks.push_back(breaks.front() + n_);
    }
    ranges_.clear();
    for (size_t b = 0; b + 1 < breaks.size(); ++b) {
      ranges_.emplace_back(breaks[b], breaks[b + 1]);
      const std::pair key(ranges_.back(), is_periodic());
      if (fits_.count(key) == 0) fits_[key] = fit(ranges_.back());
    }
  }

  const FreeFit& fit_of(const Range& range) const { return fits_.at({range, is_periodic()}); }

  FreeFit fit(const Range& range) const {
    const auto [first, last] = range;
    const bool periodic = is_periodic();
    // What was smoothed is round at corners: the parts go on straight to them instead.
    constexpr Index kRowsOfCorner = 2, kLeastRowsOfPart = 10;
    const Index clear = last - first >= kLeastRowsOfPart ? kRowsOfCorner : 0;
    const bool from_corner = !periodic && (first > 0 || stroke_.closed),
               to_corner = !periodic && (last < n_ - 1 || stroke_.closed);
    const double start = arc_of(first), span = arc_of(last) - start;
    std::vector<Sample> samples;
    for (Index row = first; row <= (periodic ? last - 1 : last); ++row) {
      if ((from_corner && row < first + clear) || (to_corner && row > last - clear)) continue;
      const double before = row > first || periodic ? arc_of(row - 1) : arc_of(row);
      const double after = row < last ? arc_of(row + 1) : arc_of(row);
      samples.push_back(
          {(arc_of(row) - start) / span, (after - before) / (2 * span), stroke_.points.row(row % n_)});
    }
    return likeliest_spline(samples, periodic, stroke_.noise);
  }

  double criterion() const {
    double squares = 0, parameters = 0;
    for (const Range& range : ranges_) {
      const FreeFit& part = fit_of(range);
      squares += part.rest * (arc_of(range.second) - arc_of(range.first));
      parameters += part.parameters;
    }
    parameters += kParametersOfCorner * static_cast<double>(corners_.size());
    const double n_free = free_samples(n_);
    return n_free * std::log(squares / stroke_.length) + parameters * std::log(n_free);
  }

  const Stroke& stroke_;
  std::vector<double> arcs_;
  Index n_;
  std::vector<int> corners_;
  std::vector<Range> ranges_;
  std::map<std::pair<Range, bool>, FreeFit> fits_;  // whether it is periodic
};

}  // namespace

Stroke neat_stroke(const Stroke& stroke) {
  if (!stroke.is_by_hand || !is_noisy(stroke)) return stroke;
  NeatParts parts(stroke);
  parts.drop_doubtful_corners();
  return parts.joined();
}

FittedStroke fit_stroke(const Stroke& drawn, const std::vector<HeldPoint>& places) {
  std::vector<HeldPoint> held = places;
  const Stroke stroke = drawn.is_neat ? through_held(drawn, held) : drawn;
  const std::vector<double> arcs = stroke.arcs();
  const double length = arcs.back();
  // Noise is that of one coordinate of three.
  const double noise = std::sqrt(3.0) * 0.8 * stroke.noise;
  // A trace of bending keeps spans without samples straight, too weak to be seen where there are some. Where
  // there is noise it must be dearer than to swing through it.
  const FitAims aims{std::max(noise, kFitError * length), std::clamp(0.1 * stroke.noise / length, 1e-9, 1e-4),
                     noise > kFitError * length};
  const ArcWalk walk(stroke);
  const double spacing = length / static_cast<double>(stroke.points.rows());
  FittedStroke result;
  result.corner_positions.resize(static_cast<Index>(stroke.corners.size()), 3);

  // Everything that pieces end at, in order along the stroke.
  struct Stop {
    double arc;
    Vector3d position;
    int name;
    bool breaks;  // the spline may turn here
  };
  std::vector<Stop> stops;
  for (size_t k = 0; k < held.size(); ++k)
    stops.push_back({held[k].arc, held[k].position, static_cast<int>(k),
                     !stroke.closed && (k == 0 || k + 1 == held.size())});
  for (size_t k = 0; k < stroke.corners.size(); ++k) {
    const double arc = arcs[static_cast<size_t>(stroke.corners[k])];
    result.corner_positions.row(static_cast<Index>(k)) = stroke.points.row(stroke.corners[k]);
    Stop* near = nullptr;
    for (size_t h = 0; h < held.size(); ++h) {
      double gap = std::abs(stops[h].arc - arc);
      if (stroke.closed) gap = std::min(gap, length - gap);
      if (gap <= 1.25 * kWindow * length) near = &stops[h];
    }
    if (near) {  // one place, not two
      near->breaks = true;
      near->arc = near->arc == 0 || near->arc == length ? near->arc : arc;
    } else {
      stops.push_back({arc, stroke.points.row(stroke.corners[k]), ~static_cast<int>(k), true});
    }
  }
  std::stable_sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.arc < b.arc; });
  if (stops.empty()) return result;

  const auto n_stops = stops.size();
  const auto first_break = static_cast<size_t>(
      std::find_if(stops.begin(), stops.end(), [](const Stop& s) { return s.breaks; }) - stops.begin());
  const bool periodic = first_break == n_stops;
  if (stroke.closed) std::rotate(stops.begin(), stops.begin() + (periodic ? 0 : first_break), stops.end());
  const double origin = stops.front().arc;
  const auto from_origin = [&](double arc) {
    return stroke.closed && arc < origin ? arc + length - origin : arc - origin;
  };
  if (stroke.closed) {  // come round to the beginning
    stops.push_back(stops.front());
    stops.back().arc = origin + length;
  }
  const auto distance_of = [&](const Stop& stop) {
    return &stop == &stops.back() && stroke.closed ? length : from_origin(stop.arc);
  };

  for (size_t begin = 0; begin + 1 < stops.size();) {
    size_t end = begin + 1;
    while (end + 1 < stops.size() && !stops[end].breaks) ++end;
    const double start = distance_of(stops[begin]), span = distance_of(stops[end]) - start;
    std::vector<Sample> samples, holds;
    // Beside a held point that lies off the stroke, a sample would ask for a slope of that offset divided by
    // the distance between the two, and swing the curve as far as the next sample: it is left out.
    std::vector<double> clear;
    for (size_t k = begin; k <= end; ++k) {
      if (periodic && k == end) break;
      holds.push_back({span > 0 ? (distance_of(stops[k]) - start) / span : 0, 1, stops[k].position});
      const double off = (walk.at(std::min(stops[k].arc, length)) - stops[k].position).norm();
      clear.push_back(std::min(kClearOfHolds * off, 1.5 * spacing));
    }
    const auto is_beside_hold = [&](double s) {
      for (size_t h = 0; h < holds.size(); ++h) {
        double gap = std::abs(s - holds[h].t * span);
        if (periodic) gap = std::min(gap, span - gap);
        if (gap < clear[h]) return true;
      }
      return false;
    };
    for (Index i = 0; i < stroke.points.rows(); ++i) {
      const double s = from_origin(arcs[static_cast<size_t>(i)]) - start;
      if (s < 0 || s > span || (!periodic && (s == 0 || s == span)) || is_beside_hold(s)) continue;
      const double before = i > 0 ? arcs[static_cast<size_t>(i) - 1] : arcs[static_cast<size_t>(i)];
      const double after = static_cast<size_t>(i) + 1 < arcs.size() ? arcs[static_cast<size_t>(i) + 1]
                                                                    : arcs[static_cast<size_t>(i)];
      samples.push_back({s / span, (after - before) / (2 * span), stroke.points.row(i)});
    }
    const Spline spline = fitted_spline(samples, holds, periodic, aims);
    for (size_t k = begin; k < end; ++k) {
      const double t0 = (distance_of(stops[k]) - start) / span,
                   t1 = (distance_of(stops[k + 1]) - start) / span;
      FittedStroke::Piece piece;
      piece.points = sampled(spline, t0, t1, samples_needed(spline, t0, t1, length));
      piece.points.row(0) = stops[k].position.transpose();
      piece.points.row(piece.points.rows() - 1) = stops[k + 1].position.transpose();
      piece.points = without_repeats(piece.points, 0);
      piece.from = stops[k].name;
      piece.to = stops[k + 1].name;
      result.pieces.push_back(std::move(piece));
    }
    begin = end;
  }
  return result;
}

SelfContact self_contact(const Stroke& stroke, double distance) {
  SelfContact contact;
  const ArcWalk walk(stroke);
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
