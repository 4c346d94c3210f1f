#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/error.hpp"

namespace batten {

/// An edit that cannot be done. The model is as it was; what() is "reason; remedy".
class RefusedEdit : public InvalidInput {
 public:
  /// @param reason names the curve and the distance. @param remedy what to do instead.
  RefusedEdit(const std::string& reason, const std::string& remedy);
  const std::string& reason() const { return reason_; }  ///< names the curve and the distance
  const std::string& remedy() const { return remedy_; }  ///< what to do instead

 private:
  std::string reason_, remedy_;
};

/// A stroke made ready: repeats dropped, thinned, smoothed, corners found.
struct Stroke {
  /// n × 3, n at least 2, in the unit of the model. A closed stroke does not repeat its first point.
  Points points;
  bool closed = false;
  std::vector<int>
      corners;       ///< rows where the direction jumps, increasing; ends of open strokes not among them
  double noise = 0;  ///< standard deviation of the hand or device per coordinate, estimated
  double length = 0;
  bool is_by_hand = false;  ///< its noise is random, not the error of few samples
  /// Free of noise, as by neat_stroke(): held points off it move it smoothly instead of pulling at it.
  bool is_neat = false;

  /// Arc length at each point and, last, the whole length (n + 1 values when closed, n when open).
  std::vector<double> arcs() const;
};

/// How a stroke is made ready.
struct StrokeOptions {
  /// The stroke is closed. Off: it is closed where its ends lie within `snap` of each other and it runs
  /// further than six times that, and where `recognise_loops` says so.
  bool closed = false;
  /// A stroke that comes round is closed as hands close it: what it runs past its beginning is cut off at the
  /// nearest approach, a gap of up to a quarter of its size is bridged, and an offset to the side is spread
  /// over both ends.
  bool recognise_loops = false;
  /// Snapping distance, in the unit of the model, at least 0.
  double snap = 0;
  /// Turns sharper than this within 2 % of the length (up to 6 % where there is noise) are corners, in
  /// radians, above 0; those of open strokes within `snap` of an end, where pens slip, are not. A circle
  /// given by seven or more points has none.
  double corner_angle = 0.92;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Reads a stroke as a pen or a mouse gives it: any number of points (thinned to 1,000), unevenly spaced,
/// noisy. The noise is estimated from third differences, and only where there is some the stroke is smoothed
/// by a Gaussian of so many samples as it takes; exact strokes are left as they are.
/// @throws InvalidInput where options.problem() names one; RefusedEdit when a point is not finite, there is
/// but one place, or a closed stroke has fewer than three.
Stroke prepare_stroke(const Points& points, const StrokeOptions& options);

/// The same stroke without its tremor: cubic splines from corner to corner, with as many spans as the
/// Bayesian information criterion grants; corners that it does without are gone. Samples of hands are not
/// independent: tremor lasts for some hundredths of a stroke, so that it counts as 20 samples at most.
/// Strokes that are not by hand are left as they are, bit for bit.
Stroke neat_stroke(const Stroke& stroke);

/// A place of a stroke that must lie at a given point.
struct HeldPoint {
  double arc = 0;  ///< arc length along the stroke, 0 … length
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// The finished curve of a stroke, in pieces from held point to held point (and corner to corner).
struct FittedStroke {
  /// A part between two held points or corners.
  struct Piece {
    Points points;  ///< 17 or more, first and last included
    /// Index into the held points of the ends, or ~k for corner k of the stroke.
    int from = 0, to = 0;
  };
  /// In order. An open stroke begins and ends at held points; a closed one comes round to its beginning.
  std::vector<Piece> pieces;
  /// Places of the corners after fitting, one per corner of the stroke; corners beside a held point have
  /// become that point and are not used.
  Points corner_positions;
};

/// Weighted constrained least-squares cubic B-splines from corner to corner (H 5.2.1): weights are the share
/// of the length that a sample stands for, the held points are kept exactly, and the number of spans doubles
/// until the rest is no more than the noise. Sampled finely enough that chords stay within 1e-5 of the
/// length. A neat stroke is moved onto its held points first, by as much as each lies off it and by a smooth
/// share of that between one and the next.
/// @param places increasing in arc. Open strokes: the first at 0 and the last at the length. Closed strokes
/// without corners: at least one.
FittedStroke fit_stroke(const Stroke& drawn, const std::vector<HeldPoint>& places);

/// Where a stroke meets itself: the first pair of places within `distance` whose way along the stroke is more
/// than eight times that.
struct SelfContact {
  bool found = false;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double distance = 0;
};
/// Looks between 512 places of the stroke.
SelfContact self_contact(const Stroke& stroke, double distance);

}  // namespace batten
