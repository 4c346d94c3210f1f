#include "command.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/operators/mesh_variation.hpp"

namespace batten::cli {

namespace {

struct CompareArguments {
  std::string a, b, registration = "none", distances;
  std::uint64_t seed = 1;
  long samples = 200000;
};

Json figures_json(const DistanceFigures& figures, double divisor) {
  Json json = Json::object();
  json["max"] = figures.max / divisor;
  json["mean"] = figures.mean / divisor;
  json["rms"] = figures.rms / divisor;
  return json;
}

/// The figures to quote first, then those they come from.
Json directed_json(const DirectedComparison& side, double divisor) {
  Json json = figures_json(side.samples, divisor);
  json["max"] = std::max(side.vertices.max, side.samples.max) / divisor;
  json["vertices"] = figures_json(side.vertices, divisor);
  json["samples"] = figures_json(side.samples, divisor);
  return json;
}

/// Null where one of the shapes is a network.
Json normals_json(const DistanceFigures& angles) {
  if (angles.count == 0) return nullptr;
  return {
      {"max_deg", degrees(angles.max)}, {"mean_deg", degrees(angles.mean)}, {"rms_deg", degrees(angles.rms)}};
}

/// What of (2.50), (2.51) and Table 2.3 of H can be measured; null where a mesh is no oriented manifold.
Json variation_json(const TriangleMesh& original, const Points& positions, const TriangleMesh& mesh) {
  for (const TriangleMesh* one : {&original, &mesh}) {
    const MeshTopology topology = mesh_topology(one->triangles, one->n_vertices());
    if (one->n_triangles() == 0 || !topology.is_manifold() || !topology.is_oriented()) return nullptr;
  }
  const MeshVariation v = mesh_variation(original.positions, original.triangles, positions, mesh.triangles);
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"mean_curvature", known(v.mean_curvature)},
          {"edge_variance", known(v.edge_variance)},
          {"area_variance", known(v.area_variance)},
          {"curvature_variance", known(v.curvature_variance)}};
}

Json registration_json(const std::string& kind, const Registration& registration) {
  const SimilarityTransform& transform = registration.transform;
  Json json = Json::object();
  json["kind"] = kind;
  json["scale"] = transform.scale;
  json["rotation"] = Json::array();
  for (int i = 0; i < 3; ++i)
    json["rotation"].push_back(
        {transform.rotation(i, 0), transform.rotation(i, 1), transform.rotation(i, 2)});
  json["translation"] = {transform.translation.x(), transform.translation.y(), transform.translation.z()};
  json["angle_deg"] = degrees(transform.angle());
  json["rms"] = registration.rms;
  json["iterations"] = registration.iterations;
  json["converged"] = registration.converged;
  return json;
}

std::string line_of(const std::string& direction, const char* over, const DistanceFigures& figures,
                    double diameter) {
  const auto percent = [&](double value) { return concat(value, " (", 100 * value / diameter, " %)"); };
  return concat("  ", direction, " ", over, "  mean ", percent(figures.mean), "  rms ", percent(figures.rms),
                "  max ", percent(figures.max));
}

