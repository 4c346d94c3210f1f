#include "command.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/pipeline/shape_comparison.hpp"

namespace batten::cli {

namespace {

struct CompareArguments {
  std::string a, b, registration = "none", distances;
  std::uint64_t seed = 1;
  long samples = 200000;
  bool repair = false;
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

/// Null where one of the shapes is no oriented manifold.
Json variation_json(const std::optional<MeshVariation>& variation) {
  if (!variation) return nullptr;
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"mean_curvature", known(variation->mean_curvature)},
          {"edge_variance", known(variation->edge_variance)},
          {"area_variance", known(variation->area_variance)},
          {"curvature_variance", known(variation->curvature_variance)}};
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
  if (arguments.repair)
    for (Model* model : {&a, &b})
      if (model->mesh) {
        MeshFile file{std::move(*model->mesh), std::move(model->attributes)};
        prepare_mesh(model->path, file, outcome.warnings, true, context.progress);
        model->mesh = std::move(file.mesh);
        model->attributes = std::move(file.attributes);
      }
  CompareOptions options;
  options.seed = arguments.seed;
  options.samples = arguments.samples;
  options.registration = parse_choice<RegistrationKind>(arguments.registration);
  const ShapeComparison compared = compared_shapes(shape_of(a), shape_of(b), options, context.progress);
  add_run(compared.times, compared.warnings, outcome);
  const Comparison& found = compared.distances;
  if (!arguments.distances.empty()) {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.distances, measured_mesh(*a.mesh, found), {{}, a.attributes}, true, outcome);
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
  figures["hausdorff"] = compared.hausdorff;
  figures["normals"] = {{"a_to_b", normals_json(found.a_to_b.normal_angles)},
                        {"b_to_a", normals_json(found.b_to_a.normal_angles)}};
  figures["variation"] = variation_json(compared.variation);
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
      ->check(CLI::IsMember(choice_words<RegistrationKind>()));
  command
      ->add_option("--samples", arguments->samples, "Random points per direction, uniform by area or length")
      ->check(CLI::Range(1L, 100000000L));
  command->add_option("--seed", arguments->seed, "Seed of the random points");
  command
      ->add_option("--distances", arguments->distances,
                   "Write A, moved, with its distances per vertex (.ply)")
      ->check([](const std::string& path) {
        return output_extension(path, "ply") == "ply" ? std::string()
                                                      : concat("--distances must name a .ply file: ", path);
      });
  add_repair_flag(*command, arguments->repair);
}

}  // namespace batten::cli
