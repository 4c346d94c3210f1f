#pragma once
#include <optional>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/modelling/coons.hpp"

namespace batten {

/// How the best division of a face is searched for.
enum class SplitSearch {
  /// The best of all divisions, by dynamic programming over the parts that diagonals cut off (as in
  /// minimum-weight triangulation [klincsek1980]). Time O(n⁴); faces of more than 40 sides are first cut
  /// down by the other search.
  Optimal,
  /// H 6.1.1: cut off the best quad of four corners in a row, again and again. Not always the best, and it
  /// finds no division without flaws where the first cuts spoil it.
  Greedy,
};
constexpr auto choices_of(SplitSearch) {
  return choices<SplitSearch>("search", {{SplitSearch::Optimal, "optimal"}, {SplitSearch::Greedy, "greedy"}});
}

/// What a division is worth; less is better, flaws first.
struct SplitCost {
  /// Three for each diagonal that leaves the face, two for each part that is turned over or without area, one
  /// for each corner of a part that is reflex. 0 for a good division.
  int flaws = 0;
  /// Sum over the parts of the angle between their vector area and that of the face, radians (H 6.1.1).
  double planarity = 0;
  /// Sum over the parts of the mean distance of their angles from those of a regular one, radians.
  double shape = 0;

  /// What is compared after the flaws: H takes the planarity alone, which says nothing about plane faces.
  double angle() const { return planarity + 0.25 * shape; }
  SplitCost operator+(const SplitCost& other) const {
    return {flaws + other.flaws, planarity + other.planarity, shape + other.shape};
  }
};

/// A face divided into triangles and quads.
struct FaceSplit {
  /// Corners of each part, three or four of 0 … n − 1, counter-clockwise as the face.
  std::vector<std::vector<int>> parts;
  SplitCost cost;
};

/// Divides a face with any number of sides, flat or not, convex or not, into triangles and quads along
/// diagonals (H 6.1.1). Quads stay whole unless they have a reflex corner and two triangles have none.
/// @param sides three or more, one after the other around the face, counter-clockwise; corner k is where
/// side k begins.
/// @throws InvalidInput on fewer than three sides.
FaceSplit split_face(const std::vector<SharedPolyline>& sides, SplitSearch search = SplitSearch::Optimal);

/// What a division of a face costs. @param parts as in FaceSplit, with each diagonal in two of them.
SplitCost cost_of_split(const std::vector<SharedPolyline>& sides, const std::vector<std::vector<int>>& parts);

/// A diagonal of a divided face and its curve.
struct Diagonal {
  int from = 0, to = 0;  ///< corners, from < to
  SharedPolyline polyline;
};

/// The diagonals of a division.
struct FaceDiagonals {
  std::vector<Diagonal> diagonals;  ///< each once, in the order in which the parts name them
  /// The patch over which they run, where they do.
  std::optional<FacePatch> patch;
};

/// The curves of the diagonals of a division: lines of the Coons patch of the associated quad (H 6.1.2).
/// Where one of them would run along the border or leave the face, or the face has a reflex corner, all run
/// straight in the plane of the face, at the heights that a quadric fitted to the border and the mean value
/// interpolation [floater2003] of what it leaves there give; on faces that lie over no plane, straight in
/// space those that would run along the border.
FaceDiagonals diagonals_of_split(const std::vector<SharedPolyline>& sides, const FaceSplit& split);

}  // namespace batten
