#pragma once
#include "subdivision/cages.hpp"

#include <algorithm>

#include <Eigen/Core>

#include "batten/core/random.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/subdivide.hpp"

// What the tests of limit surfaces as B-splines and of their files share.
namespace batten::cages {

inline ControlCage random_torus() {
  ControlCage cage = torus(6, 5);
  Random random(3);
  for (Eigen::Index v = 0; v < 30; ++v)
    for (int k = 0; k < 3; ++k) cage.mesh.positions(v, k) += 0.1 * random.normal();
  return cage;
}

/// Two cubes glued along a face and open on one side, with a dart, a crease and a sharp corner.
inline ControlCage creased_box() {
  ControlCage cage = cube();
  cage.mesh.positions.conservativeResize(12, 3);
  cage.mesh.positions.bottomRows(4) << -1, -1, 2.5, 1, -1, 2.5, 1.3, 1, 2.5, -1, 1, 2.2;
  cage.mesh.corners.erase(cage.mesh.corners.begin() + 4, cage.mesh.corners.begin() + 8);  // the top
  cage.mesh.offsets.pop_back();
  add_face(cage.mesh, {4, 5, 9, 8});
  add_face(cage.mesh, {5, 6, 10, 9});
  add_face(cage.mesh, {6, 7, 11, 10});
  add_face(cage.mesh, {7, 4, 8, 11});
  cage.sharp_edges = {
      {0, 1, kInfinitelySharp}, {1, 2, kInfinitelySharp}, {2, 6, kInfinitelySharp}, {4, 8, kInfinitelySharp}};
  cage.sharp_vertices = {{3, kInfinitelySharp}};
  return cage;
}

/// The largest distance of patch points at multiples of 1/4 from the limit points of the mesh that has
/// exactly these places as vertices, over the diameter. They come from OpenSubdiv's limit masks, not from its
/// patches.
inline double quarter_point_error(const ControlCage& cage, const BsplineSurface& surface) {
  const SubdividedSurface fine = subdivide(cage, {.levels = surface.levels + 2, .limit = true});
  double worst = 0;
  for (const BsplinePatch& patch : surface.patches)
    for (int j = 0; j <= 4; ++j)
      for (int i = 0; i <= 4; ++i) {
        const Eigen::RowVector3d p = evaluate(patch, 0.25 * i, 0.25 * j).position.transpose();
        worst = std::max(worst, (fine.limit_positions.rowwise() - p).rowwise().norm().minCoeff());
      }
  return worst / bounding_box_diagonal(cage.mesh.positions);
}

}  // namespace batten::cages
