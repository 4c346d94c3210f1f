#include "step_output.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten::cli {

void add_step_options(CLI::App& command, StepArguments& arguments) {
  command
      .add_option("--step-tolerance", arguments.tolerance,
                  "CAD: distance of the faces from the surface to reach, of the diameter")
      ->check(parses("PERCENT", [](const std::string& text) {
        if (!(parse_fraction(text) > 0)) throw InvalidInput("--step-tolerance must be above 0, got " + text);
      }));
  command
      .add_option("--max-patches", arguments.max_patches,
                  "CAD: refuse surfaces that would take more faces than this")
      ->check(CLI::PositiveNumber);
}

bool is_cad_file(const std::string& path, std::string_view standard) {
  return cad_format(output_extension(path, standard)).has_value();
}

CadFormat cad_format_of(const std::string& path) {
  const auto format = cad_format(output_extension(path, "step"));
  if (!format)
    throw UnknownExtension(path, "is no CAD file by its extension; use .step or .stp, .iges or .igs");
  return *format;
}

void write_step(const std::string& path, const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                const CurveNetwork& network, const std::string& unit, const StepArguments& arguments,
                const Context& context, Outcome& outcome) {
  StepSurfaceOptions options;
  options.faces.tolerance = parse_fraction(arguments.tolerance);
  options.faces.most_patches = arguments.max_patches;
  options.step.millimetres_per_unit = 1000 * metres_per_unit(unit);
  options.format = cad_format_of(path);
  options.network = &network;
  const StepSurface cad = step_surface(mesh, patch_of_triangle, options, context.progress);
  add_run(cad.times, cad.warnings, outcome);
  if (!cad.flaws.empty()) {
    outcome.failure = concat(cad.flaws.front(), "; ", path, " is not written");
  } else {
    const ScopedStage stage(outcome.times, "write");
    write_file(path, cad.text);
  }
  const BsplineSurface& faces = cad.faces.surface;
  const double deviation = faces.deviation / cad.diameter;
  Json figures = Json::object();
  figures["faces"] = faces.patches.size();
  figures["edges"] = faces.edges.size();
  figures["sharp_edges"] = cad.faces.n_sharp;
  figures["solids"] = faces.is_closed ? faces.n_components : 0;
  figures["unit"] = unit;
  figures["deviation"] = faces.deviation;
  figures["relative_deviation"] = deviation;
  figures["rms_deviation"] = cad.faces.rms_deviation;
  figures["normal_jump_deg"] = degrees(faces.normal_jump);
  figures["bytes"] = cad.text.size();
  outcome.figures["step"] = figures;
  if (cad.flaws.empty())
    outcome.lines.push_back(concat(path, ": ", faces.patches.size(), " B-spline faces, ",
                                   faces.is_closed ? "closed" : "open", "; within ", 100 * deviation,
                                   " % of the diameter, normals at smooth edges within ",
                                   degrees(faces.normal_jump), " degrees"));
}

}  // namespace batten::cli
