#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/sketch/stroke.hpp"
#include "batten/sketch/stroke_spline_detail.hpp"
#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten {

namespace {

using detail::kStrokeFitError;
using detail::StrokeSample;
using detail::StrokeSpline;
using detail::StrokeWalk;
using Eigen::Index;
using Eigen::Vector3d;

constexpr double kClearOfHolds = 10;  // times how far a held point lies off the stroke

/// Offsets at places of a stroke, and between them a share of each without overshoot.
Points offsets_along(const Stroke& stroke, const std::vector<StrokeSample>& offsets) {
  StrokeSpline field;
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
  const StrokeWalk walk(stroke);
  const double length = walk.length();
  std::vector<StrokeSample> offsets;
  for (const HeldPoint& hold : held)
    offsets.push_back({hold.arc / length, 1, hold.position - walk.at(hold.arc)});
  const auto is_off = [&](const StrokeSample& offset) {
    return offset.point.norm() > kStrokeFitError * length;
  };
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

/// What pieces of a curve end at.
struct Stop {
  double arc;
  Vector3d position;
  int name;     ///< as FittedStroke::Piece::from
  bool breaks;  ///< the spline may turn here
};

/// Held points and corners in order along a stroke; a corner beside a held point is that point.
std::vector<Stop> stops_along(const Stroke& stroke, const std::vector<double>& arcs,
                              const std::vector<HeldPoint>& held) {
  const double length = arcs.back();
  std::vector<Stop> stops;
  for (size_t k = 0; k < held.size(); ++k)
    stops.push_back({held[k].arc, held[k].position, static_cast<int>(k),
                     !stroke.closed && (k == 0 || k + 1 == held.size())});
  for (size_t k = 0; k < stroke.corners.size(); ++k) {
    const double arc = arcs[static_cast<size_t>(stroke.corners[k])];
    Stop* near = nullptr;
    for (size_t h = 0; h < held.size(); ++h) {
      double gap = std::abs(stops[h].arc - arc);
      if (stroke.closed) gap = std::min(gap, length - gap);
      if (gap <= 1.25 * detail::kCornerWindow * length) near = &stops[h];
    }
    if (near) {  // one place, not two
      near->breaks = true;
      near->arc = near->arc == 0 || near->arc == length ? near->arc : arc;
    } else {
      stops.push_back({arc, stroke.points.row(stroke.corners[k]), ~static_cast<int>(k), true});
    }
  }
  std::stable_sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.arc < b.arc; });
  return stops;
}

/// Fits splines to a stroke from break to break among its stops.
class StopFitter {
 public:
  /// @param stops in order along the stroke, at least one. @param stroke, arcs must outlive this.
  StopFitter(const Stroke& stroke, const std::vector<double>& arcs, std::vector<Stop> stops)
      : stroke_(stroke), arcs_(arcs), length_(arcs.back()), walk_(stroke), stops_(std::move(stops)) {
    const auto first_break =
        std::find_if(stops_.begin(), stops_.end(), [](const Stop& stop) { return stop.breaks; });
    periodic_ = first_break == stops_.end();
    if (stroke.closed) std::rotate(stops_.begin(), periodic_ ? stops_.begin() : first_break, stops_.end());
    origin_ = stops_.front().arc;
    if (stroke.closed) {  // come round to the beginning
      stops_.push_back(stops_.front());
      stops_.back().arc = origin_ + length_;
    }
  }

  std::vector<FittedStroke::Piece> pieces(const detail::FitAims& aims) const {
    std::vector<FittedStroke::Piece> pieces;
    for (size_t begin = 0; begin + 1 < stops_.size();) {
      size_t end = begin + 1;
      while (end + 1 < stops_.size() && !stops_[end].breaks) ++end;
      const Holds holds = holds_between(begin, end);
      const StrokeSpline spline =
          detail::fitted_spline(samples_between(begin, end, holds), holds.places, periodic_, aims);
      const double start = distance_of(begin), span = distance_of(end) - start;
      for (size_t k = begin; k < end; ++k)
        pieces.push_back(
            piece_of(spline, k, (distance_of(k) - start) / span, (distance_of(k + 1) - start) / span));
      begin = end;
    }
    return pieces;
  }

 private:
  /// Beside a held point that lies off the stroke, a sample would ask for a slope of that offset divided by
  /// the distance between the two, and swing the curve as far as the next sample: it is left out.
  struct Holds {
    std::vector<StrokeSample> places;
    std::vector<double> clear;  ///< how far from each there are no samples
  };

