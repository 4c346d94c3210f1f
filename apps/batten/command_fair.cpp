#include "command.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"

namespace batten::cli {

namespace {

struct FairArguments {
  std::string input, output, method = "auto", noise = "auto";
  int iterations = 0;
  bool keep_boundary = false;
};

/// The noise in mean edge lengths; −1 for "auto". @throws InvalidInput on anything else.
double parse_noise(const std::string& text) {
  double value = -1;
  if (text != "auto" && !(parse_number(text, value) && std::isfinite(value) && value >= 0))
    throw InvalidInput(concat("--noise must be auto or a number of mean edge lengths, at least 0: ", text));
  return value;
}

Outcome run_fair(const FairArguments& arguments, Context& context) {
  Outcome outcome;
  TriangleMesh mesh;
  {
    const ScopedStage stage(outcome.times, "read");
    mesh = read_mesh_to_process(arguments.input, outcome.warnings);
    mesh_format(arguments.output);  // an extension that cannot be written is refused before the work
  }
  FairingOptions options;
  options.method = parse_fairing_method(arguments.method);
  options.noise = parse_noise(arguments.noise);
  options.iterations = arguments.iterations;
  options.keep_boundary = arguments.keep_boundary;
  FairingResult result;
  {
    const ScopedStage stage(outcome.times, "fair");
    result = fair(mesh.positions, mesh.triangles, options, context.progress);
  }
  const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  Json& figures = outcome.figures;
  figures["vertices"] = mesh.n_vertices();
  figures["faces"] = mesh.n_triangles();
  figures["components"] = topology.n_components;
  figures["boundary_loops"] = topology.n_boundary_loops;
  figures["method"] = arguments.method;
  figures["strategy"] = result.strategy;
  figures["noise"] = result.noise;
  figures["iterations"] = result.iterations;
  figures["time_step"] = result.time_step > 0 ? Json(result.time_step) : Json(nullptr);
  figures["largest_move"] = result.largest_move;
  figures["mean_normal_change_deg"] =
      degrees(mean_normal_angle(mesh.positions, result.positions, mesh.triangles));
  figures["volume_change_percent"] = nullptr;
  if (topology.is_watertight()) {
    const double before = enclosed_volume(mesh.positions, mesh.triangles);
    if (before != 0)
      figures["volume_change_percent"] =
          100 * (enclosed_volume(result.positions, mesh.triangles) / before - 1);
  }
  if (result.strategy == "none")
    outcome.warnings.push_back(concat("the mesh looks clean (noise ", result.noise,
                                      " of a mean edge) and was left as it is; --noise K overrules that"));
  if (result.solves.unconverged > 0)
    outcome.warnings.push_back(concat(
        result.solves.unconverged, result.solves.unconverged == 1 ? " refit" : " refits",
        " of the surface stopped before coming to rest (relative residual ", result.solves.residual,
        "): the result may be rougher than it could be; --noise with a smaller number makes them easier"));

  mesh.positions = result.positions;
  if (mesh.normals.rows() > 0) mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  {
    const ScopedStage stage(outcome.times, "write");
    write_mesh(arguments.output, mesh);
  }
  outcome.lines.push_back(concat("faired ", mesh.n_vertices(), " vertices, ", mesh.n_triangles(),
                                 " triangles: method ", arguments.method, ", strategy ", result.strategy));
  outcome.lines.push_back(concat("noise ", result.noise, " mean edge lengths; largest move ",
                                 result.largest_move, "; normals turned by ",
                                 figures["mean_normal_change_deg"].get<double>(), " degrees in the mean"));
  if (!figures["volume_change_percent"].is_null())
    outcome.lines.push_back(
        concat("volume changed by ", figures["volume_change_percent"].get<double>(), " %"));
  outcome.lines.push_back(concat("wrote ", arguments.output));
  return outcome;
}

}  // namespace

void add_fair(CLI::App& app) {
  auto arguments = std::make_shared<FairArguments>();
  CLI::App* command = add_command(app, "fair", "Remove noise from a mesh and keep its edges.",
                                  "batten fair scan.ply -o smooth.ply",
                                  [arguments](Context& context) { return run_fair(*arguments, context); });
  command->add_option("IN", arguments->input, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->output, "Where to write; the extension gives the format")
      ->required();
  command
      ->add_option("--method", arguments->method,
                   "How: auto chooses by itself; the others are the thesis's flows and well-known filters")
      ->check(CLI::IsMember(fairing_method_names()));
  command
      ->add_option("--noise", arguments->noise,
                   "Standard deviation of the noise in mean edge lengths, or auto to estimate it")
      ->check(parses("auto or a number", [](const std::string& text) { parse_noise(text); }));
  command
      ->add_option("--iterations", arguments->iterations, "Rounds or steps; 0 takes the method's own number")
      ->check(CLI::Range(0, 100000));
  command->add_flag("--keep-boundary", arguments->keep_boundary, "Keep border vertices in place");
}

}  // namespace batten::cli
