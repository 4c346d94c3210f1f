#include "batten/pipeline/deformed_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/deformation/multiresolution.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten {

namespace {

/// Where the handles are after each part of their motion; the last row of parts is the whole.
std::vector<Points> parts_of_motion(const Points& positions, const Handles& handles,
                                    DetailPreservation detail) {
  const int parts =
      detail == DetailPreservation::None
          ? 1
          : std::max(1, static_cast<int>(std::ceil(handles.largest_angle() / radians(45.0) - 1e-9)));
  std::vector<Points> targets;
  for (int part = 1; part < parts; ++part)
    targets.push_back(handles.targets(positions, static_cast<double>(part) / parts));
  targets.push_back(handles.targets(positions));
  return targets;
}

Deformer::Result deform_in_two_resolutions(const TriangleMesh& mesh, const Handles& handles,
                                           const DeformOptions& options, const Progress& progress,
                                           DeformedMesh& result) {
  std::optional<MultiresolutionDeformer> deformer;
  {
    const ScopedStage stage(result.times, "factorise");
    MultiresolutionOptions two;
    two.deform = options;
    deformer.emplace(mesh.positions, mesh.triangles, handles.vertices(), two, progress);
  }
  result.curvature_term = deformer->curvature_term();
  result.base_vertices = deformer->base().n_vertices();
  const ScopedStage stage(result.times, "deform");
  std::vector<Points> targets = parts_of_motion(mesh.positions, handles, options.detail);
  const Points whole = targets.back();
  targets.pop_back();
  return deformer->deform(whole, targets, progress);
}

Deformer::Result deform_directly(const TriangleMesh& mesh, const Handles& handles,
                                 const DeformOptions& options, const Progress& progress,
                                 DeformedMesh& result) {
  std::optional<Deformer> deformer;
  {
    const ScopedStage stage(result.times, "factorise");
    deformer.emplace(mesh.positions, mesh.triangles, handles.vertices(), options, progress);
  }
  result.curvature_term = deformer->curvature_term();
  const ScopedStage stage(result.times, "deform");
  Deformer::Result deformed;
  for (const Points& goal : parts_of_motion(mesh.positions, handles, options.detail)) {
    const Points start = deformed.positions;
    deformed = deformer->deform(goal, start.rows() > 0 ? &start : nullptr, progress);
  }
  return deformed;
}

}  // namespace

std::optional<std::string> DeformedMeshOptions::problem() const {
  return deform.problem();
}

DeformedMesh deformed_mesh(const TriangleMesh& mesh, const Handles& handles,
                           const DeformedMeshOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  require_processable(mesh);
  if (const auto problem = handles.problem(mesh.n_vertices())) throw InvalidInput(*problem);
  DeformedMesh result;
  result.n_fixed = handles.fixed.size();
  result.n_moved = handles.vertices().size() - handles.fixed.size();
  const auto deform = options.multiresolution ? deform_in_two_resolutions : deform_directly;
  const Deformer::Result deformed = deform(mesh, handles, options.deform, progress, result);
  result.report = deformed.report;
  result.mesh = mesh;
  result.mesh.positions = deformed.positions;
  if (mesh.normals.rows() > 0) result.mesh.normals = vertex_normals(result.mesh.positions, mesh.triangles);

  if (options.deform.energy == DeformationEnergy::TotalCurvature &&
      result.curvature_term < options.deform.curvature_term)
    result.warnings.push_back(
        concat("the total curvature energy is indefinite on this shape: its curvature term was scaled by ",
               result.curvature_term));
  if (!result.report.converged)
    result.warnings.push_back(concat("stopped after ", result.report.iterations,
                                     " iterations while vertices still moved by ", result.report.last_move,
                                     " of the diameter; raise `iterations`"));
  return result;
}

}  // namespace batten
