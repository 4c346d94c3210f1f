#include "surface_arguments.hpp"

#include "uncertainty_figures.hpp"

#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten::cli {

void check_surface_output(const SurfaceArguments& arguments) {
  if (!is_cad_file(arguments.output))
    mesh_format(arguments.output);
  else
    require_step();
}

void report_surface(const SurfaceArguments& arguments, NetworkSurface surface, const CurveNetwork& network,
                    const Context& context, Outcome& outcome) {
  outcome.times.add(surface.times);
  outcome.warnings.insert(outcome.warnings.end(), surface.warnings.begin(), surface.warnings.end());
  const std::string unit = !arguments.unit.empty() ? arguments.unit
                           : network.unit.empty()  ? "m"
                                                   : network.unit;
  const bool is_written = surface.is_sound() || arguments.accept_flaws;
  if (is_written && is_cad_file(arguments.output)) {
    write_step(arguments.output, surface.mesh, surface.patch_of_triangle, network, unit, arguments.step,
               context, outcome);
  } else if (is_written) {
    const ScopedStage stage(outcome.times, "write");
    MeshWriteOptions options;
    if (has_unit(mesh_format(arguments.output))) options.metres_per_unit = metres_per_unit(unit);
    write_mesh(arguments.output, surface.mesh, options);
    for (const std::string& loss : losses_in_format(surface.mesh, mesh_format(arguments.output)))
      if (surface.mesh.vertex_values.count("uncertainty") > 0)
        outcome.warnings.push_back(concat(arguments.output, ": ", loss));
  }
  const MeshTopology& topology = surface.topology;
  const MeshQuality& quality = surface.quality;
  const auto genus = topology.genus();
  commands::append(commands::figures_of(arguments, surface), outcome.figures);
  outcome.figures["written"] = is_written;
  outcome.figures["output"] = arguments.output;

  outcome.lines.push_back(concat(arguments.output, ": ", topology.n_vertices, " vertices, ",
                                 topology.n_triangles, " triangles over ", surface.n_cycles, " patches"));
  outcome.lines.push_back(topology.n_boundary_loops == 0
                              ? concat("closed surface of genus ", genus.value_or(0))
                              : concat("open surface with ", topology.n_boundary_loops, " boundary loops"));
  outcome.lines.push_back(concat(surface.rebuilds, " rebuilds of the Laplacian; smallest angle ",
                                 degrees(quality.min_angle), " degrees; ", surface.folded_triangles,
                                 " folded, ", surface.degenerate_triangles, " degenerate, ",
                                 surface.crossing_pairs, " crossing triangles"));
  if (const auto found = surface.mesh.vertex_values.find("uncertainty");
      found != surface.mesh.vertex_values.end())
    report_uncertainty(surface.mesh.positions, found->second, outcome);
  report_flaws(surface.flaws, "the surface is not sound", arguments.output, arguments.accept_flaws, outcome);
  outcome.exhibit.network = network;
  outcome.exhibit.mesh = std::move(surface.mesh);
}

void add_surface_options(CLI::App& command, SurfaceArguments& arguments) {
  command
      .add_option("-o,--output", arguments.output,
                  "Mesh to write: .ply, .obj, .off, .stl, .glb or .3mf; or CAD faces: .step, .iges")
      ->required();
  command
      .add_option("--rebuilds", arguments.rebuilds,
                  "Rebuilds of the Laplacian from the solved mesh: auto, or 0 to 20")
      ->check(parses("auto|NUMBER", [](const std::string& text) { commands::parse_rebuilds(text); }));
  command
      .add_option("--method", arguments.method,
                  "curvature (default), or a baseline: harmonic, biharmonic, triharmonic, biharmonic-normals")
      ->check(CLI::IsMember(choice_words<SurfaceMethod>()));
  command
      .add_option("--constraints", arguments.constraints,
                  "hard: through the curves exactly; soft: near them, for noisy curves")
      ->check(CLI::IsMember({"hard", "soft"}));
  command.add_option("--soft-weight", arguments.soft_weight, "Weight of soft constraints; no unit")
      ->check(CLI::PositiveNumber);
  command.add_option("--map", arguments.map, "Plane layout of patches: plane, circle, polygon")
      ->check(CLI::IsMember(choice_words<PatchMap>()));
  command
      .add_option("--base-order", arguments.base_order,
                  "Power of the Laplacian of the base geometry: 1, 2, 3")
      ->check(CLI::Range(1, 3));
  command
      .add_option(
          "--edge-length", arguments.edge_length,
          "Length of edges inside patches (2mm, 0.05, 1.5%); auto: 0.71 of the mean edge of the curves")
      ->check(parses("auto|LENGTH", [](const std::string& text) {
        if (text != "auto" && parse_length(text).value <= 0)
          throw InvalidInput("--edge-length must be positive: " + text);
      }));
  add_step_options(command, arguments.step);
  command
      .add_option("--unit", arguments.unit,
                  "Unit of the numbers, for .step, .iges, .glb and .3mf; that of the input, else m")
      ->check(parses("UNIT", [](const std::string& text) { metres_per_unit(text); }));
  command
      .add_option("--max-triangles", arguments.max_triangles,
                  "Refuse surfaces that would have more triangles than this")
      ->check(CLI::PositiveNumber);
  command.add_flag("--accept-flaws", arguments.accept_flaws,
                   "Write a surface that crosses itself, folds, collapses or leaves its curves");
}

}  // namespace batten::cli
