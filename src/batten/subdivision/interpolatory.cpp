// Interpolatory subdivision of quad meshes with a knot interval per edge, after [beccari2008] and
// [beccari2013]: four-point rules along rows of vertices and of edge points. H 6.3.1 cites it without its
// rules; those written here stand in docs/subdivide.md with the source of each.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "batten/core/index.hpp"
#include "batten/subdivision/cage_level_detail.hpp"
#include "batten/subdivision/cage_polylines_detail.hpp"
#include "batten/subdivision/interpolatory_detail.hpp"
#include "batten/subdivision/interpolatory_rules_detail.hpp"

namespace batten::detail {

namespace {

/// One level finer. `halves` receives per edge the finer edges from its first and to its second vertex.
CageLevel refined(const CageLevel& level, const CageEdgePoints& edges, const Points& faces,
                  bool keep_polylines, bool smooth_corners, std::vector<std::array<int, 2>>& halves) {
  const int n_vertices = static_cast<int>(level.mesh.positions.rows());
  const int n_edges = static_cast<int>(level.topology.edges.size());
  CageLevel fine;
  fine.mesh.positions.resize(n_vertices + n_edges + faces.rows(), 3);
  fine.mesh.positions << level.mesh.positions, edges.points, faces;
  fine.mesh.corners.reserve(4 * level.mesh.corners.size());
  fine.mesh.offsets.reserve(level.mesh.corners.size() + 1);
  for (int c = 0; c < static_cast<int>(level.mesh.corners.size()); ++c) {
    const int face = level.topology.face_of_corner[at(c)];
    for (const int v : {level.vertex(c), n_vertices + level.edge(c), n_vertices + n_edges + face,
                        n_vertices + level.edge(level.topology.previous[at(c)])})
      fine.mesh.corners.push_back(v);
    fine.mesh.offsets.push_back(static_cast<int>(fine.mesh.corners.size()));
  }
  fine.topology = cage_topology(fine.mesh);
  const size_t n_fine = fine.topology.edges.size();
  fine.interval.assign(n_fine, 0);
  fine.edge_sharpness.assign(n_fine, 0);
  fine.polyline.assign(n_fine, -1);
  halves.assign(at(n_edges), {-1, -1});
  std::vector<std::pair<Points, Points>> pieces(at(n_edges));
  for (size_t e = 0; e < n_fine; ++e) {
    const std::array<int, 2>& ends = fine.topology.edges[e];
    const int low = std::min(ends[0], ends[1]), high = std::max(ends[0], ends[1]);
    if (low < n_vertices) {  // half of a coarser edge
      const int parent = high - n_vertices;
      const int half = level.topology.edges[at(parent)][0] == low ? 0 : 1;
      halves[at(parent)][at(half)] = static_cast<int>(e);
      fine.interval[e] = level.interval[at(parent)] / 2;
      fine.edge_sharpness[e] = sharpness_after(level.edge_sharpness[at(parent)], 1);
      if (keep_polylines && level.polyline[at(parent)] >= 0) {
        auto& [first, second] = pieces[at(parent)];
        if (first.rows() == 0)
          std::tie(first, second) =
              cut_polyline(level.polylines[at(level.polyline[at(parent)])], edges.fraction[at(parent)]);
        Points piece = half == 0 ? first : second;
        const bool from_vertex = half == 0;  // the piece runs as the coarser edge does
        if ((ends[0] == low) != from_vertex) piece = Points(piece.colwise().reverse());
        fine.polyline[e] = static_cast<int>(fine.polylines.size());
        fine.polylines.push_back(std::move(piece));
      }
    } else {  // from an edge point to a face point, between the two sides beside the edge
      const int parent = low - n_vertices, face = high - n_vertices - n_edges;
      for (const int c : level.topology.sides[at(parent)])
        if (c >= 0 && level.topology.face_of_corner[at(c)] == face)
          fine.interval[e] = 0.25 * (level.interval[at(level.edge(level.topology.previous[at(c)]))] +
                                     level.interval[at(level.edge(level.topology.next[at(c)]))]);
    }
  }
  fine.vertex_sharpness.assign(static_cast<size_t>(fine.mesh.positions.rows()), 0.0);
  for (int v = 0; v < n_vertices; ++v)
    fine.vertex_sharpness[at(v)] = sharpness_after(level.vertex_sharpness[at(v)], 1);
  find_kinds(fine, smooth_corners);
  return fine;
}

}  // namespace

void refine_interpolatory(const ControlCage& cage, const CageTopology& topology,
                          const SubdivisionOptions& options, SubdividedSurface& surface,
                          const Progress& progress) {
  CageLevel level = base_level(cage, topology, options);
  const bool follow = options.scheme != SubdivisionScheme::Nuliss;
  const int n_edges = static_cast<int>(topology.edges.size());
  surface.cage_edges = topology.edges;
  surface.face_parent.resize(static_cast<size_t>(cage.mesh.n_faces()));
  for (size_t f = 0; f < surface.face_parent.size(); ++f) surface.face_parent[f] = static_cast<int>(f);
  // Per edge of the cage the edges into which it was refined, in order.
  std::vector<std::vector<int>> links(at(n_edges));
  for (int e = 0; e < n_edges; ++e) links[at(e)] = {e};
  for (int k = 0; k < options.levels; ++k) {
    // Level k of L costs 4ᵏ.
    progress.report("subdivide", std::pow(4.0, k - options.levels));
    const CageEdgePoints edges = edge_points(level, options.scheme);
    // Coons points where all four polylines are those of the cage: in the first level (H 6.3.1).
    const Points faces =
        face_points(level, edges, options.scheme, options.scheme == SubdivisionScheme::NulissMod && k == 0);
    std::vector<std::array<int, 2>> halves;
    std::vector<int> parents;
    parents.reserve(level.mesh.corners.size());
    for (const int face : level.topology.face_of_corner) parents.push_back(surface.face_parent[at(face)]);
    CageLevel fine = refined(level, edges, faces, follow, options.smooth_corners, halves);
    for (int e = 0; e < n_edges; ++e) {
      std::vector<int> finer;
      int from = topology.edges[at(e)][0];
      for (const int link : links[at(e)]) {
        const std::array<int, 2>& ends = level.topology.edges[at(link)];
        const bool forward = ends[0] == from;
        finer.push_back(halves[at(link)][forward ? 0 : 1]);
        finer.push_back(halves[at(link)][forward ? 1 : 0]);
        from = forward ? ends[1] : ends[0];
      }
      links[at(e)] = std::move(finer);
    }
    surface.face_parent = std::move(parents);
    level = std::move(fine);
  }
  surface.edge_chains.resize(n_edges, (Eigen::Index(1) << options.levels) + 1);
  for (int e = 0; e < n_edges; ++e) {
    int v = topology.edges[at(e)][0];
    surface.edge_chains(e, 0) = v;
    for (size_t i = 0; i < links[at(e)].size(); ++i) {
      const std::array<int, 2>& ends = level.topology.edges[at(links[at(e)][i])];
      v = ends[0] == v ? ends[1] : ends[0];
      surface.edge_chains(e, static_cast<Eigen::Index>(i) + 1) = v;
    }
  }
  if (options.limit) {
    surface.limit_positions = level.mesh.positions;
    surface.limit_normals = limit_normals(level);
  }
  if (follow)
    for (size_t e = 0; e < level.polyline.size(); ++e)
      if (level.polyline[e] >= 0)
        surface.cage.polylines.push_back(
            {level.topology.edges[e][0], level.topology.edges[e][1], level.polylines[at(level.polyline[e])]});
  surface.cage.mesh = std::move(level.mesh);
}

}  // namespace batten::detail
