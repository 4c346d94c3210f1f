#include "sketch_stage.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/strokes/sketch_network.hpp"

namespace batten::cli {

namespace {

/// A length as a fraction of the diameter.
double fraction_of(const std::string& text, double diameter) {
  return parse_length(text).in_file_units(diameter) / diameter;
}

Json finding_json(const NetworkFinding& finding) {
  Json entry = {{"defect", defect_name(finding.defect)}, {"sentence", finding.sentence}};
  if (finding.curve >= 0) entry["stroke"] = finding.curve;
  if (finding.other_curve >= 0) entry["other_stroke"] = finding.other_curve;
  entry["position"] = {finding.position.x(), finding.position.y(), finding.position.z()};
  entry["distance"] = finding.distance;
  return entry;
}

}  // namespace

SketchNetwork read_sketch(const SketchArguments& arguments, const CurveNetwork& strokes,
                          const Context& context, Outcome& outcome) {
  const double diameter = bounding_box_diagonal(strokes.positions);
  if (!(diameter > 0) || !std::isfinite(diameter))
    throw InvalidInput("the network has no extent; all its vertices lie at one place");
  SketchNetworkOptions options;
  options.weld_tolerance = arguments.weld == "auto" ? 0 : fraction_of(arguments.weld, diameter);
  options.reach = arguments.reach == "none" ? 0 : fraction_of(arguments.reach, diameter);
  options.step = arguments.step == "none" ? 0 : fraction_of(arguments.step, diameter);
  SketchNetwork made;
  {
    const ScopedStage stage(outcome.times, "sketch");
    made = sketch_network(strokes, options, context.progress);
  }
  const CleanedSketch& sketch = made.sketch;
  Json& figures = outcome.figures;
  const auto count = [&](NetworkDefect defect) {
    return std::count_if(sketch.findings.begin(), sketch.findings.end(),
                         [&](const NetworkFinding& f) { return f.defect == defect; });
  };
  figures["strokes"] = sketch.n_strokes;
  figures["dangling_ends"] = count(NetworkDefect::DanglingEnd);
  figures["near_misses"] = count(NetworkDefect::NearMiss);
  figures["open_crossings"] = count(NetworkDefect::Crossing) + count(NetworkDefect::TJunction);
  figures["overdrawn"] = sketch.n_overdrawn;
  figures["extended_ends"] = sketch.n_extended_ends;
  figures["left_out"] = sketch.n_left_out;
  figures["weld_tolerance"] = made.weld_tolerance * diameter;
  figures["doubtful_places"] = made.estimate.warnings.size();
  outcome.lines.push_back(
      concat("sketch: ", sketch.n_strokes, " strokes, ", count(NetworkDefect::DanglingEnd),
             " dangling ends, ", count(NetworkDefect::NearMiss), " near misses; ", sketch.n_overdrawn,
             " pieces drawn twice, ", sketch.n_extended_ends, " ends extended, ", sketch.n_left_out,
             " pieces left out, welded within ", 100 * made.weld_tolerance, " % of the diameter"));
  std::vector<std::string>& warnings = outcome.warnings;
  warnings.insert(warnings.end(), sketch.warnings.begin(), sketch.warnings.end());
  warnings.insert(warnings.end(), made.estimate.warnings.begin(), made.estimate.warnings.end());
  if (!made.estimate.open_curves.empty()) {
    std::string names;
    for (const int c : made.estimate.open_curves)
      names += (names.empty() ? "" : ", ") + curve_name(made.network, c);
    outcome.warnings.push_back(concat("the surface was left open at ", names,
                                      ", where a patch would fold back onto its neighbours"));
  }
  return made;
}

std::vector<NetworkCycle> run_sketch_stage(const SketchArguments& arguments, CurveNetwork& network,
                                           const Context& context, Outcome& outcome) {
  if (!arguments.network.empty()) network_format(arguments.network);  // before any work is done
  const SketchNetwork made = read_sketch(arguments, network, context, outcome);
  Json findings = Json::array();
  for (const NetworkFinding& finding : made.sketch.findings) {
    // Crossings and ends on a stroke are what every sketch has; they are welded without a word.
    if (finding.defect == NetworkDefect::Crossing || finding.defect == NetworkDefect::TJunction ||
        finding.defect == NetworkDefect::SeparateParts)
      continue;
    findings.push_back(finding_json(finding));
    outcome.lines.push_back(concat("- ", defect_name(finding.defect), ": ", finding.sentence));
  }
  outcome.figures["diagnosis"] = findings;
  network = made.network;
  if (!arguments.network.empty()) write_network(arguments.network, network);
  return made.estimate.cycles;
}

void add_sketch_options(CLI::App& command, SketchArguments& arguments) {
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
          "Without normals: strokes this near meet (0.5%, 2mm, 0.01); auto: what gives the simplest surface")
      ->check(length("--weld", "auto", false));
  command.add_option("--reach", arguments.reach, "Without normals: ends are extended to a stroke this near")
      ->check(length("--reach", "none", true));
  command
      .add_option("--step", arguments.step,
                  "Without normals: distance of samples on the cleaned curves, or none for those of the file")
      ->check(length("--step", "none", false));
  command.add_option("--write-network", arguments.network,
                     "Without normals: write the network that the sketch became: .net, .obj or .json");
}

}  // namespace batten::cli
