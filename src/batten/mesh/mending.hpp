#pragma once
#include <optional>
#include <string>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// Options of mended_mesh().
struct MendingOptions {
  /// Weld borders that lie on each other. Off: vertices stay apart, and so do the sheets between them.
  bool weld = true;
  /// Distance up to which they are welded, in the unit of the mesh, at least 0; nothing: as the mesh
  /// suggests, see weld_borders().
  std::optional<double> tolerance;
  /// Turn every closed part so that the parts together bound a volume: outward, and inward where a part lies
  /// within another (a cavity). Off: parts whose triangles agree are left as they are, but for those that
  /// lie in no other and are inside out.
  bool orient = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What was wrong with a mesh, by kind.
struct MendingReport {
  double tolerance = 0;             ///< at which vertices were welded
  Eigen::Index welded = 0;          ///< vertices that were welded onto another one
  Eigen::Index repeated = 0;        ///< triangles left out that name a vertex twice
  Eigen::Index degenerate = 0;      ///< triangles left out that have no area
  Eigen::Index doubled = 0;         ///< triangles left out that lie on an equal one
  Eigen::Index junctions = 0;       ///< vertices in the middle of an edge that became corners of its triangle
  Eigen::Index branching = 0;       ///< edges of three or more triangles, where sheets were separated
  Eigen::Index split_vertices = 0;  ///< vertices added so that every fan of triangles has its own
  Eigen::Index cut = 0;             ///< edges at which a one-sided part was opened
  Eigen::Index turned = 0;          ///< triangles that were turned over
  Eigen::Index unused = 0;          ///< vertices left out that no triangle used
  int nested = 0;                   ///< closed parts within others that were left oriented outward

  /// Whether anything was mended.
  bool changed() const {
    return welded + repeated + degenerate + doubled + junctions + branching + split_vertices + cut + turned +
               unused >
           0;
  }
};

/// A mesh without the faults that no method can work with.
struct MendedMesh {
  /// Manifold, oriented, without triangles that have no area (degenerate_triangles()) and without unused
  /// vertices. Vertices keep their order, further ones come last; normals and values go with them, those of
  /// an added vertex being those of the vertex, or the means of the edge, that it comes from.
  TriangleMesh mesh;
  MendingReport report;
};

/// Mends the connectivity of a mesh; no vertex moves but by welding. A mesh without fault is returned as it
/// is. In turn, until nothing changes:
///  1. triangles without area are left out, equal ones but for one; two equal ones that look away from each
///     other are left out both where that leaves no opening (a wall between two bodies);
///  2. borders are welded (weld_borders());
///  3. vertices that lie in an edge of a border, with a border along that edge, become corners of its
///     triangle;
/// then
///  4. at an edge of more than two triangles they are joined in pairs, bodies that meet there kept apart,
///     else those that go on straightest; what is left over ends there ([gueziec2001], cutting);
///  5. the triangles of every part are turned to agree with the larger area of them; one-sided parts
///     are cut open where that cannot be; closed parts see MendingOptions::orient, and open ones whose
///     triangles disagreed look away from their middle where they lie around it;
///  6. every fan of triangles gets a vertex of its own.
/// O(n log n), and for step 5 the number of parts around each other times their triangles.
/// @throws InvalidInput on bad options, an index out of range and a number that is not finite, with the
/// place; Cancelled.
MendedMesh mended_mesh(const TriangleMesh& mesh, const MendingOptions& options = {},
                       const Progress& progress = {});

}  // namespace batten
