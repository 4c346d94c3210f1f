#pragma once
#include "batten/core/progress.hpp"
#include "batten/subdivision/bspline_surface.hpp"

namespace batten {

/// The same surface of fewer patches: those of a rectangular block become one, with a knot where two of them
/// met. Blocks end at sharp edges, borders, and the lines that run straight on from vertices where not four
/// smooth patches meet; their polynomials are those of the patches, so that points and normals stay what they
/// were, up to rounding. Parameters of a patch of m × n are those of its parts, scaled by 1/m and 1/n. `face`
/// is that of the part at (0, 0), `deviation` and the other figures are taken over. Time is linear in the
/// patches.
/// @pre The surface is one of limit_bsplines(): patches meet side to side.
BsplineSurface joined_bsplines(const BsplineSurface& surface, const Progress& progress = {});

}  // namespace batten
