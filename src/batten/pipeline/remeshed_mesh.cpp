#include "batten/pipeline/remeshed_mesh.hpp"

#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/pipeline/carried_values.hpp"
#include "batten/pipeline/mesh_input.hpp"
#include "batten/remeshing/area_samples.hpp"

namespace batten {

namespace {

void add_warnings(RemeshedMesh& result) {
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
}

/// The point of one mesh, of those spread over it, that is furthest from another mesh.
struct Furthest {
  double distance = 0;
  Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
};
Furthest furthest(const TriangleMesh& from, const TriangleMesh& to, double spacing,
                  const Progress& progress) {
  const std::vector<AreaSample> samples = area_samples(from.positions, from.triangles, spacing * spacing);
  Points queries(from.n_vertices() + static_cast<Eigen::Index>(samples.size()), 3);
  queries.topRows(from.n_vertices()) = from.positions;
  for (std::size_t i = 0; i < samples.size(); ++i)
    queries.row(from.n_vertices() + static_cast<Eigen::Index>(i)) = samples[i].point;
  const Eigen::VectorXd lengths =
      distances(TriangleTree(to.positions, to.triangles).closest(queries, progress));
  Eigen::Index at = 0;
  const double most = lengths.maxCoeff(&at);
  return {most, queries.row(at)};
}

void add_flaws(const TriangleMesh& input, const RemeshOptions& options, RemeshedMesh& result,
               const Progress& progress) {
  const RemeshReport& report = result.report;
  const TriangleMesh& mesh = result.mesh;
  if (report.crossings > report.input_crossings) {
    const auto pairs = self_intersections(mesh.positions, mesh.triangles, report.crossings, progress);
    const auto [f, g] = pairs.front();
    result.flaws.push_back(concat("pairs of triangles that cross: ", report.crossings, ", ",
                                  report.input_crossings, " in the input; the first are ", f, " and ", g,
                                  " at ", place_in_words(mesh, f)));
  }
  const double asked = options.edge_length > 0 ? options.edge_length
                                               : mesh_quality(input.positions, input.triangles).mean_edge;
  // A border that stays has edges of its own length, which the number of vertices takes into account.
  const bool by_length = options.n_vertices == 0 && options.sizes.size() == 0 && !options.hold_border;
  const double mean_edge = result.quality.mean_edge;
  if (report.is_faceted && by_length) {
    if (!(std::abs(mean_edge - asked) <= 0.2 * asked))
      result.flaws.push_back(concat("the mean edge is ", mean_edge, " where ", asked,
                                    " was asked for: the facets of the part allow no other"));
  } else {
    const double share = report.is_faceted ? 0.2 : 0.5, wanted = report.target_vertices;
    // Corners stay, however long the edges.
    if (!(std::abs(static_cast<double>(mesh.n_vertices()) - wanted) <= share * wanted + report.corners))
      result.flaws.push_back(
          concat("there are ", mesh.n_vertices(), " vertices where ", std::round(wanted), " were wanted"));
  }
  if (mesh_topology(input.triangles, input.n_vertices()).n_boundary_edges == 0) {
    const double before = enclosed_volume(input.positions, input.triangles),
                 after = enclosed_volume(mesh.positions, mesh.triangles);
    if (!(std::abs(after - before) <= (report.is_faceted ? 0.005 : 0.05) * std::abs(before)))
      result.flaws.push_back(concat("the volume changed from ", before, " to ", after));
  }
  if (!report.is_faceted) return;
  const double most = 0.02 * asked, spacing = 0.3 * mean_edge;
  for (const bool back : {false, true}) {
    const Furthest at =
        back ? furthest(mesh, input, spacing, progress) : furthest(input, mesh, spacing, progress);
    if (!(at.distance <= most))
      result.flaws.push_back(concat(back ? "the result leaves the input by " : "the input is missed by ",
                                    at.distance, " at ", place_in_words(at.point)));
  }
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
  add_warnings(result);
  {
    const ScopedStage stage(result.times, "values");
    carry_values(mesh, result.mesh, progress.part("values", 0, 0));
  }
  const ScopedStage stage(result.times, "measure");
  result.measures = remesh_measures(mesh, result.mesh, chosen.keep_edges, progress);
  result.quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
  add_flaws(mesh, chosen, result, progress);
  return result;
}

}  // namespace batten
