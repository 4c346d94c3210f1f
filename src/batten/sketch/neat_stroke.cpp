#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "batten/sketch/stroke.hpp"
#include "batten/sketch/stroke_spline_detail.hpp"
#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten {

namespace {

using detail::StrokeSample;
using detail::StrokeSpline;
using Eigen::Index;
using Eigen::Vector3d;

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
  StrokeSpline spline;
  double rest = 0;  ///< mean square distance from the samples
  double parameters = 0;
};

/// A span without a sample, or an end of one of half its length, goes where it likes.
bool leaves_spans_empty(const std::vector<StrokeSample>& samples, int spans) {
  double last = 0;
  for (const StrokeSample& sample : samples) {
    if ((sample.t - last) * spans > (last == 0 ? 0.5 : 1)) return true;
    last = sample.t;
  }
  return (1 - last) * spans > 0.5;
}

/// The one that the criterion prefers. @param noise the least root mean square distance that is believed.
FreeFit likeliest_spline(const std::vector<StrokeSample>& samples, bool periodic, double noise) {
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
    StrokeSpline spline =
        least_squares_spline(samples, {}, spans, periodic, samples.size() < kFewSamples ? 1e-2 : 1e-9);
    double squares = 0, weights = 0;
    for (const StrokeSample& sample : samples) {
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
    std::vector<StrokeSpline> splines;
    for (const auto& range : ranges_) splines.push_back(fit_of(range).spline);
    const size_t n_parts = splines.size();
    std::vector<std::array<Vector3d, 2>> ends;
    for (const StrokeSpline& spline : splines) ends.push_back({spline.at(0), spline.at(1)});
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
    std::vector<StrokeSample> samples;
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
  if (!stroke.is_by_hand || detail::noise_distance(stroke) <= detail::kStrokeFitError * stroke.length)
    return stroke;
  NeatParts parts(stroke);
  parts.drop_doubtful_corners();
  return parts.joined();
}

}  // namespace batten
