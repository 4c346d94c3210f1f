#include "batten/core/index.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"
#include "batten/modelling/surface_records_detail.hpp"

namespace batten::detail {

using Eigen::Index;

SurfacePart SurfaceRecords::part(const FaceSet& set, const PolylineMesh& mesh) {
  SurfacePart part;
  for (const int f : set.list)
    for (const std::array<int, 4>& quad : faces[at(f)].quads) {
      for (const int v : quad) {
        if (local[at(v)] < 0) {
          local[at(v)] = static_cast<int>(part.vertices.size());
          part.vertices.push_back(v);
        }
        part.mesh.corners.push_back(local[at(v)]);
      }
      part.mesh.offsets.push_back(static_cast<int>(part.mesh.corners.size()));
      part.face_of_quad.push_back(f);
    }
  for (const int f : set.list)
    for (const auto& [corner, next] : faces[at(f)].relief)
      part.sharp_edges.push_back({local[at(corner)], local[at(next)], kInfinitelySharp});
  const size_t n = part.vertices.size();
  part.complete.assign(n, 1);
  part.border.assign(n, 0);
  part.soft.assign(n, 0);
  part.held.assign(n, 0);
  part.sharpness.assign(n, 0);
  std::vector<char> met(n, 0);
  for (const int f : set.list)
    for (const int side : faces[at(f)].sides) {
      const EdgeRecord& edge = edges[at(edge_of(side))];
      const int beyond = mesh.face_of(opposite_side(side));
      const bool complete = beyond < 0 || set.has[at(beyond)], own = !(side & 1) || !complete || beyond < 0;
      for (size_t k = 0; k < edge.chain.size(); ++k) {
        const int v = local[at(edge.chain[k])];
        const auto i = at(v);
        if (!complete) part.complete[i] = 0;
        if (edge.is_border()) part.border[i] = 1;
        if (holds(edge)) part.held[i] = 1;
        if (edge.drawn && options.fidelity > 0) part.soft[i] = 1;
        if (k > 0 && k + 1 < edge.chain.size()) part.sharpness[i] = 2 * edge.sharpness;
        if (own && edge.sharpness > 0 && k + 1 < edge.chain.size())
          part.sharp_edges.push_back({v, local[at(edge.chain[k + 1])], crease_sharpness(edge.sharpness)});
      }
      // S of the vertices of the model, from all of their edges.
      const int vertex = mesh.start_of(side), v = local[at(of_vertex[at(vertex)])];
      if (met[at(v)]) continue;
      met[at(v)] = 1;
      double sum = 0;
      for (const int e : mesh.vertex(vertex).edges) {
        sum += mesh.edge(e).sharpness;
        for (const int face : mesh.edge(e).faces) {
          if (face < 0) part.border[at(v)] = 1;
          if (face >= 0 && !set.has[at(face)]) part.complete[at(v)] = 0;
        }
      }
      part.sharpness[at(v)] = sum;
      (options.fidelity > 0 ? part.soft : part.held)[at(v)] = 1;
    }
  // The tip of a dart (S ≤ 1) stays smooth.
  for (double& s : part.sharpness)
    if (s <= 1) s = 0;
  part.mesh.positions.resize(static_cast<Index>(n), 3);
  for (size_t v = 0; v < n; ++v) {
    part.mesh.positions.row(static_cast<Index>(v)) = positions[at(part.vertices[v])].transpose();
    local[at(part.vertices[v])] = -1;
  }
  return part;
}

}  // namespace batten::detail