Outcome run_compare(const CompareArguments& arguments, Context& context) {
  Outcome outcome;
  Model a, b;
  {
    const ScopedStage stage(outcome.times, "read");
    a = read_model(arguments.a, outcome.warnings);
    b = read_model(arguments.b, outcome.warnings);
  }
  if (!arguments.distances.empty() && !a.mesh)
    throw InvalidInput(concat("--distances needs a mesh to write to, but ", arguments.a, " is a network"));
  CompareOptions options;
  options.seed = arguments.seed;
  options.samples = arguments.samples;
  if (arguments.registration == "rigid") options.registration = RegistrationKind::Rigid;
  if (arguments.registration == "similarity") options.registration = RegistrationKind::Similarity;
  Comparison found;
  {
    const ScopedStage stage(outcome.times, "compare");
    found = compare(shape_of(a), shape_of(b), options, context.progress);
  }
  if (!found.registration.converged)
    outcome.warnings.push_back(
        "the registration stopped before it had converged; the distances may be too large");
  if (!arguments.distances.empty()) {
    const ScopedStage stage(outcome.times, "write");
    TriangleMesh mesh = *a.mesh;
    mesh.positions = found.registration.transform(mesh.positions);
    if (mesh.normals.rows() > 0) mesh.normals = found.registration.transform.rotated(mesh.normals);
    mesh.vertex_values["distance"] = found.a_to_b.vertex_distances;
    write_mesh(arguments.distances, mesh);
  }

  Json& figures = outcome.figures;
  figures["a"] = describe(a);
  figures["b"] = describe(b);
  figures["diameter"] = found.diameter;
  figures["registration"] = registration_json(arguments.registration, found.registration);
  figures["a_to_b"] = directed_json(found.a_to_b, 1);
  figures["b_to_a"] = directed_json(found.b_to_a, 1);
  figures["relative"] = {{"a_to_b", directed_json(found.a_to_b, found.diameter)},
                         {"b_to_a", directed_json(found.b_to_a, found.diameter)}};
  figures["hausdorff"] = std::max({found.a_to_b.samples.max, found.a_to_b.vertices.max,
                                   found.b_to_a.samples.max, found.b_to_a.vertices.max});
  figures["normals"] = {{"a_to_b", normals_json(found.a_to_b.normal_angles)},
                        {"b_to_a", normals_json(found.b_to_a.normal_angles)}};
  figures["variation"] = nullptr;
  if (a.mesh && b.mesh) {
    const ScopedStage stage(outcome.times, "variation");
    figures["variation"] = variation_json(*b.mesh, found.registration.transform(a.mesh->positions), *a.mesh);
  }
  figures["samples"] = options.samples;

  outcome.lines.push_back(
      concat("distances (in brackets: of the diameter of ", arguments.b, ", ", found.diameter, ")"));
  outcome.lines.push_back(line_of("A to B", "vertices", found.a_to_b.vertices, found.diameter));
  outcome.lines.push_back(line_of("A to B", "samples ", found.a_to_b.samples, found.diameter));
  outcome.lines.push_back(line_of("B to A", "vertices", found.b_to_a.vertices, found.diameter));
  outcome.lines.push_back(line_of("B to A", "samples ", found.b_to_a.samples, found.diameter));
  if (found.a_to_b.normal_angles.count > 0)
    outcome.lines.push_back(concat("  normals  A to B mean ", degrees(found.a_to_b.normal_angles.mean),
                                   " degrees, B to A ", degrees(found.b_to_a.normal_angles.mean)));
  if (options.registration != RegistrationKind::None) {
    const SimilarityTransform& t = found.registration.transform;
    outcome.lines.push_back(concat("A was turned by ", degrees(t.angle()), " degrees, scaled by ", t.scale,
                                   ", then moved by (", t.translation.x(), ", ", t.translation.y(), ", ",
                                   t.translation.z(), ")"));
  }
  return outcome;
}

}  // namespace

void add_compare(CLI::App& app) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command =
      add_command(app, "compare", "Measure the distance between two meshes or networks, in both directions.",
                  "batten compare surface.ply truth.ply --register rigid --json",
                  [arguments](Context& context) { return run_compare(*arguments, context); });
  command->add_option("A", arguments->a, "Mesh or network that is moved and measured")->required();
  command->add_option("B", arguments->b, "Mesh or network it is measured against")->required();
  command->add_option("--register", arguments->registration, "Move A onto B first: none, rigid, similarity")
      ->check(CLI::IsMember({"none", "rigid", "similarity"}));
  command
      ->add_option("--samples", arguments->samples, "Random points per direction, uniform by area or length")
      ->check(CLI::Range(1L, 100000000L));
  command->add_option("--seed", arguments->seed, "Seed of the random points");
  command
      ->add_option("--distances", arguments->distances,
                   "Write A, moved, with its distances per vertex (.ply)")
      ->check([](const std::string& path) {
        return file_extension(path) == "ply" ? std::string()
                                             : concat("--distances must name a .ply file: ", path);
      });
}

}  // namespace batten::cli
