#pragma once
#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// How values per vertex are taken from one mesh to another on the same surface.
enum class ValueKind {
  Amount,   ///< interpolated in the triangle that holds the nearest point
  Channel,  ///< `red`, `green`, `blue`, `alpha` of whole numbers from 0 to 255: interpolated and rounded
  Label,    ///< other whole numbers, such as parts, materials and indices: that of the nearest corner
};

/// What the values of a name are taken for, by name and numbers alone.
ValueKind value_kind(const std::string& name, const Eigen::VectorXd& values);

/// Gives `to` the values per vertex of `from`, at the points of `from` nearest to its vertices, and, where
/// `from` has normals, normals of its own. Nothing else of `to` changes; values it has already stay.
/// Nearest means nearest in space: where sheets lie closer together than the meshes differ, values may come
/// from the other one. Time O((m + n) log m) of m triangles of `from`, none without values.
/// @pre both meshes have triangles.
void carry_values(const TriangleMesh& from, TriangleMesh& to, const Progress& progress = {});

}  // namespace batten
