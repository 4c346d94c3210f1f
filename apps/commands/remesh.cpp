#include "commands/remesh.hpp"

#include "commands/words.hpp"

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

RemeshedMeshOptions options_of(const RemeshArguments& arguments, const TriangleMesh& mesh,
                               const std::string& name) {
  RemeshedMeshOptions options;
  RemeshOptions& chosen = options.remesh;
  chosen.method = parse_choice<RemeshMethod>(arguments.method);
  chosen.adaptivity = arguments.adaptivity;
  chosen.n_vertices = arguments.vertices;
  chosen.max_iterations = arguments.iterations;
  chosen.keep_edges = parse_angle(arguments.keep_edges);
  chosen.hold_border = is_first_word(arguments.keep_border, "--keep-border", "exact", "curve");
  if (!arguments.edge.empty()) options.edge_length = parse_length(arguments.edge);
  if (!arguments.sizes.empty()) {
    const auto found = mesh.vertex_values.find(arguments.sizes);
    if (found == mesh.vertex_values.end())
      throw InvalidInput(concat(name, " has no value '", arguments.sizes,
                                "' per vertex; --sizes names a property of a PLY file"));
    chosen.sizes = found->second;
  }
  return options;
}

Json figures_of(const RemeshedMesh& result) {
  const RemeshMeasures& measures = result.measures;
  const MeshQuality& quality = result.quality;
  Json figures = Json::object();
  figures["vertices"] = result.mesh.n_vertices();
  figures["faces"] = result.mesh.n_triangles();
  figures["target_vertices"] = result.report.target_vertices;
  figures["iterations"] = result.report.iterations;
  figures["converged"] = result.report.converged;
  figures["mean_edge"] = quality.mean_edge;
  figures["faceted"] = result.report.is_faceted;
  figures["self_intersections"] = result.report.crossings;
  figures["flaws"] = result.flaws;
  figures["kept_edges"] = result.report.feature_edges;
  figures["corners"] = result.report.corners;
  figures["area_variance"] = result.report.area_variance;
  figures["mean_smallest_angle_deg"] = degrees(quality.mean_min_angle);
  figures["smallest_angle_deg"] = degrees(quality.min_angle);
  // H, table 2.3.
  figures["curvature_change"] = measures.curvature_change;
  figures["edge_variance_change"] = measures.edge_variance_change;
  figures["area_variance_change"] = measures.area_variance_change;
  figures["curvature_variance_change"] = measures.curvature_variance_change;
  figures["mean_distance"] = measures.mean_distance;
  figures["normal_error_deg"] = degrees(measures.normal_error);
  return figures;
}

}  // namespace batten::commands
