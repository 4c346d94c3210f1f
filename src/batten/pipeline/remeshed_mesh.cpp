#include "batten/pipeline/remeshed_mesh.hpp"

#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten {

namespace {

void add_warnings(const TriangleMesh& input, const RemeshOptions& options, RemeshedMesh& result) {
  const RemeshReport& report = result.report;
  if (report.split_vertices > 0)
    result.warnings.push_back(
        concat("parts of the surface that only touch in a vertex were taken apart; vertices added: ",
               report.split_vertices));
  if (report.solves.unconverged > 0)
    result.warnings.push_back(
        concat("solves that stopped before they converged: ", report.solves.unconverged,
               " (relative residual ", report.solves.residual,
               "); areas or distances may be less even than they could be, which another number of "
               "`iterations` may mend"));
  if (!input.vertex_values.empty() && options.sizes.size() == 0)
    result.warnings.emplace_back("values per vertex of the input are not carried over to the new vertices");
}

}  // namespace

std::optional<std::string> RemeshedMeshOptions::problem() const {
  if (!edge_length) return remesh.problem();
  if (!(edge_length->value > 0 && std::isfinite(edge_length->value)))
    return concat("edge_length must be positive, got ", edge_length->value);
  RemeshOptions chosen = remesh;
  chosen.edge_length = edge_length->value;
  return chosen.problem();
}

RemeshedMesh remeshed_mesh(const TriangleMesh& mesh, const RemeshedMeshOptions& options,
                           const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  require_processable(mesh);
  RemeshOptions chosen = options.remesh;
  if (options.edge_length)
    chosen.edge_length = options.edge_length->in_file_units(bounding_box_diagonal(mesh.positions));
  RemeshResult remeshed = remesh(mesh, chosen, progress);
  RemeshedMesh result;
  result.times = std::move(remeshed.times);
  result.mesh = std::move(remeshed.mesh);
  result.report = std::move(remeshed.report);
  add_warnings(mesh, chosen, result);
  const ScopedStage stage(result.times, "measure");
  result.measures = remesh_measures(mesh, result.mesh, chosen.keep_edges, progress);
  result.quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
  return result;
}

}  // namespace batten
