#pragma once
#include <optional>

#include "batten/core/arrays.hpp"

namespace batten::detail {

/// Where a stroke comes round to its beginning: row `last` is followed by row `first`.
struct Closing {
  Eigen::Index first = 0, last = 0;
};

/// The nearest approach of the end of a stroke to its beginning, where the stroke is a loop by its looks: it
/// comes back to within a quarter of its size, heading on the way it began, and what it runs past the place
/// keeps beside the loop. Nothing where it is not; a hairpin, an S or the letter omega is none.
/// O(n²/39) distances.
std::optional<Closing> find_closing(const Points& points);
/// The same of a stroke that is known to be a loop: always a place, at worst from end to beginning.
Closing closing_of_loop(const Points& points);

/// The loop from row `first` to row `last`: an offset to the side is spread over both ends, over a length on
/// which it bends the loop by no more than half of the loop's own mean curvature, and a gap along the way is
/// bridged by a cubic that continues both ends.
struct ClosedLoop {
  Points points;  ///< the last row may repeat the first
  /// Something was cut off, moved or bridged. Where nothing was, the points are those given, bit for bit.
  bool joined = false;
};
ClosedLoop closed_loop(const Points& points, const Closing& closing);

}  // namespace batten::detail
