#include "stroke_arguments.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/strokes/mended_network.hpp"

namespace batten::cli {

namespace {

Json finding_json(const NetworkFinding& finding) {
  Json entry = {{"defect", defect_name(finding.defect)}, {"sentence", finding.sentence}};
  if (finding.curve >= 0) entry["stroke"] = finding.curve;
  if (finding.other_curve >= 0) entry["other_stroke"] = finding.other_curve;
  entry["position"] = {finding.position.x(), finding.position.y(), finding.position.z()};
  entry["distance"] = finding.distance;
  return entry;
}

}  // namespace

StrokeNetworkOptions stroke_options(const StrokeArguments& arguments, double diameter) {
  const auto fraction = [&](const std::string& text, const char* none) {
    return text == none ? 0 : parse_length(text).in_file_units(diameter) / diameter;
  };
  StrokeNetworkOptions options;
  options.weld_tolerance = fraction(arguments.weld, "auto");
  options.reach = fraction(arguments.reach, "none");
  options.step = fraction(arguments.step, "none");
  return options;
}

void report_strokes(const StrokeNetwork& made, Outcome& outcome) {
  const CleanedStrokes& strokes = made.strokes;
  const int n_dangling = count_findings(strokes.findings, NetworkDefect::DanglingEnd),
            n_near = count_findings(strokes.findings, NetworkDefect::NearMiss);
  Json& figures = outcome.figures;
  figures["strokes"] = strokes.n_strokes;
  figures["dangling_ends"] = n_dangling;
  figures["near_misses"] = n_near;
  figures["open_crossings"] = count_findings(strokes.findings, NetworkDefect::Crossing) +
                              count_findings(strokes.findings, NetworkDefect::TJunction);
  figures["overdrawn"] = strokes.n_overdrawn;
  figures["extended_ends"] = strokes.n_extended_ends;
  figures["left_out"] = strokes.n_left_out;
  figures["weld_tolerance"] = made.weld_tolerance * made.diameter;
  figures["doubtful_places"] = made.estimate.warnings.size();
  outcome.lines.push_back(concat("sketch: ", strokes.n_strokes, " strokes, ", n_dangling, " dangling ends, ",
                                 n_near, " near misses; ", strokes.n_overdrawn, " pieces drawn twice, ",
                                 strokes.n_extended_ends, " ends extended, ", strokes.n_left_out,
                                 " pieces left out, welded within ", 100 * made.weld_tolerance,
                                 " % of the diameter"));
  outcome.warnings.insert(outcome.warnings.end(), made.warnings.begin(), made.warnings.end());
  outcome.times.add(made.times);
}

CurveNetwork run_mending(const StrokeArguments& arguments, const CurveNetwork& curves, Outcome& outcome) {
  NetworkMendingOptions options;
  options.weld_tolerance = stroke_options(arguments, bounding_box_diagonal(curves.positions)).weld_tolerance;
  if (arguments.weld != "auto" && options.weld_tolerance == 0) return curves;
  MendedNetwork mended = mended_network(curves, options);
  Json& figures = outcome.figures;
  figures["welded_vertices"] = mended.weld.n_merged_vertices + mended.weld.n_inserted_nodes;
  figures["overdrawn"] = mended.n_doubled;
  figures["left_out"] = mended.n_left_out;
  figures["weld_tolerance"] = mended.weld_tolerance * bounding_box_diagonal(curves.positions);
  outcome.warnings.insert(outcome.warnings.end(), mended.warnings.begin(), mended.warnings.end());
  if (!arguments.network.empty()) write_network(arguments.network, mended.network);
  return std::move(mended.network);
}

StrokeNetwork run_strokes(const StrokeArguments& arguments, const CurveNetwork& strokes,
                          const Context& context, Outcome& outcome) {
  if (!arguments.network.empty()) network_format(arguments.network);  // before any work is done
  const StrokeNetworkOptions options = stroke_options(arguments, bounding_box_diagonal(strokes.positions));
  if (arguments.weld != "auto" && options.weld_tolerance == 0)
    throw InvalidInput(
        "--weld 0 takes networks with normals as they are; strokes without normals must be welded");
  StrokeNetwork result = stroke_network(strokes, options, context.progress);
  report_strokes(result, outcome);
  Json diagnosis = Json::array();
  for (const NetworkFinding& finding : result.strokes.findings) {
    if (!is_notable(finding)) continue;
    diagnosis.push_back(finding_json(finding));
    outcome.lines.push_back(concat("- ", defect_name(finding.defect), ": ", finding.sentence));
  }
  outcome.figures["diagnosis"] = diagnosis;
  if (!arguments.network.empty()) write_network(arguments.network, result.network);
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
  command.add_option("--write-network", arguments.network,
                     "Write the network that the sketch, or the mended network, became: .net, .obj or .json");
}

}  // namespace batten::cli
