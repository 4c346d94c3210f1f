#pragma once
#include <memory>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

// What the one source that uses OpenSubdiv offers. Private to the room.
namespace batten::detail {

/// Catmull–Clark refinement of one cage, kept for further positions of its vertices.
class CatmullClark {
 public:
  CatmullClark(const ControlCage& cage, const CageTopology& topology, const SubdivisionOptions& options,
               const Progress& progress);
  ~CatmullClark();

  /// Faces, parents and edge chains.
  void copy_topology(const CageTopology& topology, SubdividedSurface& surface) const;
  /// Positions, and the limit where the options ask for it. Changes nothing when it is cancelled.
  void interpolate(const Points& positions, SubdividedSurface& surface, const Progress& progress) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// A bicubic piece of the limit surface of an all-quad cage: the cell of side 2^−depth at (u, v) of the unit
/// square of a face, u from its corner 0 to 1, v from 0 to 3.
struct LimitCell {
  int face = 0;
  int depth = 0;
  int u = 0, v = 0;                             // in units of the cell's side
  Eigen::Matrix<double, 16, 3> control_points;  // uniform bicubic B-spline, index 4 j + i, i along u
};

/// The limit surface of an all-quad cage without semi-sharp features: exact cells down to `depth`, all of it
/// but the cells of that depth at irregular vertices.
struct LimitCells {
  std::vector<LimitCell> cells;
  Points vertex_positions, vertex_normals;  // of the limit surface, at the vertices of the cage
};
LimitCells limit_cells(const ControlCage& cage, const CageTopology& topology, int depth, bool smooth_corners);

/// Position and tangents of the limit surface at a dart, as weights (3 × (2 n + 1)) of the vertex, its n edge
/// neighbours and n face diagonals in turn, the sharp edge first: the left eigenvectors of the subdivision
/// matrix around it. OpenSubdiv takes those of a smooth vertex, which leave out that the edge point of the
/// sharp edge is its middle.
Eigen::MatrixXd dart_masks(int n);

}  // namespace batten::detail
