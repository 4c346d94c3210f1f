#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

// How one face of a model is divided into quads, and where these lie in a plane. Private to the room.
namespace batten::detail {

/// n × 2 positions in the domain of a face.
using PlanePoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// The quads of a face: pieces that are convex as far as the face allows, each split as Catmull–Clark does
/// (n quads around its centroid, then four of each). The new edges between pieces are straight (H 6.4.2).
struct FaceSplit {
  /// Vertices: first those of the boundary, side by side, each side without its end; then the inner ones.
  PlanePoints domain;
  int n_boundary = 0;
  /// Counter-clockwise in the domain. The first corner is the one nearest to the corner of its piece, the
  /// third the one nearest to its centroid.
  std::vector<std::array<int, 4>> quads;
  int n_pieces = 0;
  /// Where concave corners are cut off: the corner, and the next vertex on the cut.
  std::vector<std::array<int, 2>> cuts;
  bool is_grid = false;  ///< one piece: rows and columns instead of quads around a centroid
  /// Of an undivided face of four corners (sides that go on smoothly count as one): another domain, the unit
  /// square; else 0 × 2.
  PlanePoints square;
  /// The domain is the face's best plane; false: a convex polygon with sides of the same lengths, or a disc,
  /// because the face overlaps itself in its plane or turns away from it.
  bool is_projection = false;
  /// The domain is the face unrolled, as good as its plane: it overlaps itself there or turns away, and comes
  /// so near to itself somewhere that no convex polygon will do.
  bool is_unrolled = false;
};

/// Parts per side, mostly 1: into how many it should be divided before the face is split, so that cuts from
/// concave corners find a vertex opposite. @param sides as below, with any number of points, the same on
/// each.
std::vector<int> parts_at_concave_corners(const std::vector<Points>& sides);

/// @param sides the points of each side of a face in order, (2^splits + 1) × 3, the last of one being the
/// first of the next; two sides or more.
/// Every triangle that cut_along_corners() makes of the quads is counter-clockwise in the domain.
FaceSplit split_face_into_quads(const std::vector<Points>& sides, int splits);

/// Two triangles of a quad, cut along the diagonal from its first corner to its third: of the ways to cut,
/// the one that brings great circles nearest to a sphere (largest error of the radius at 16 n quads below
/// 0.5 %; 1.1 % with the other diagonal, 0.6 % with the mean of both), and the one that keeps quads at
/// concave corners whole.
inline std::array<std::array<int, 3>, 2> cut_along_corners(const std::array<int, 4>& c) {
  return {{{c[0], c[1], c[2]}, {c[0], c[2], c[3]}}};
}

}  // namespace batten::detail
