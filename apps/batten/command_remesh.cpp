#include "command.hpp"
#include "commands/remesh.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/remeshed_mesh.hpp"

namespace batten::cli {

namespace {

struct RemeshArguments : commands::RemeshArguments {
  std::string in, out;
};

Outcome run_remesh(const RemeshArguments& arguments, Context& context) {
  Outcome outcome;
  mesh_format(arguments.out);
  MeshFile input;
  {
    const ScopedStage stage(outcome.times, "read");
    input = read_mesh_to_process(arguments.in, outcome.warnings, arguments.repair, context.progress);
  }
  const TriangleMesh& mesh = input.mesh;
  const RemeshedMesh result =
      remeshed_mesh(mesh, options_of(arguments, mesh, arguments.in), context.progress);
  add_run(result.times, result.warnings, outcome);
  const bool is_written = result.flaws.empty() || arguments.accept_flaws;
  if (is_written) {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.out, result.mesh, input, false, outcome);
  }
  const RemeshMeasures& measures = result.measures;
  const MeshQuality& quality = result.quality;
  outcome.figures = commands::figures_of(result);
  outcome.lines.push_back(concat(arguments.out, ": ", result.mesh.n_vertices(), " vertices, ",
                                 result.mesh.n_triangles(), " triangles after ", result.report.iterations,
                                 " rounds; ", result.report.feature_edges, " edges kept"));
  outcome.lines.push_back(concat("smallest angles ", degrees(quality.mean_min_angle),
                                 " degrees in the mean, ", degrees(quality.min_angle),
                                 " at the least; normals off by ", degrees(measures.normal_error),
                                 " degrees, mean curvature by ", 100 * measures.curvature_change, " %"));
  report_flaws(result.flaws, concat("the new triangles do not stand for ", arguments.in), arguments.out,
               arguments.accept_flaws, outcome);
  return outcome;
}

}  // namespace

void add_remesh(CLI::App& app) {
  auto arguments = std::make_shared<RemeshArguments>();
  CLI::App* command = add_command(app, "remesh", "Replace the triangles of a surface by better ones.",
                                  "batten remesh part.obj -o even.ply --edge 2mm --adaptivity 0",
                                  [arguments](Context& context) { return run_remesh(*arguments, context); });
  command->add_option("IN", arguments->in, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->out, "Mesh to write; the extension decides the format")
      ->required();
  CLI::Option* edge =
      command
          ->add_option("--edge", arguments->edge,
                       "Edge length: 0.05, 2mm or 1.6% of the diameter; by default that of the input")
          ->check(parses("LENGTH", [](const std::string& text) {
            if (!(parse_length(text).value > 0)) throw InvalidInput("--edge must be positive: " + text);
          }));
  command->add_option("--vertices", arguments->vertices, "Number of vertices, instead of an edge length")
      ->check(CLI::Range(4, 100000000))
      ->excludes(edge);
  command->add_option("--adaptivity", arguments->adaptivity, "0: even; 1: as fine as curvature asks")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--keep-edges", arguments->keep_edges, "Keep edges sharper than this angle")
      ->check(parses("ANGLE", [](const std::string& text) {
        const double angle = parse_angle(text);
        if (!(angle > 0 && angle <= kPi + 1e-9))
          throw InvalidInput("--keep-edges must lie above 0 and at most at 180deg: " + text);
      }));
  command
      ->add_option("--keep-border", arguments->keep_border,
                   "curve: border vertices move along the border; exact: they all stay, so that tiles join")
      ->check(CLI::IsMember({"curve", "exact"}));
  command->add_option("--method", arguments->method, "ar: adaptive remeshing; lf: Laplacian flow")
      ->check(CLI::IsMember(choice_words<RemeshMethod>()));
  command->add_option("--sizes", arguments->sizes,
                      "Value per vertex of a PLY file that holds the wanted edge lengths");
  command->add_option("--iterations", arguments->iterations, "Most rounds")->check(CLI::Range(1, 1000));
  add_repair_flag(*command, arguments->repair);
  command->add_flag("--accept-flaws", arguments->accept_flaws,
                    "Write the result even where it crosses itself or misses surface or size, exit with 0");
}

}  // namespace batten::cli
