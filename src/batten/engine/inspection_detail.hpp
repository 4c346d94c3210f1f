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

/// Adds the curvature along curves as combs: the arrays roots (less the origin), directions (unit) and
/// curvature, and `combs` with name, first and n in these. Where the network has no normals, directions lead
/// away from the centre of curvature.
void add_combs(Draft& draft, const CurveNetwork& network, const Eigen::RowVector3d& origin);

/// Adds the principal directions of triangles spread over the mesh, of `most` at most: the arrays places
/// (less the origin), first and second (unit), curvatures (κ1 and κ2, |κ1| ≥ |κ2|).
void add_directions(Draft& draft, const TriangleMesh& mesh, Eigen::Index most,
                    const Eigen::RowVector3d& origin);

/// Adds what a plane cuts out of a mesh: the array positions (less the origin) and `curves` with first, n,
/// closed, length and area; `length` and `area` of all. @return the curves as a network.
CurveNetwork add_section(Draft& draft, const TriangleMesh& mesh, const Eigen::Vector3d& normal, double offset,
                         const Eigen::RowVector3d& origin);

}  // namespace batten::detail
