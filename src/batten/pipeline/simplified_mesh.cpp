#include "batten/pipeline/simplified_mesh.hpp"

#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/pipeline/carried_values.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten {

std::optional<std::string> SimplifiedMeshOptions::problem() const {
  if (!max_error) return simplify.problem();
  if (!(max_error->value > 0 && std::isfinite(max_error->value)))
    return concat("max_error must be positive, got ", max_error->value);
  SimplifyOptions chosen = simplify;
  chosen.max_error = max_error->value;
  return chosen.problem();
}

SimplifiedMesh simplified_mesh(const TriangleMesh& mesh, const SimplifiedMeshOptions& options,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  require_processable(mesh);
  SimplifiedMesh result;
  result.diameter = bounding_box_diagonal(mesh.positions);
  SimplifyOptions chosen = options.simplify;
  if (options.max_error) chosen.max_error = options.max_error->in_file_units(result.diameter);
  result.simplified = simplify(mesh, chosen, progress);
  result.times = std::exchange(result.simplified.times, {});
  result.warnings = std::exchange(result.simplified.warnings, {});
  if (result.simplified.mesh.n_triangles() > 0) {
    const ScopedStage stage(result.times, "values");
    carry_values(mesh, result.simplified.mesh, progress.part("values", 0, 0));
  }

  const ScopedStage stage(result.times, "check");
  const TriangleMesh& small = result.simplified.mesh;
  result.removed = 1 - static_cast<double>(small.n_triangles()) / static_cast<double>(mesh.n_triangles());
  result.distances = compare({mesh.positions, mesh.triangles, {}}, {small.positions, small.triangles, {}}, {},
                             progress.part("check", 0, 0.6));
  result.quality = mesh_quality(small.positions, small.triangles);
  const auto crossings = [&](const TriangleMesh& of, double from, double to) {
    return self_intersections(of.positions, of.triangles, kMostListedIntersections,
                              progress.part("check", from, to))
        .size();
  };
  result.input_crossings = crossings(mesh, 0.6, 0.9);
  result.crossings = crossings(small, 0.9, 1);
  return result;
}

std::vector<TriangleMesh> level_meshes(const TriangleMesh& input, const std::vector<SimplifyLevel>& levels) {
  std::vector<TriangleMesh> meshes(1);
  meshes[0].positions = input.positions;
  meshes[0].triangles = input.triangles;
  for (const SimplifyLevel& level : levels) {
    const std::vector<int>& map = level.vertex_of_finer;
    Eigen::VectorXd values(static_cast<Eigen::Index>(map.size()));
    for (std::size_t v = 0; v < map.size(); ++v) values[static_cast<Eigen::Index>(v)] = map[v];
    meshes.back().vertex_values["coarser_vertex"] = values;
    meshes.push_back(level.mesh);
  }
  return meshes;
}

}  // namespace batten
