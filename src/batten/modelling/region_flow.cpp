#include <algorithm>
#include <limits>

#include "batten/core/index.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/modelling/curvature_flow_detail.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"
#include "batten/modelling/region_flow_detail.hpp"

namespace batten::detail {

using Eigen::Index;

namespace {

/// A flow that has moved so many times farther than before in one round runs away: it goes back to where it
/// was, and on with a smaller time step, so many times at most.
constexpr double kDivergence = 4;
constexpr int kMostSlowdowns = 4;

/// Vertices of the surroundings as the region sees them.
struct Mobility {
  std::vector<char> movable;  ///< complete in the region
  std::vector<char> at_rim;   ///< of an outermost face of the region
  std::vector<char> frozen;   ///< of a frozen face
};

bool is_outermost(int face, const FaceSet& region, const PolylineMesh& mesh) {
  for (const int side : mesh.face(face).sides)
    for (const int e : mesh.vertex(mesh.start_of(side)).edges)
      for (const int next : mesh.edge(e).faces)
        if (next >= 0 && !region.has[at(next)]) return true;
  return false;
}

Mobility mobility_of(SurfaceRecords& records, const FaceSet& region, const FaceSet& surroundings,
                     const SurfacePart& around, const PolylineMesh& mesh) {
  const size_t n = around.vertices.size();
  Mobility result{std::vector<char>(n, 0), std::vector<char>(n, 0), std::vector<char>(n, 0)};
  std::vector<int>& local = records.local;
  for (size_t v = 0; v < n; ++v) local[at(around.vertices[v])] = static_cast<int>(v);
  for (const int f : region.list) {
    const bool outermost = is_outermost(f, region, mesh);
    for (const std::array<int, 4>& quad : records.faces[at(f)].quads)
      for (const int v : quad) {
        result.movable[at(local[at(v)])] = 1;
        if (records.faces[at(f)].frozen) result.frozen[at(local[at(v)])] = 1;
        if (outermost) result.at_rim[at(local[at(v)])] = 1;
      }
  }
  for (const int f : surroundings.list)
    if (!region.has[at(f)])
      for (const std::array<int, 4>& quad : records.faces[at(f)].quads)
        for (const int v : quad) result.movable[at(local[at(v)])] = 0;
  for (size_t v = 0; v < n; ++v) local[at(around.vertices[v])] = -1;
  return result;
}

FlowPatch::Begin begin_of(const FaceRecord& face, bool in_region) {
  if (!in_region || !face.stale) return FlowPatch::Begin::Kept;
  return face.is_coons ? FlowPatch::Begin::Coons : FlowPatch::Begin::Plate;
}

/// Triangles, their shapes in the domains, and patches.
void add_triangles(FlowMesh& flow, const SurfaceRecords& records, const FaceSet& region,
                   const FaceSet& surroundings, const SurfacePart& around) {
  flow.triangles.resize(2 * around.mesh.n_faces(), 3);
  flow.domain.resize(2 * around.mesh.n_faces(), 3);
  flow.patch.resize(static_cast<size_t>(2 * around.mesh.n_faces()));
  Index t = 0, q = 0;
  for (size_t patch = 0; patch < surroundings.list.size(); ++patch) {
    const int f = surroundings.list[patch];
    const FaceRecord& face = records.faces[at(f)];
    flow.patches.push_back({begin_of(face, region.has[at(f)] != 0), face.is_projection});
    for (const std::array<int, 4>& in_domain : face.domain_quads) {
      const int* c = &around.mesh.corners[static_cast<size_t>(4 * q++)];
      const auto in_space = cut_along_corners({c[0], c[1], c[2], c[3]});
      const auto in_plane = cut_along_corners(in_domain);
      for (size_t k = 0; k < 2; ++k, ++t) {
        flow.patch[static_cast<size_t>(t)] = static_cast<int>(patch);
        for (size_t i = 0; i < 3; ++i) {
          flow.triangles(t, static_cast<Index>(i)) = in_space[k][i];
          flow.domain(t, static_cast<Index>(i)) =
              (face.domain.row(in_plane[k][(i + 1) % 3]) - face.domain.row(in_plane[k][(i + 2) % 3])).norm();
        }
      }
    }
  }
}

FlowMesh flow_mesh_of(const SurfaceRecords& records, const FaceSet& region, const FaceSet& surroundings,
                      const SurfacePart& around, const Mobility& mobility) {
  FlowMesh flow;
  flow.positions = around.mesh.positions;
  add_triangles(flow, records, region, surroundings, around);
  const size_t n = around.vertices.size();
  flow.fixed.resize(n);
  flow.without_row.resize(n);
  flow.sharpness = around.sharpness;
  flow.soft = around.soft;
  flow.targets.resize(static_cast<Index>(n), 3);
  for (size_t v = 0; v < n; ++v) {
    flow.targets.row(static_cast<Index>(v)) = records.targets[at(around.vertices[v])].transpose();
    flow.fixed[v] = around.held[v] || around.border[v] || !mobility.movable[v];
    flow.without_row[v] = around.border[v] || !around.complete[v];
  }
  return flow;
}

/// Rounds until nothing moves any more; of a flow that runs away the best is kept.
void run_rounds(FlowMesh& flow, const DiffusionOptions& options, double diameter, SurfaceUpdate& last,
                const Progress& progress) {
  CurvatureFlow rounds(flow, options);
  Points best = flow.positions;
  double least = std::numeric_limits<double>::infinity();
  int n_slowdowns = 0;
  for (int round = 0; round < options.rounds; ++round) {
    progress.report("flow", static_cast<double>(round) / options.rounds);
    last.last_move = rounds.round().maxCoeff() / diameter;
    ++last.rounds;
    if (last.last_move < least) {
      least = last.last_move;
      best = flow.positions;
    }
    if (last.last_move < options.tolerance) break;
    if (last.last_move < kDivergence * least) continue;
    flow.positions = best;
    if (n_slowdowns++ == kMostSlowdowns) break;
    rounds.slow_down();
  }
  if (least < last.last_move) {
    flow.positions = best;
    last.last_move = least;
  }
}

}  // namespace

double move_region(SurfaceRecords& records, const FaceSet& region, const FaceSet& surroundings, bool start,
                   const PolylineMesh& mesh, double diameter, SurfaceUpdate& last, const Progress& progress) {
  const SurfacePart around = records.part(surroundings, mesh);
  const size_t n = around.vertices.size();
  const Mobility mobility = mobility_of(records, region, surroundings, around, mesh);
  FlowMesh flow = flow_mesh_of(records, region, surroundings, around, mobility);
  if (start) {
    start_flow(flow);
    for (size_t v = 0; v < n; ++v)
      records.started[at(around.vertices[v])] = flow.positions.row(static_cast<Index>(v));
  }
  for (size_t v = 0; v < n; ++v) {
    if (!mobility.frozen[v]) continue;
    flow.fixed[v] = 1;
    const auto place = at(around.vertices[v]);
    flow.positions.row(static_cast<Index>(v)) = records.started[place].transpose();
    records.positions[place] = records.started[place];
  }
  const Points before = flow.positions;
  run_rounds(flow, records.options, diameter, last, progress);
  double moved_rim = 0;
  for (size_t v = 0; v < n; ++v) {
    const auto row = static_cast<Index>(v);
    if (mobility.at_rim[v])
      moved_rim = std::max(moved_rim, (flow.positions.row(row) - before.row(row)).norm());
    if (!flow.fixed[v]) records.positions[at(around.vertices[v])] = flow.positions.row(row);
  }
  return moved_rim / diameter;
}

bool freeze_folded(SurfaceRecords& records, const FaceSet& region, const PolylineMesh& mesh) {
  const SurfacePart part = records.part(records.near_to(region), mesh);
  std::vector<int> folded;
  if (!part.mesh.positions.allFinite()) {
    folded = region.list;
  } else {
    for (const auto& [one, other] : self_intersections(part.mesh.positions, cut_quads(part.mesh)))
      for (const int triangle : {one, other}) folded.push_back(part.face_of_quad[at(triangle / 2)]);
  }
  bool any = false;
  for (const int f : folded) {
    if (!region.has[at(f)] || records.faces[at(f)].frozen) continue;
    any = records.faces[at(f)].frozen = true;
  }
  if (!any) return false;
  for (const int f : region.list)
    if (records.faces[at(f)].stale)
      for (const std::array<int, 4>& quad : records.faces[at(f)].quads)
        for (const int v : quad) records.positions[at(v)] = records.started[at(v)];
  return true;
}

}  // namespace batten::detail
