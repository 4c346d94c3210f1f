#pragma once
#include <optional>

#include "batten/network/curve_network.hpp"

namespace batten {

/// A plane across an axis of the file.
struct MirrorPlane {
  int axis = 0;         ///< 0, 1 or 2: x, y or z
  double position = 0;  ///< of the plane on that axis, in the unit of the strokes
};

/// The strokes and what they are in the mirror; strokes that lie in the plane (within 1 % of the diameter) or
/// on their own image are not doubled. Completes half a sketch, and makes a whole one even.
CurveNetwork with_mirrored_strokes(const CurveNetwork& strokes, const MirrorPlane& plane);

/// The plane in the middle of the strokes in which they are their own image: 90 % of their length lies within
/// 2 % of the diameter of the image. The best of the three axes; nothing where none is. O(n log n).
/// @throws InvalidInput for strokes without extent.
std::optional<MirrorPlane> find_mirror_plane(const CurveNetwork& strokes);

}  // namespace batten
