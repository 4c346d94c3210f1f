#include "commands/subdivide.hpp"

#include "commands/words.hpp"

#include <string_view>

#include "batten/core/text.hpp"

namespace batten::commands {

std::vector<SubdivisionScheme> parse_schemes(const std::string& text) {
  std::vector<SubdivisionScheme> schemes;
  for (const std::string_view name : split_fields(text, ',')) {
    const auto scheme = choices_of(SubdivisionScheme{}).find(name);
    if (!scheme)
      throw InvalidInput(concat("'", name, "' is no scheme; use catmull-clark, nuliss, nulissmod or linear"));
    schemes.push_back(*scheme);
  }
  return schemes;
}

SubdividedCageOptions options_of(const SubdivideArguments& arguments) {
  SubdividedCageOptions options;
  options.first_schemes = parse_schemes(arguments.scheme);
  options.subdivision.scheme = options.first_schemes.back();
  options.first_schemes.pop_back();
  options.subdivision.levels = arguments.levels;
  options.subdivision.limit = arguments.limit;
  options.subdivision.smooth_corners = is_first_word(arguments.corners, "--corners", "smooth", "sharp");
  options.subdivision.knot_exponent = arguments.knots;
  return options;
}

Json figures_of(const SubdividedCage& result) {
  Json figures = Json::object();
  figures["cage_vertices"] = result.n_vertices;
  figures["cage_faces"] = result.n_faces;
  figures["sharp_edges"] = result.n_sharp_edges;
  figures["sharp_vertices"] = result.n_sharp_vertices;
  figures["polylines"] = result.n_polylines;
  figures["components"] = result.topology.n_components;
  figures["boundary_loops"] = result.topology.n_boundary_loops;
  if (const auto genus = result.topology.genus()) figures["genus"] = *genus;
  if (result.refined) {
    figures["vertices"] = result.refined->cage.mesh.positions.rows();
    figures["faces"] = result.refined->cage.mesh.n_faces();
  }
  return figures;
}

}  // namespace batten::commands
