#include "coons_stage.hpp"

#include <map>

#include "batten/core/text.hpp"

namespace batten::cli {

namespace {

const std::map<std::string, FinalScheme>& schemes() {
  static const std::map<std::string, FinalScheme> kSchemes{
      {"catmull-clark", FinalScheme::CatmullClark},
      {"nuliss", FinalScheme::Nuliss},
      {"nulissmod", FinalScheme::NulissMod},
      {"nulissmod+catmull-clark", FinalScheme::NulissModCatmullClark}};
  return kSchemes;
}

bool ends_in_catmull_clark(const std::string& scheme) {
  return scheme == "catmull-clark" || scheme == "nulissmod+catmull-clark";
}

}  // namespace

void add_coons_options(CLI::App& command, CoonsArguments& arguments) {
  command
      .add_option("--scheme", arguments.scheme,
                  "v1: catmull-clark, nuliss, nulissmod, or nulissmod+catmull-clark: one level of the first")
      ->check(CLI::IsMember({"catmull-clark", "nuliss", "nulissmod", "nulissmod+catmull-clark"}));
  command
      .add_option("--refinements", arguments.refinements,
                  "v1: steps of basic refinement; each makes four quads of one")
      ->check(CLI::Range(1, 6));
  command
      .add_option("--search", arguments.search,
                  "v1: how the best division of faces is searched for: optimal or greedy")
      ->check(CLI::IsMember({"optimal", "greedy"}));
  command.add_flag("--approximate", arguments.approximate,
                   "v1 with Catmull-Clark: the surface passes the curves by, as in the thesis");
}

void check_coons_arguments(const CLI::App& command, const CoonsArguments& arguments,
                           const std::string& method, int levels) {
  const auto is_given = [&](const char* name) { return command.get_option(name)->count() > 0; };
  if (method != "v1") {
    for (const char* name : {"--scheme", "--refinements", "--search", "--approximate"})
      if (is_given(name))
        throw CLI::ValidationError(
            name, concat("belongs to --method v1, not to ", method, "; leave it out or add --method v1"));
    return;
  }
  if (is_given("--splits"))
    throw CLI::ValidationError("--splits", "belongs to --method v2; with v1 use --refinements");
  if (!ends_in_catmull_clark(arguments.scheme)) {
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
  if (arguments.scheme == "nulissmod+catmull-clark" && levels < 1)
    throw CLI::ValidationError(
        "--levels",
        "must be 1 or more with --scheme nulissmod+catmull-clark, whose first level is NULISSmod");
}

CoonsSurface run_coons_stage(const CoonsArguments& arguments, const PolylineMesh& mesh, int levels,
                             const Context& context, Outcome& outcome, Json& figures) {
  CoonsOptions options;
  options.search = arguments.search == "greedy" ? SplitSearch::Greedy : SplitSearch::Optimal;
  options.steps = arguments.refinements;
  options.scheme = schemes().at(arguments.scheme);
  options.levels = levels;
  options.through_curves = !arguments.approximate;
  CoonsSurface surface = coons_surface(mesh, options, context.progress);
  outcome.times.add(surface.times);
  int n_triangles = 0;
  for (const BaseFace& face : surface.base.faces) n_triangles += face.sides.size() == 3;
  const auto n_faces = static_cast<int>(surface.base.faces.size());
  figures["base_triangles"] = n_triangles;
  figures["base_quads"] = n_faces - n_triangles;
  figures["divided_faces"] = surface.base.n_divided;
  figures["diagonals"] = surface.base.n_diagonals;
  figures["division"] = {{"flaws", surface.base.cost.flaws},
                         {"planarity", surface.base.cost.planarity},
                         {"shape", surface.base.cost.shape}};
  figures["quads"] = surface.refined.mesh.n_faces();
  outcome.lines.push_back(concat("base mesh: ", n_faces - n_triangles, " quads and ", n_triangles,
                                 " triangles, ", surface.base.n_divided, " faces divided"));
  return surface;
}

Triangles triangles_of(const PolygonMesh& quads) {
  Triangles triangles(2 * quads.n_faces(), 3);
  for (Eigen::Index f = 0; f < quads.n_faces(); ++f) {
    const int* c = &quads.corners[static_cast<size_t>(4 * f)];
    triangles.row(2 * f) << c[0], c[1], c[2];
    triangles.row(2 * f + 1) << c[0], c[2], c[3];
  }
  return triangles;
}

}  // namespace batten::cli
