#pragma once
#include <string>

#include "batten/core/progress.hpp"
#include "batten/engine/reply_detail.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"

// Private to the room: what is measured on surfaces to be looked at.
namespace batten::detail {

/// Adds the array `values`, one per vertex as draw_mesh() draws them, and low, high and title of their colour
/// bar: those of `batten render` with the same shading. @throws InvalidInput where the mesh has not what the
/// shading needs, or the word stands for a shading that is no value per vertex.
void add_values(Draft& draft, const TriangleMesh& mesh, const std::string& shading);

/// Adds `curves`: for each, in order, what curve_continuity() says of it, whether it passes at the tolerance,
/// and the worst place less the origin. Borders and sharp curves are measured and do not fail.
/// @param tolerance of the jump of the normal, in radians.
void add_continuity(Draft& draft, const TriangleMesh& mesh, const CurveNetwork& network, double tolerance,
                    const Eigen::RowVector3d& origin, const Progress& progress);

/// Adds `values`: the distance of every vertex, as drawn, from another shape, with low, high, title, and the
/// figures mean, rms and max, lengths in the unit of the mesh. The shape stays where it is.
void add_distances(Draft& draft, const TriangleMesh& mesh, const TriangleMesh& truth,
                   const Progress& progress);

}  // namespace batten::detail
