#include "command.hpp"
#include "commands/words.hpp"
#include "stroke_arguments.hpp"
#include "surface_arguments.hpp"

#include <memory>
#include <string>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/network_io.hpp"

namespace batten::cli {

namespace {

struct Arguments {
  std::string input;
  SurfaceArguments surface;
  StrokeArguments strokes;
  bool uncertainty = false;
};

/// How sure the vertices of a mended network are, by what its file says: as the nearest points of the curves
/// that were read.
NetworkUncertainty uncertainty_of(const std::string& path, const CurveNetwork& read,
                                  const CurveNetwork& mended, Outcome& outcome) {
  const Eigen::VectorXd deviations = read_network_uncertainty(path);
  if (deviations.size() == 0)
    outcome.warnings.push_back(concat(path,
                                      ": does not say how sure its curves are; they are taken as exact, "
                                      "and only what lies between them as unsure"));
  return commands::carried_uncertainty(deviations, read, mended);
}

Outcome run_surface(const Arguments& arguments, const Context& context) {
  check_surface_output(arguments.surface);
  if (arguments.strokes.topology == "implicit" && arguments.strokes.closed == "no")
    throw commands::UsageError(
        "an implicit surface is closed: --topology implicit does not go with --closed no");
  const NetworkSurfaceOptions options = options_of(arguments.surface);
  Outcome outcome;
  CurveNetwork curves;
  {
    const ScopedStage stage(outcome.times, "read");
    curves = read_network(arguments.input, &outcome.warnings);
  }
  // Not by curves_surface(): the network of the strokes is reported and written even where filling it fails.
  if (curves.has_normals()) {
    const CurveNetwork network = run_mending(arguments.strokes, curves, outcome);
    report_surface(arguments.surface,
                   arguments.uncertainty
                       ? uncertain_surface(network, uncertainty_of(arguments.input, curves, network, outcome),
                                           options, context.progress)
                       : network_surface(network, options, context.progress),
                   network, context, outcome);
  } else {
    if (arguments.uncertainty)
      throw InvalidInput(concat(arguments.input, ": --uncertainty needs a network with normals"));
    StrokeArguments strokes = arguments.strokes;
    if (is_cad_file(arguments.surface.output)) {  // CAD faces are made of patches
      if (strokes.topology == "implicit")
        throw commands::UsageError(
            concat(arguments.surface.output,
                   ": an implicit surface has no patches to make CAD faces of; write a mesh (.ply)"));
      strokes.topology = "cycles";
    }
    StrokeSurface made = run_strokes(strokes, options, curves, context, outcome);
    report_surface(arguments.surface, std::move(made.surface), made.implicit ? curves : made.strokes->network,
                   context, outcome);
  }
  return outcome;
}

}  // namespace

void add_surface(CLI::App& app) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      add_command(app, "surface", "Fill a curve network, or a sketch without normals, with a fair surface.",
                  "batten surface net.net -o surface.ply",
                  [arguments](Context& context) { return run_surface(*arguments, context); });
  command->add_option("network", arguments->input, "Network or sketch: .net, .obj, .json, .txt or .lop")
      ->required();
  add_surface_options(*command, arguments->surface);
  add_stroke_options(*command, arguments->strokes);
  command
      ->add_option("--crossings", arguments->surface.crossings,
                   "Without normals: patches that would cross others or fold are filled flatter, or kept")
      ->check(CLI::IsMember({"flatten", "keep"}));
  command->add_flag("--uncertainty", arguments->uncertainty,
                    "Tell how sure every vertex is: a value per vertex of .ply, and figures");
}

}  // namespace batten::cli
