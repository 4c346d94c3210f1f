#include "command.hpp"
#include "commands/compare.hpp"
#include "model_file.hpp"
#include "network_arguments.hpp"
#include "surface_arguments.hpp"

#include <memory>
#include <optional>

#include "batten/core/text.hpp"
#include "batten/pipeline/shape_comparison.hpp"

namespace batten::cli {

namespace {

struct ReconstructArguments {
  NetworkArguments network;
  SurfaceArguments surface;
  std::string against;
};

/// Distances of the surface, moved rigidly onto it, from a truth.
void compare_with_truth(const std::string& path, const Context& context, Outcome& outcome) {
  Model truth;
  {
    const ScopedStage stage(outcome.times, "read");
    truth = read_model(path, outcome.warnings);
  }
  const ScopedStage stage(outcome.times, "compare");
  const TruthErrors errors = truth_errors(batten::shape_of(*outcome.exhibit.mesh), shape_of(truth),
                                          RegistrationKind::Rigid, context.progress);
  outcome.exhibit.errors = errors.vertices;
  outcome.figures["error_percent"] = commands::figures_of(errors);
  outcome.lines.push_back(concat("distance to ", path, ": mean ", errors.figures.mean, " %, max ",
                                 errors.figures.max, " % of its diameter"));
}

Outcome reconstruct(const ReconstructArguments& arguments, Context& context) {
  check_surface_output(arguments.surface);
  check_network_output(arguments.network);
  const ScanOptions scan = options_of(arguments.network);
  const NetworkSurfaceOptions filling = options_of(arguments.surface);
  Outcome outcome, network, surface;
  const std::optional<Scan> readings = read_network_scan(arguments.network, context.progress, network);
  if (!readings) return network;
  // Not by reconstruct(): the network is reported and written even where filling it fails.
  const ScanNetwork scanned = network_from_scan(*readings, scan, context.progress);
  report_network(arguments.network, scanned, network);
  report_surface(arguments.surface,
                 scanned.uncertainty
                     ? uncertain_surface(scanned.network, *scanned.uncertainty, filling, context.progress)
                     : network_surface(scanned.network, filling, context.progress),
                 scanned.network, context, surface);

  // The counts of what was made at the top, as every command has them; the figures of each stage by its name.
  for (const char* count : {"curves", "nodes", "segments", "cycles", "components", "boundary_loops",
                            "vertices", "faces", "genus", "watertight"})
    outcome.figures[count] = surface.figures[count];
  outcome.figures["network"] = network.figures;
  outcome.figures["surface"] = surface.figures;
  outcome.exhibit = std::move(surface.exhibit);
  outcome.failure = std::move(surface.failure);
  for (const Outcome* stage : {&network, &surface}) {
    outcome.times.add(stage->times);
    outcome.warnings.insert(outcome.warnings.end(), stage->warnings.begin(), stage->warnings.end());
    outcome.lines.insert(outcome.lines.end(), stage->lines.begin(), stage->lines.end());
  }
  if (!arguments.against.empty()) compare_with_truth(arguments.against, context, outcome);
  return outcome;
}

}  // namespace

void add_reconstruct(CLI::App& app) {
  const auto arguments = std::make_shared<ReconstructArguments>();
  CLI::App* command =
      add_command(app, "reconstruct", "Turn a scan of orientations and distances into a fair surface.",
                  "batten reconstruct scan.rawnet -o surface.ply --network network.json --report report.html",
                  [arguments](Context& context) { return reconstruct(*arguments, context); });
  add_surface_options(*command, arguments->surface);
  command->add_option("--network", arguments->network.output,
                      "Write the curve network too: .net, .obj or .json");
  command->add_option(
      "--against", arguments->against,
      "Mesh or network known to be true: adds the errors, after a rigid motion, to result and report");
  add_network_options(*command, arguments->network);
}

}  // namespace batten::cli
