#include "batten/surfacing/crossing_removal.hpp"

#include <cmath>
#include <optional>

#include "batten/core/index.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/mending.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/surfacing/hole_filling.hpp"

namespace batten {

namespace {

using Eigen::Index;

constexpr int kMostRounds = 3, kMostRings = 4;
/// Shares of area that may be made anew and of volume that may change.
constexpr double kMostArea = 0.05, kMostVolume = 0.005;

using Pairs = std::vector<std::pair<int, int>>;

/// The mesh without the triangles of the pairs and some rings around them, and the holes filled; nothing
/// where that would change more than spots.
std::optional<TriangleMesh> remade(const TriangleMesh& mesh, const Pairs& crossings, int rings,
                                   const Progress& progress) {
  std::vector<char> out(static_cast<size_t>(mesh.n_triangles()), 0);
  for (const auto& [f, g] : crossings) out[at(f)] = out[at(g)] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<char> reached(static_cast<size_t>(mesh.n_vertices()), 0);
    for (Index f = 0; f < mesh.n_triangles(); ++f)
      if (out[static_cast<size_t>(f)] != 0)
        for (int k = 0; k < 3; ++k) reached[at(mesh.triangles(f, k))] = 1;
    for (Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k)
        if (reached[at(mesh.triangles(f, k))] != 0) out[static_cast<size_t>(f)] = 1;
  }
  TriangleMesh rest = mesh;
  Index kept = 0;
  for (Index f = 0; f < mesh.n_triangles(); ++f)
    if (out[static_cast<size_t>(f)] == 0) rest.triangles.row(kept++) = mesh.triangles.row(f);
  rest.triangles.conservativeResize(kept, 3);
  if (kept == 0 || surface_area(rest.positions, rest.triangles) <
                       (1 - kMostArea) * surface_area(mesh.positions, mesh.triangles))
    return std::nullopt;
  // Borders of the input stay open.
  HoleFillingOptions options;
  options.left_open.assign(static_cast<size_t>(mesh.n_vertices()), 0);
  const MeshEdges edges = mesh_edges(mesh.triangles, mesh.n_vertices());
  for (Index e = 0; e < edges.n_edges(); ++e)
    if (edges.n_triangles(e) == 1)
      for (int k = 0; k < 2; ++k) options.left_open[at(edges.vertices(e, k))] = 1;
  rest.vertex_values["\x01left_open"] =
      Eigen::Map<const Eigen::Matrix<char, Eigen::Dynamic, 1>>(options.left_open.data(), mesh.n_vertices())
          .cast<double>();
  MendingOptions mending;
  mending.weld = false;
  MendedMesh mended = mended_mesh(rest, mending, progress);
  const Eigen::VectorXd left_open = mended.mesh.vertex_values["\x01left_open"];
  mended.mesh.vertex_values.erase("\x01left_open");
  options.left_open.assign(static_cast<size_t>(mended.mesh.n_vertices()), 0);
  for (Index v = 0; v < left_open.size(); ++v) options.left_open[static_cast<size_t>(v)] = left_open(v) != 0;
  return filled_mesh(mended.mesh, options, progress).mesh;
}

bool is_same_shape(const TriangleMesh& before, const TriangleMesh& after) {
  const MeshTopology one = mesh_topology(before.triangles, before.n_vertices()),
                     other = mesh_topology(after.triangles, after.n_vertices());
  if (!other.problems.empty() || one.n_components != other.n_components ||
      one.n_boundary_loops != other.n_boundary_loops || one.genus() != other.genus())
    return false;
  if (!one.is_watertight()) return true;
  const double volume = enclosed_volume(before.positions, before.triangles);
  return std::abs(enclosed_volume(after.positions, after.triangles) - volume) <=
         kMostVolume * std::abs(volume);
}

}  // namespace

UncrossedMesh uncrossed_mesh(const TriangleMesh& mesh, const Progress& progress) {
  UncrossedMesh result{mesh, self_intersections(mesh.positions, mesh.triangles, kMostCrossings, progress), 0};
  result.crossings_before = result.crossings.size();
  if (result.crossings_before >= kMostCrossings) return result;
  for (int round = 0; round < kMostRounds && !result.crossings.empty(); ++round) {
    const std::size_t before = result.crossings.size();
    for (int rings = 0; rings <= kMostRings && !result.crossings.empty(); ++rings) {
      progress.report("crossings", (round + rings / (kMostRings + 1.0)) / kMostRounds);
      std::optional<TriangleMesh> next = remade(result.mesh, result.crossings, rings, progress);
      if (!next || !is_same_shape(result.mesh, *next)) continue;
      Pairs crossings = self_intersections(next->positions, next->triangles, kMostCrossings, progress);
      if (crossings.size() >= result.crossings.size()) continue;
      result.mesh = std::move(*next);
      result.crossings = std::move(crossings);
    }
    if (result.crossings.size() == before) break;
  }
  return result;
}

}  // namespace batten
