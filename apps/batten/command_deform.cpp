#include "command.hpp"
#include "model_file.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/deformation/multiresolution.hpp"
#include "batten/io/file.hpp"
#include "batten/io/handles_io.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/normals.hpp"

namespace batten::cli {

namespace {

struct DeformArguments {
  std::string in, out, handles, energy = "total", nonlinear = "gauss-newton";
  double soft = 0;
  int iterations = DeformOptions{}.max_iterations;
  bool multiresolution = false;
};

DeformOptions options_of(const DeformArguments& arguments) {
  DeformOptions options;
  if (arguments.energy == "stretch") options.energy = DeformationEnergy::Stretch;
  if (arguments.energy == "bend") options.energy = DeformationEnergy::Bend;
  if (arguments.energy == "combined") options.energy = DeformationEnergy::Combined;
  if (arguments.nonlinear == "none") options.detail = DetailPreservation::None;
  if (arguments.nonlinear == "shape-matching") options.detail = DetailPreservation::ShapeMatching;
  options.soft_weight = arguments.soft;
  options.max_iterations = arguments.iterations;
  return options;
}

Outcome run_deform(const DeformArguments& arguments, Context& context) {
  Outcome outcome;
  mesh_format(arguments.out);
  TriangleMesh mesh;
  Handles handles;
  {
    const ScopedStage stage(outcome.times, "read");
    mesh = read_mesh_to_process(arguments.in, outcome.warnings);
    handles = read_handles(arguments.handles, mesh.positions);
  }
  const DeformOptions options = options_of(arguments);
  std::unique_ptr<Deformer> deformer;
  std::unique_ptr<MultiresolutionDeformer> in_two;
  double curvature_term = 0;
  {
    const ScopedStage stage(outcome.times, "factorise");
    if (arguments.multiresolution) {
      MultiresolutionOptions two;
      two.deform = options;
      in_two = std::make_unique<MultiresolutionDeformer>(mesh.positions, mesh.triangles, handles.vertices(),
                                                         two, context.progress);
      curvature_term = in_two->curvature_term();
    } else {
      deformer = std::make_unique<Deformer>(mesh.positions, mesh.triangles, handles.vertices(), options);
      curvature_term = deformer->curvature_term();
    }
  }
  if (options.energy == DeformationEnergy::TotalCurvature && curvature_term < options.curvature_term)
    outcome.warnings.push_back(
        concat("the total curvature energy is indefinite on this shape: its curvature term was scaled by ",
               curvature_term));
  Deformer::Result result;
  {
    const ScopedStage stage(outcome.times, "deform");
    // A turn is made in parts of 45 degrees at most: beyond that the linear start folds the surface.
    const int parts =
        options.detail == DetailPreservation::None
            ? 1
            : std::max(1, static_cast<int>(std::ceil(handles.largest_angle() / radians(45.0) - 1e-9)));
    std::vector<Points> stages;
    for (int part = 1; part < parts; ++part)
      stages.push_back(handles.targets(mesh.positions, static_cast<double>(part) / parts));
    const Points targets = handles.targets(mesh.positions);
    if (in_two != nullptr) {
      result = in_two->deform(targets, stages, context.progress);
    } else {
      stages.push_back(targets);
      for (const Points& goal : stages) {
        const Points start = result.positions;
        result = deformer->deform(goal, start.rows() > 0 ? &start : nullptr, context.progress);
      }
    }
  }
  if (!result.report.converged)
    outcome.warnings.push_back(concat("stopped after ", result.report.iterations,
                                      " iterations while vertices still moved by ", result.report.last_move,
                                      " of the diameter; raise --iterations"));
  TriangleMesh deformed = mesh;
  deformed.positions = result.positions;
  if (mesh.normals.rows() > 0) deformed.normals = vertex_normals(deformed.positions, deformed.triangles);
  {
    const ScopedStage stage(outcome.times, "write");
    write_mesh(arguments.out, deformed);
  }
  Json& figures = outcome.figures;
  figures["vertices"] = mesh.n_vertices();
  figures["faces"] = mesh.n_triangles();
  figures["fixed"] = handles.fixed.size();
  figures["moved"] = handles.vertices().size() - handles.fixed.size();
  figures["iterations"] = result.report.iterations;
  figures["converged"] = result.report.converged;
  figures["last_move"] = result.report.last_move;
  figures["curvature_term"] = curvature_term;
  if (in_two != nullptr) figures["base_vertices"] = in_two->base().n_vertices();
  outcome.lines.push_back(concat(arguments.out, ": ", mesh.n_vertices(), " vertices, ", handles.fixed.size(),
                                 " fixed, ", handles.vertices().size() - handles.fixed.size(), " moved, ",
                                 result.report.iterations, " iterations"));
  return outcome;
}

}  // namespace

void add_deform(CLI::App& app) {
  auto arguments = std::make_shared<DeformArguments>();
  CLI::App* command =
      add_command(app, "deform", "Bend, twist and stretch a surface by handles, its detail kept.",
                  "batten deform part.ply -o bent.ply --handles handles.json",
                  [arguments](Context& context) { return run_deform(*arguments, context); });
  command->add_option("IN", arguments->in, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->out, "Mesh to write; the extension decides the format")
      ->required();
  command->add_option("--handles", arguments->handles, "What is fixed and what moves (JSON, docs/deform.md)")
      ->required();
  command->add_option("--energy", arguments->energy, "stretch, bend, combined or total (curvature)")
      ->check(CLI::IsMember({"stretch", "bend", "combined", "total"}));
  command->add_option("--nonlinear", arguments->nonlinear, "How detail turns with the surface")
      ->check(CLI::IsMember({"none", "shape-matching", "gauss-newton"}));
  command->add_option("--soft", arguments->soft, "Weight of soft handles; 0 meets them exactly")
      ->check(CLI::Range(0.0, 1e12));
  command->add_flag("--multiresolution", arguments->multiresolution,
                    "Iterate on a simplified mesh, put the detail back, finish on the mesh itself");
  command->add_option("--iterations", arguments->iterations, "Most iterations per part of the motion")
      ->check(CLI::Range(1, 100000));
}

}  // namespace batten::cli
