#include "batten/sketch/stroke.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

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

/// Standard deviation per coordinate of the noise: how far samples lie from the cubic through two neighbours
/// on either side, with chord lengths as parameters, so that exact smooth strokes have none to fourth order.
double estimate_noise(const Points& points) {
  const Index n = points.rows();
  if (n < 8) return 0;
  std::vector<double> residuals;
  const Index step = std::max<Index>(1, n / 4000);
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
    residuals.push_back((points.row(i).transpose() - guess).norm() / std::sqrt(squares));
  }
  return upper_median(residuals) / 1.538;  // the median of the length of a standard normal 3-vector
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
  stroke.noise = estimate_noise(stroke.points);
  stroke.points = without_repeats(thinned(stroke.points, stroke.noise > 1e-5 * extent), 1e-12 * extent);
  stroke.noise = estimate_noise(stroke.points);

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

FittedStroke fit_stroke(const Stroke& stroke, const std::vector<HeldPoint>& held) {
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
