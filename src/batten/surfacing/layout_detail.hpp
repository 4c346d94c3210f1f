#pragma once
#include <optional>
#include <vector>

#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/tessellation_detail.hpp"

namespace batten::detail {

/// A region of the plane with what its corners stand for.
struct LaidOut {
  PlaneRegion region;
  std::vector<int> network_vertices;
  int n_inner = 0;                    ///< corners that are no network vertices: those of cuts
  std::vector<int> vertex_of_corner;  ///< local numbers of PatchMesh; empty: corner i is network vertex i
  bool mirrored = false;              ///< the region is the mirror image of the patch seen from outside
};

/// Plane coordinates are in units of the mean edge of the patch, which no motion of the network changes, and
/// rounded to this grid, so that moved, scaled and renumbered input, and that of a machine with another sine,
/// gives the very same points: ties of the Delaunay triangulation, frequent on symmetric networks, then break
/// the same way.
constexpr double kGrid = 0.7548776662466927e-5;
double on_grid(double x);

/// Where a loop begins, from its shape alone, so that a rotated network is laid out alike: the vertex
/// farthest from the centre, then the one with the most distant neighbours; ties (symmetric patches) by the
/// given order.
std::size_t intrinsic_start(const ScaledNetwork& network, const std::vector<int>& loop,
                            const Eigen::RowVector3d& centre, double unit);

/// A patch of one loop rolled out into the plane: the edges of its outline keep their lengths, and the angles
/// between them, measured in the tangent planes, change as little as closes the outline: least Σ δ² / s with
/// the change δ at a vertex and the length s that it stands for. Developable patches are laid out exactly,
/// those that bend over (half a tube, a dome beyond its equator) without the compression of a projection.
/// @return nothing where the outline does not close. It may cross itself. Linear time.
std::optional<LaidOut> lay_out_unrolled(const ScaledNetwork& network, const NetworkCycle& cycle, double unit);

}  // namespace batten::detail
