#include "command.hpp"
#include "commands/compare.hpp"
#include "commands/mesh_file.hpp"
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

struct CompareArguments : commands::CompareArguments {
  std::string a, b, distances;
};

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
        commands::prepare_mesh(model->path, file, outcome.warnings, true, context.progress);
        model->mesh = std::move(file.mesh);
        model->attributes = std::move(file.attributes);
      }
  const ShapeComparison compared =
      compared_shapes(shape_of(a), shape_of(b), options_of(arguments), context.progress);
  add_run(compared.times, compared.warnings, outcome);
  const Comparison& found = compared.distances;
  if (!arguments.distances.empty()) {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.distances, measured_mesh(*a.mesh, found), {{}, a.attributes}, true, outcome);
  }

  Json& figures = outcome.figures;
  figures["a"] = describe(a);
  figures["b"] = describe(b);
  commands::append(commands::figures_of(arguments, compared), figures);

  outcome.lines.push_back(
      concat("distances (in brackets: of the diameter of ", arguments.b, ", ", found.diameter, ")"));
  outcome.lines.push_back(line_of("A to B", "vertices", found.a_to_b.vertices, found.diameter));
  outcome.lines.push_back(line_of("A to B", "samples ", found.a_to_b.samples, found.diameter));
  outcome.lines.push_back(line_of("B to A", "vertices", found.b_to_a.vertices, found.diameter));
  outcome.lines.push_back(line_of("B to A", "samples ", found.b_to_a.samples, found.diameter));
  if (found.a_to_b.normal_angles.count > 0)
    outcome.lines.push_back(concat("  normals  A to B mean ", degrees(found.a_to_b.normal_angles.mean),
                                   " degrees, B to A ", degrees(found.b_to_a.normal_angles.mean)));
  if (arguments.registration != "none") {
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
