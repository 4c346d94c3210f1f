#include "model_surface_arguments.hpp"

#include <vector>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::cli {

namespace {

Json faces_json(const std::vector<int>& faces) {
  Json names = Json::array();
  for (const int face : faces) names.push_back(concat("f", face));
  return names;
}

Json figures_of(const CurveContinuity& c, double diameter) {
  return {{"samples", c.n_samples},
          {"max_normal_jump_deg", degrees(c.max_normal_jump)},
          {"mean_normal_jump_deg", degrees(c.mean_normal_jump)},
          {"max_curvature_jump", c.max_curvature_jump * diameter},
          {"mean_curvature_jump", c.mean_curvature_jump * diameter},
          {"max_gap", c.max_gap / diameter},
          {"max_distance", c.max_distance / diameter},
          {"worst", {c.worst.x(), c.worst.y(), c.worst.z()}}};
}

}  // namespace

void add_model_surface_options(CLI::App& command, ModelSurfaceArguments& arguments) {
  command
      .add_option("--method", arguments.method,
                  "How the surface is made: v2, by diffusion of mean curvature, v1, from Coons patches, or "
                  "curvature, by filling the network")
      ->check(CLI::IsMember(choice_words<ModelSurfaceMethod>()));
  command.add_option("--levels", arguments.levels, "Levels of subdivision of the finished surface")
      ->check(CLI::Range(0, 6));
  command
      .add_option("--splits", arguments.splits, "v2: splits of the faces before the flow: 3 gives 16 n quads")
      ->check(CLI::Range(1, 6));
  command
      .add_option("--scheme", arguments.scheme,
                  "v1: catmull-clark, nuliss, nulissmod, or nulissmod+catmull-clark: one level of the first")
      ->check(CLI::IsMember(choice_words<FinalScheme>()));
  command
      .add_option("--refinements", arguments.refinements,
                  "v1: steps of basic refinement; each makes four quads of one")
      ->check(CLI::Range(1, 6));
  command
      .add_option("--search", arguments.search,
                  "v1: how the best division of faces is searched for: optimal or greedy")
      ->check(CLI::IsMember(choice_words<SplitSearch>()));
  command.add_flag("--approximate", arguments.approximate,
                   "v1 with Catmull-Clark: the surface passes the curves by, as in the thesis");
}

void check_model_surface_arguments(const CLI::App& command, const ModelSurfaceArguments& arguments) {
  const auto is_given = [&](const char* name) { return command.get_option(name)->count() > 0; };
  if (arguments.method != "v1") {
    for (const char* name : {"--scheme", "--refinements", "--search", "--approximate"})
      if (is_given(name))
        throw CLI::ValidationError(name, concat("belongs to --method v1, not to ", arguments.method,
                                                "; leave it out or add --method v1"));
    return;
  }
  if (is_given("--splits"))
    throw CLI::ValidationError("--splits", "belongs to --method v2; with v1 use --refinements");
  if (!ends_in_catmull_clark(parse_choice<FinalScheme>(arguments.scheme))) {
    if (is_given("--step"))
      throw CLI::ValidationError("--step",
                                 concat("writes the limit surface of Catmull-Clark; ", arguments.scheme,
                                        " has no B-splines as its limit. Use --scheme catmull-clark or "
                                        "nulissmod+catmull-clark"));
    if (arguments.approximate)
      throw CLI::ValidationError("--approximate",
                                 concat("belongs to schemes that end in catmull-clark; ", arguments.scheme,
                                        " goes through the curves in any case"));
  }
  if (arguments.scheme == "nulissmod+catmull-clark" && arguments.levels < 1)
    throw CLI::ValidationError(
        "--levels",
        "must be 1 or more with --scheme nulissmod+catmull-clark, whose first level is NULISSmod");
}

ModelSurfaceOptions model_surface_options(const ModelSurfaceArguments& arguments) {
  ModelSurfaceOptions options;
  options.method = parse_choice<ModelSurfaceMethod>(arguments.method);
  options.diffusion.splits = arguments.splits;
  options.levels = arguments.levels;
  options.coons.search = parse_choice<SplitSearch>(arguments.search);
  options.coons.scheme = parse_choice<FinalScheme>(arguments.scheme);
  options.coons.steps = arguments.refinements;
  options.coons.through_curves = !arguments.approximate;
  return options;
}

Json figures_json(const ModelSurface& surface) {
  Json figures = Json::object();
  if (surface.division) {
    const FaceDivision& division = *surface.division;
    figures["base_triangles"] = division.n_triangles;
    figures["base_quads"] = division.n_quads;
    figures["divided_faces"] = division.n_divided;
    figures["diagonals"] = division.n_diagonals;
    figures["division"] = {{"flaws", division.cost.flaws},
                           {"planarity", division.cost.planarity},
                           {"shape", division.cost.shape}};
    figures["quads"] = surface.n_quads;
  } else {
    figures["quads"] = surface.n_quads;
    figures["last_move"] = surface.last_move;
    figures["not_smoothed"] = faces_json(surface.not_smoothed);
    figures["filled_as_plates"] = faces_json(surface.filled_as_plates);
    figures["filled_as_membranes"] = faces_json(surface.filled_as_membranes);
  }
  if (surface.soundness) {
    figures["crossing_pairs"] = surface.soundness->crossing_pairs;
    figures["turned_triangles"] = surface.soundness->turned_triangles;
    figures["broken_faces"] = faces_json(surface.soundness->broken_faces);
  }
  return figures;
}

Json continuity_json(const ModelContinuity& continuity, double diameter) {
  Json json = {{"smooth", nullptr}, {"corners", nullptr}, {"sharp", nullptr}, {"curves", Json::array()}};
  if (continuity.smooth.n_samples > 0) {
    json["smooth"] = figures_of(continuity.smooth, diameter);
    json["smooth"]["worst_curve"] = concat("c", continuity.worst_curve);
  }
  if (continuity.corners.n_samples > 0) json["corners"] = figures_of(continuity.corners, diameter);
  if (continuity.sharp.n_samples > 0) json["sharp"] = figures_of(continuity.sharp, diameter);
  for (const ModelContinuity::CurveEntry& entry : continuity.curves) {
    Json figures = {{"id", concat("c", entry.curve)}, {"sharpness", entry.sharpness}};
    figures.update(figures_of(entry.figures, diameter));
    json["curves"].push_back(std::move(figures));
  }
  return json;
}

}  // namespace batten::cli
