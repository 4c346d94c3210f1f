#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

#include "batten/core/index.hpp"
#include "batten/subdivision/bspline_basis_detail.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"

// Private to the room.
namespace batten::detail {

/// Two halvings part the cells at the two ends of an edge.
constexpr int kLeastIsolation = 2;
/// Halvings beyond the isolation down to which the limit surface is sampled.
constexpr int kSampledHalvings = 4;

/// Weights of the four control points of a uniform cubic over [0, 1] in its polar form at three arguments.
Eigen::RowVector4d polar_weights(const PolarArguments& t);

/// Polar form of a cell at arguments of the face it lies in [ramshaw1989].
Eigen::RowVector3d polar_form(const LimitCell& cell, const PolarArguments& u, const PolarArguments& v);

/// The exact cells of each face.
class FaceCells {
 public:
  /// @param cells must outlive this.
  FaceCells(const LimitCells& cells, Eigen::Index n_faces);

  /// The cell of depth at most `depth` that covers (u, v), or null.
  const LimitCell* covering(int face, double u, double v, int depth) const;

  /// Corners (0, 0), (1, 0), (1, 1), (0, 1) at which no cell of use ends: the extraordinary ones. Where the
  /// other side of a crease is extraordinary, a regular side comes out as a cell of the deepest level; it is
  /// treated likewise, and the fit then meets it exactly.
  std::array<bool, 4> irregular_corners(int face) const;

 private:
  std::vector<std::vector<const LimitCell*>> of_face_;
};

/// The limit surface of an all-quad cage, with the cells of side 2^−isolation at extraordinary vertices set
/// apart from the rest, which is known exactly.
class IsolatedLimit {
 public:
  /// All must outlive this. @param sharpness per edge. @param limit to a depth of isolation +
  /// kSampledHalvings at least.
  IsolatedLimit(const ControlCage& cage, const CageTopology& topology, const LimitCells& limit,
                const std::vector<double>& sharpness, int isolation);

  const ControlCage& cage() const { return cage_; }
  const CageTopology& topology() const { return topology_; }
  const LimitCells& surface() const { return limit_; }
  const FaceCells& cells() const { return cells_; }
  int isolation() const { return isolation_; }
  double cell_side() const;

  /// Sharp and inside.
  bool is_sharp(int edge) const { return topology_.sides[at(edge)][1] >= 0 && sharpness_[at(edge)] > 0; }
  /// Has a tangent plane that all its edges share: smooth vertices and darts inside.
  bool has_plane(int vertex) const { return has_plane_[at(vertex)] != 0; }
  /// Per corner of a face whether it is extraordinary.
  const std::array<bool, 4>& irregular(int face) const { return irregular_[at(face)]; }
  int corner(int face, int k) const { return cage_.mesh.offsets[at(face)] + (k & 3); }

  /// The limit surface, outside the cells of the deepest level.
  Eigen::RowVector3d exact(int face, double u, double v) const;

  /// Side k of a face at three polar arguments of its parameter from corner k, by a cell of at most the
  /// isolation that covers `inside`; false where there is none.
  bool side_polar(int face, int k, const PolarArguments& t, double inside, Eigen::RowVector3d& point) const;

  /// A face beside an edge, and the sense in which the edge runs along one of its sides.
  struct SideOf {
    int face = -1, side = 0;
    bool forward = true;
  };
  /// @param which 0 or 1; of a border edge the second has no face.
  SideOf side_of(int edge, int which) const;
  /// @param end of the edge, 0 or 1.
  bool irregular_end(const SideOf& side, int end) const;

  /// u and v of a place in the irregular cell at corner k, x and y from that corner along u and v, 0 to 1.
  std::array<double, 2> in_corner(int k, double x, double y) const;

 private:
  void find_tangent_planes();

  const ControlCage& cage_;
  const CageTopology& topology_;
  const LimitCells& limit_;
  const std::vector<double>& sharpness_;
  int isolation_;
  FaceCells cells_;
  std::vector<std::array<bool, 4>> irregular_;
  std::vector<char> has_plane_;
};

}  // namespace batten::detail
