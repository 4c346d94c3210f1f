#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// One curve in which a plane cuts a mesh.
struct SectionCurve {
  Points points;        ///< k × 3, in order; the first one is not repeated where the curve is closed
  bool closed = false;  ///< open curves end at borders of the mesh
  double length = 0;
  double area = 0;  ///< of a closed curve, seen against the normal: negative where it runs around a hole
};

/// The curves in which the plane n · x = offset cuts a mesh, the longest first; none where it misses. With
/// the faces counter-clockwise seen from outside, curves run counter-clockwise around the inside, seen
/// against the normal. Vertices in the plane count as above it. Where faces do not agree, or an edge has
/// three of them, curves come in pieces.
/// @param normal not zero; its length divides out with that of `offset`.
/// @throws InvalidInput on a normal without direction or an offset that is not finite; as mesh_edges().
std::vector<SectionCurve> plane_section(const Points& positions, const Triangles& triangles,
                                        const Eigen::Vector3d& normal, double offset);

}  // namespace batten
