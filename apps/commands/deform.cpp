#include "commands/deform.hpp"

namespace batten::commands {

DeformedMeshOptions options_of(const DeformArguments& arguments) {
  DeformedMeshOptions options;
  options.deform.energy = parse_choice<DeformationEnergy>(arguments.energy);
  options.deform.detail = parse_choice<DetailPreservation>(arguments.nonlinear);
  options.deform.soft_weight = arguments.soft;
  options.deform.max_iterations = arguments.iterations;
  options.multiresolution = arguments.multiresolution;
  return options;
}

Json figures_of(const DeformedMesh& result) {
  Json figures = Json::object();
  figures["vertices"] = result.mesh.n_vertices();
  figures["faces"] = result.mesh.n_triangles();
  figures["fixed"] = result.n_fixed;
  figures["moved"] = result.n_moved;
  figures["iterations"] = result.report.iterations;
  figures["converged"] = result.report.converged;
  figures["last_move"] = result.report.last_move;
  figures["curvature_term"] = result.curvature_term;
  if (result.base_vertices) figures["base_vertices"] = *result.base_vertices;
  return figures;
}

}  // namespace batten::commands
