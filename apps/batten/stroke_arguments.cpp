#include "stroke_arguments.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"

namespace batten::cli {

void report_strokes(const StrokeNetwork& made, Outcome& outcome) {
  const CleanedStrokes& strokes = made.strokes;
  commands::append(commands::figures_of(made), outcome.figures);
  outcome.lines.push_back(
      concat("sketch: ", strokes.n_strokes, " strokes, ", outcome.figures["dangling_ends"],
             " dangling ends, ", outcome.figures["near_misses"], " near misses; ", strokes.n_overdrawn,
             " pieces drawn twice, ", strokes.n_extended_ends, " ends extended, ", strokes.n_left_out,
             " pieces left out, welded within ", 100 * made.weld_tolerance, " % of the diameter"));
  outcome.warnings.insert(outcome.warnings.end(), made.warnings.begin(), made.warnings.end());
  outcome.times.add(made.times);
}

CurveNetwork run_mending(const StrokeArguments& arguments, const CurveNetwork& curves, Outcome& outcome) {
  CurveNetwork network = mended(arguments, curves, outcome.figures, outcome.warnings);
  // Left as it was: nothing was made that could be written.
  if (!arguments.network.empty() && outcome.figures.contains("welded_vertices"))
    write_network(arguments.network, network);
  return network;
}

void tell_strokes(const StrokeArguments& arguments, const StrokeNetwork& made, Outcome& outcome) {
  report_strokes(made, outcome);
  for (const NetworkFinding& finding : made.strokes.findings)
    if (is_notable(finding))
      outcome.lines.push_back(concat("- ", defect_name(finding.defect), ": ", finding.sentence));
  outcome.figures["diagnosis"] = commands::diagnosis_json(made);
  if (!arguments.network.empty()) write_network(arguments.network, made.network);
}

StrokeSurface run_strokes(const StrokeArguments& arguments, const NetworkSurfaceOptions& surface,
                          const CurveNetwork& strokes, const Context& context, Outcome& outcome) {
  if (!arguments.network.empty()) network_format(arguments.network);  // before any work is done
  StrokeSurface result = stroke_surface(
      strokes, commands::options_of(arguments, surface, bounding_box_diagonal(strokes.positions)),
      context.progress, [&](const StrokeNetwork& made) { tell_strokes(arguments, made, outcome); });
  commands::append(commands::figures_of(result), outcome.figures);
  if (result.implicit)
    outcome.lines.push_back(
        concat("implicit surface through all strokes, ", result.implicit->field.n_sites,
               " normals found; 95 % of the strokes within ", 100 * result.implicit->stroke_distance_p95,
               " % of the diameter, all within ", 100 * result.implicit->stroke_distance_max, " %"));
  if (const std::string warning = commands::warning_of(result); !warning.empty())
    outcome.warnings.push_back(warning);
  return result;
}

void add_stroke_options(CLI::App& command, StrokeArguments& arguments) {
  // The word that stands for no length, and the least that is refused.
  const auto length = [](const char* name, const char* word, bool zero) {
    return parses("LENGTH", [name, word, zero](const std::string& text) {
      if (text == word) return;
      const double value = parse_length(text).value;
      if (!(value > 0) && !(zero && value == 0))
        throw InvalidInput(concat(name, " must be positive: ", text));
    });
  };
  command
      .add_option(
          "--weld", arguments.weld,
          "Curves this near meet (0.5%, 2mm, 0.01); auto: what gives the simplest surface; 0: networks with "
          "normals are taken as they are")
      ->check(length("--weld", "auto", true));
  command.add_option("--reach", arguments.reach, "Without normals: ends are extended to a stroke this near")
      ->check(length("--reach", "none", true));
  command
      .add_option("--step", arguments.step,
                  "Without normals: distance of samples on the cleaned curves, or none for those of the file")
      ->check(length("--step", "none", false));
  command
      .add_option("--topology", arguments.topology,
                  "Without normals: cycles: patches between strokes that meet; implicit: one closed surface "
                  "through all strokes, which need not meet; auto: cycles where they are sure")
      ->check(CLI::IsMember(choice_words<StrokeTopology>()));
  command
      .add_option("--closed", arguments.closed,
                  "Without normals: whether the surface is closed: auto, yes, or no (by cycles alone)")
      ->check(CLI::IsMember(choice_words<StrokeClosure>()));
  command
      .add_option(
          "--symmetry", arguments.symmetry,
          "Without normals: x, y, z: strokes are completed in the mirror x = 0 and the like; auto: those of "
          "an implicit surface that are nearly their own image; off")
      ->check(CLI::IsMember(choice_words<StrokeSymmetry>()));
  command.add_option("--write-network", arguments.network,
                     "Write the network that the sketch, or the mended network, became: .net, .obj or .json");
}

}  // namespace batten::cli
