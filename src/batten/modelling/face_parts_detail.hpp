#pragma once
#include <vector>

#include "batten/core/arrays.hpp"

// Into how many parts the edges of a model are divided before its faces are split into quads. Private to the
// room.
namespace batten::detail {

/// Where the four corners of a face are (numbers of sides, ascending), when sides that go on smoothly count
/// as one; empty for other faces. @param sides the points of each side of a face in order, two or more.
std::vector<size_t> corners_of_quadrilateral(const std::vector<Points>& sides);

/// Numbers of the sides between corner c of a quadrilateral and the next.
std::vector<size_t> sides_between(const std::vector<size_t>& corners, size_t n_sides, size_t c);

double polyline_length(const Points& points);

/// What decides about the parts of a face's sides.
struct FaceSides {
  std::vector<int> edges;       ///< of the model, per side
  std::vector<double> lengths;  ///< per side
  std::vector<size_t> corners;  ///< corners_of_quadrilateral()
  std::vector<int> parts;       ///< per side: as many at least
};

/// Parts per edge of the model, mostly 1: as many as its faces ask for. The sides of long quadrilaterals get
/// so many that their quads are not much longer than wide, and opposite sides the same number, so that they
/// are split into rows and columns; with them those of the long quadrilaterals beside them, and so on. Where
/// that has no end, sides stay different. Linear time. @param faces nullptr where there is none.
std::vector<int> parts_of_edges(size_t n_edges, const std::vector<const FaceSides*>& faces);

}  // namespace batten::detail
