#include "commands/simplify.hpp"

#include "commands/words.hpp"

#include <algorithm>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

namespace {

Json side_figures(const DirectedComparison& side, double diameter) {
  Json figures = Json::object();
  figures["dmax"] = std::max(side.samples.max, side.vertices.max) / diameter;
  figures["dmean"] = side.samples.mean / diameter;
  figures["drms"] = side.samples.rms / diameter;
  return figures;
}

}  // namespace

double parse_removed_fraction(const std::string& text) {
  const double fraction = parse_fraction(text);
  if (!(fraction > 0 && fraction < 1))
    throw InvalidInput(concat("must be above 0 % and below 100 %: ", text));
  return fraction;
}

Length parse_error_length(const std::string& text) {
  const Length length = parse_length(text);
  if (!(length.value > 0)) throw InvalidInput(concat("must be more than 0: ", text));
  return length;
}

std::optional<double> parse_fidelity(const std::string& text) {
  if (text == "adaptive") return std::nullopt;
  double value = 0;
  if (!parse_number(text, value) || !(value >= 0 && value < 1e300))
    throw InvalidInput(concat("takes adaptive or a number of at least 0, got ", text));
  return value;
}

double parse_kept_angle(const std::string& text) {
  if (text == "off") return 0;
  const double angle = parse_angle(text);
  if (!(angle > 0 && angle < kPi))
    throw InvalidInput(concat("takes off or an angle between 0deg and 180deg, got ", text));
  return angle;
}

SimplifiedMeshOptions options_of(const SimplifyArguments& arguments) {
  const int criteria =
      (arguments.faces > 0 ? 1 : 0) + (arguments.remove.empty() ? 0 : 1) + (arguments.error.empty() ? 0 : 1);
  if (criteria != 1) throw UsageError("simplify: give exactly one of --faces, --remove and --error");
  SimplifiedMeshOptions options;
  SimplifyOptions& chosen = options.simplify;
  chosen.faces = arguments.faces;
  if (!arguments.remove.empty()) chosen.remove = parse_removed_fraction(arguments.remove);
  if (!arguments.error.empty()) options.max_error = parse_error_length(arguments.error);
  chosen.method = parse_choice<SimplifyMethod>(arguments.method);
  chosen.levels = arguments.levels;
  chosen.keep_levels = arguments.keep_all_levels;
  chosen.keep_edges = parse_kept_angle(arguments.keep_edges);
  chosen.hold_border = is_first_word(arguments.keep_border, "--keep-border", "exact", "shape");
  chosen.alpha = arguments.alpha;
  chosen.beta = arguments.beta;
  chosen.flow.p = arguments.p;
  chosen.flow.sigma = arguments.sigma;
  chosen.flow.weight = parse_choice<FlowWeight>(arguments.weight);
  chosen.flow.fidelity = parse_fidelity(arguments.fidelity);
  return options;
}

Json figures_of(const TriangleMesh& input, const SimplifiedMesh& result) {
  const TriangleMesh& small = result.simplified.mesh;
  Json figures = Json::object();
  figures["vertices"] = small.n_vertices();
  figures["faces"] = small.n_triangles();
  figures["input_vertices"] = input.n_vertices();
  figures["input_faces"] = input.n_triangles();
  figures["removed"] = result.removed;
  figures["collapses"] = result.simplified.collapses;
  figures["diameter"] = result.diameter;
  figures["input_to_result"] = side_figures(result.distances.a_to_b, result.diameter);
  figures["result_to_input"] = side_figures(result.distances.b_to_a, result.diameter);
  figures["min_angle_deg"] = degrees(result.quality.min_angle);
  figures["mean_min_angle_deg"] = degrees(result.quality.mean_min_angle);
  figures["input_self_intersections"] = result.input_crossings;
  figures["self_intersections"] = result.crossings;
  return figures;
}

}  // namespace batten::commands
