#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// A border loop of a mesh: a hole, or the outline of an open surface. A border that passes a place twice is
/// a loop for each of its parts.
struct MeshHole {
  std::vector<int> rim;  ///< its vertices, the surface to the left; none is repeated at the end
  bool filled = false;
  bool fair = false;  ///< filled by a surface that meets its surroundings tangentially; else by a membrane
};

/// A mesh with its holes filled. What was given comes first, bit for bit, but for normals and for vertices at
/// one place of a rim, which become one.
struct FilledMesh {
  TriangleMesh mesh;
  std::vector<MeshHole> holes;  ///< all, in the order of boundary_loops()
  /// How many of the holes were filled.
  int n_filled() const;
};

constexpr int kAllHoles = 2147483647;

/// Options of filled_mesh().
struct HoleFillingOptions {
  int most_edges = kAllHoles;  ///< holes with more edges stay, at least 3; kAllHoles fills outlines too
  /// Per vertex, or empty: holes whose rim passes such a vertex stay.
  std::vector<char> left_open;

  /// The first problem found for a mesh of so many vertices, naming field and value, or nothing.
  std::optional<std::string> problem(Eigen::Index n_vertices) const;
};

/// Fills holes. Each rim is a closed curve of a network whose normals are those of quadrics fitted to the
/// surface around it, and is filled as `batten surface` fills a patch (surface_network(), by curvature): the
/// patch meets its surroundings tangentially, and a hole in a sphere becomes the sphere again. Where that
/// patch would fold or cross its surroundings, the membrane over the rim takes its place; where that crosses
/// too, the hole stays. New edges are about as long as those of the rim.
/// Values of new vertices are means over the rim, weighted by the inverse squared distance; normals, where
/// there were any, are made anew at the vertices of filled holes.
/// @pre the mesh is manifold and oriented. @throws InvalidInput where it is not; Cancelled.
FilledMesh filled_mesh(const TriangleMesh& mesh, const HoleFillingOptions& options = {},
                       const Progress& progress = {});

}  // namespace batten
