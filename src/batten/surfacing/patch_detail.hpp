#pragma once
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// How a patch came to its triangles.
enum class PatchLayout { Plane, Circle, Polygon, Strip, Unrolled, Space };

/// The triangles of one patch, before anything is known of its shape but its loops.
struct PatchMesh {
  /// Network vertices used, in the order of the local numbers 0 … network_vertices.size() − 1.
  std::vector<int> network_vertices;
  int n_inner = 0;      ///< further vertices, numbered after them
  Triangles triangles;  ///< local numbers
  EdgeLengths lengths;  ///< of the layout, in diameters: the metric of the first Laplacian
  PatchLayout layout = PatchLayout::Plane;
};

/// The network in units of its diameter with the centre of its box at the origin.
struct ScaledNetwork {
  Points positions, normals;
  Eigen::RowVector3d centre;
  double diameter = 0;
};

/// What messages call a patch: the name of its cycle, else "patch 3 (at vertex 7)".
std::string patch_name(const NetworkCycle& cycle, int patch);

/// About how many triangles mesh_patch() will make of a cycle: from the area between its loops, seen from
/// their middle.
double estimated_triangles(const ScaledNetwork& network, const NetworkCycle& cycle, double edge);

/// How mesh_patch() is to fill a patch.
struct PatchFilling {
  PatchMap map = PatchMap::Plane;
  double edge =
      0;  ///< length of the edges inside, about, in diameters; 0: 0.71 of the mean edge of the loops
  /// 0: the wanted map, then other layouts, the triangulation in space last; a plane that would show edges of
  /// the outline at less than half their length comes after the rolled out outline. For patches that folded
  /// over, 1: the rolled out outline, or the plane where that was it; 2: in space.
  int attempt = 0;
  /// Turning angles of outlines can be trusted. Where normals are estimates nothing is rolled out but what
  /// folded over.
  bool normals_are_measured = true;
};

/// Fills the loops of a cycle with triangles. `warning` says in words what was changed.
/// @throws InvalidInput naming the patch when it cannot be filled.
PatchMesh mesh_patch(const ScaledNetwork& network, const NetworkCycle& cycle, int patch,
                     const PatchFilling& filling, std::string& warning);
constexpr int kLayoutAttempts = 3;

/// Patches with the same two network vertices on their borders may both have an edge straight between them,
/// which would then have more than two triangles. Such edges, and those beside an edge of a curve, get a
/// vertex in their middle in every patch but the first. Edges along loops stay.
/// @param place vertices that will be welded: to what, for each of the network; empty: none will.
void split_shared_inner_edges(std::vector<PatchMesh>& patches, const std::vector<NetworkCycle>& cycles,
                              const std::vector<int>& place = {});

/// All patches as one mesh: the vertices of the network keep their numbers, those inside patches follow.
struct JoinedPatches {
  Triangles triangles;
  EdgeLengths lengths;
  std::vector<int> patch_of_triangle;
  Eigen::Index n_vertices = 0;
};
JoinedPatches join_patches(const std::vector<PatchMesh>& patches, Eigen::Index n_network);

}  // namespace batten::detail
