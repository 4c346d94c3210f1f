#pragma once
#include <string>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten::experiments {

/// Every triangle cut into four by the midpoints of its sides: how H makes the finer meshes of its
/// simplification.
TriangleMesh midpoint_subdivided(const TriangleMesh& mesh);

/// The diameter of a mesh in the unit of the thesis, from the volumes of both (H, table 2.1); 0 where it
/// prints none.
double printed_diameter(const std::string& name, const TriangleMesh& mesh);

/// |Var(A) - Var(A0)| / Var(A0) by H (2.49) as printed, the sum of (A - mean)^2 over the vertices.
double printed_area_variance(const TriangleMesh& original, const TriangleMesh& result);

}  // namespace batten::experiments
