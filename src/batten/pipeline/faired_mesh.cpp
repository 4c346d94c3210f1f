#include "batten/pipeline/faired_mesh.hpp"

#include <utility>

#include "batten/core/text.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten {

namespace {

std::optional<double> volume_change(const MeshTopology& topology, const Points& before, const Points& after,
                                    const Triangles& triangles) {
  if (!topology.is_watertight()) return std::nullopt;
  const double volume = enclosed_volume(before, triangles);
  if (volume == 0) return std::nullopt;
  return enclosed_volume(after, triangles) / volume - 1;
}

void add_warnings(FairedMesh& result) {
  if (result.strategy == FairingStrategy::None)
    result.warnings.push_back(concat("the mesh looks clean (noise ", result.noise,
                                     " of a mean edge) and was left as it is; `noise` K overrules that"));
  if (result.solves.unconverged > 0)
    result.warnings.push_back(concat(
        result.solves.unconverged, result.solves.unconverged == 1 ? " refit" : " refits",
        " of the surface stopped before coming to rest (relative residual ", result.solves.residual,
        "): the result may be rougher than it could be; `noise` with a smaller number makes them easier"));
}

}  // namespace

FairedMesh faired_mesh(const TriangleMesh& mesh, const FairingOptions& options, const Progress& progress) {
  require_processable(mesh);
  FairedMesh result;
  FairingResult faired;
  {
    const ScopedStage stage(result.times, "fair");
    faired = fair(mesh.positions, mesh.triangles, options, progress);
  }
  result.topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  result.strategy = faired.strategy;
  result.noise = faired.noise;
  result.iterations = faired.iterations;
  result.time_step = faired.time_step;
  result.largest_move = faired.largest_move;
  result.solves = faired.solves;
  result.mean_normal_change = mean_normal_angle(mesh.positions, faired.positions, mesh.triangles);
  result.volume_change = volume_change(result.topology, mesh.positions, faired.positions, mesh.triangles);
  result.mesh = mesh;
  result.mesh.positions = std::move(faired.positions);
  if (mesh.normals.rows() > 0) result.mesh.normals = vertex_normals(result.mesh.positions, mesh.triangles);
  add_warnings(result);
  return result;
}

}  // namespace batten