  double from_origin(double arc) const {
    return stroke_.closed && arc < origin_ ? arc + length_ - origin_ : arc - origin_;
  }
  double distance_of(size_t k) const {
    return k + 1 == stops_.size() && stroke_.closed ? length_ : from_origin(stops_[k].arc);
  }

  Holds holds_between(size_t begin, size_t end) const {
    const double spacing = length_ / static_cast<double>(stroke_.points.rows());
    const double start = distance_of(begin), span = distance_of(end) - start;
    Holds holds;
    for (size_t k = begin; k <= end; ++k) {
      if (periodic_ && k == end) break;
      holds.places.push_back({span > 0 ? (distance_of(k) - start) / span : 0, 1, stops_[k].position});
      const double off = (walk_.at(std::min(stops_[k].arc, length_)) - stops_[k].position).norm();
      holds.clear.push_back(std::min(kClearOfHolds * off, 1.5 * spacing));
    }
    return holds;
  }

  std::vector<StrokeSample> samples_between(size_t begin, size_t end, const Holds& holds) const {
    const double start = distance_of(begin), span = distance_of(end) - start;
    const auto is_beside_hold = [&](double s) {
      for (size_t h = 0; h < holds.places.size(); ++h) {
        double gap = std::abs(s - holds.places[h].t * span);
        if (periodic_) gap = std::min(gap, span - gap);
        if (gap < holds.clear[h]) return true;
      }
      return false;
    };
    std::vector<StrokeSample> samples;
    for (Index i = 0; i < stroke_.points.rows(); ++i) {
      const double s = from_origin(arcs_[static_cast<size_t>(i)]) - start;
      if (s < 0 || s > span || (!periodic_ && (s == 0 || s == span)) || is_beside_hold(s)) continue;
      const double before = i > 0 ? arcs_[static_cast<size_t>(i) - 1] : arcs_[static_cast<size_t>(i)];
      const double after = static_cast<size_t>(i) + 1 < arcs_.size() ? arcs_[static_cast<size_t>(i) + 1]
                                                                     : arcs_[static_cast<size_t>(i)];
      samples.push_back({s / span, (after - before) / (2 * span), stroke_.points.row(i)});
    }
    return samples;
  }

  FittedStroke::Piece piece_of(const StrokeSpline& spline, size_t k, double t0, double t1) const {
    FittedStroke::Piece piece;
    piece.points = detail::sampled(spline, t0, t1, detail::samples_needed(spline, t0, t1, length_));
    piece.points.row(0) = stops_[k].position.transpose();
    piece.points.row(piece.points.rows() - 1) = stops_[k + 1].position.transpose();
    piece.points = detail::without_repeats(piece.points, 0);
    piece.from = stops_[k].name;
    piece.to = stops_[k + 1].name;
    return piece;
  }

  const Stroke& stroke_;
  const std::vector<double>& arcs_;
  double length_;
  StrokeWalk walk_;
  std::vector<Stop> stops_;
  bool periodic_ = false;
  double origin_ = 0;
};

}  // namespace

FittedStroke fit_stroke(const Stroke& drawn, const std::vector<HeldPoint>& places) {
  std::vector<HeldPoint> held = places;
  const Stroke stroke = drawn.is_neat ? through_held(drawn, held) : drawn;
  const std::vector<double> arcs = stroke.arcs();
  const double length = arcs.back(), noise = detail::noise_distance(stroke);
  // A trace of bending keeps spans without samples straight, too weak to be seen where there are some. Where
  // there is noise it must be dearer than to swing through it.
  const detail::FitAims aims{std::max(noise, kStrokeFitError * length),
                             std::clamp(0.1 * stroke.noise / length, 1e-9, 1e-4),
                             noise > kStrokeFitError * length};
  FittedStroke result;
  result.corner_positions.resize(static_cast<Index>(stroke.corners.size()), 3);
  for (size_t k = 0; k < stroke.corners.size(); ++k)
    result.corner_positions.row(static_cast<Index>(k)) = stroke.points.row(stroke.corners[k]);
  std::vector<Stop> stops = stops_along(stroke, arcs, held);
  if (!stops.empty()) result.pieces = StopFitter(stroke, arcs, std::move(stops)).pieces(aims);
  return result;
}

}  // namespace batten
