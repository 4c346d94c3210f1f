#pragma once
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/isolated_limit_detail.hpp"

// The steps from a limit surface to B-splines that share their edges. Private to the room.
namespace batten::detail {

/// The curves over the edges of the cage. Next to an extraordinary end the control point is fitted, in the
/// tangent plane where there is one.
/// @param surface has its vertices; gains its edges.
void build_edges(const IsolatedLimit& limit, BsplineSurface& surface);

/// The patch over one face: exact but for the control points at extraordinary corners, of which one is fitted
/// and the others are those of the edges.
/// @param surface has its vertices, edges and room for the patch.
/// @throws Error when the limit surface is irregular at a place that is no corner.
void build_patch(const IsolatedLimit& limit, BsplineSurface& surface, int face);

/// Raises surface.deviation to the largest distance of the limit surface from the patch over a face that is
/// found at its extraordinary corners.
void measure_deviation(const IsolatedLimit& limit, BsplineSurface& surface, int face);

/// Raises surface.normal_jump to the largest angle between normals on both sides of an edge that is not
/// sharp, found in the cells at its ends.
void measure_normals(const IsolatedLimit& limit, BsplineSurface& surface);

}  // namespace batten::detail
