#include "command.hpp"
#include "model_file.hpp"

#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/pipeline/repaired_mesh.hpp"

namespace batten::cli {

namespace {

struct RepairArguments {
  std::string input, output, weld = "auto", fill_holes = "0";
  bool orient = false, accept_flaws = false;
};

/// Edges of the largest hole that is filled. @throws InvalidInput on anything but all and a number.
int parse_fill_holes(const std::string& text) {
  long value = 0;
  if (text == "all") return kAllHoles;
  if (!parse_integer(text, value) || value < 0 || value > kAllHoles || (value > 0 && value < 3))
    throw InvalidInput(concat("--fill-holes must be all, 0 or a number of edges from 3 on, got ", text));
  return static_cast<int>(value);
}

void set_weld(const std::string& text, RepairedMeshOptions& options) {
  options.weld = text != "off";
  if (text == "auto" || text == "off") return;
  options.weld_length = parse_length(text);
  if (!(options.weld_length->value >= 0)) throw InvalidInput("--weld must be at least 0: " + text);
}

Json figures_of(const RepairedMesh& repaired) {
  const MendingReport& mended = repaired.mended;
  Json done = Json::object();
  done["welded_vertices"] = mended.welded;
  done["repeated_corners"] = mended.repeated;
  done["degenerate_faces"] = mended.degenerate;
  done["doubled_faces"] = mended.doubled;
  done["t_junctions"] = mended.junctions;
  done["non_manifold_edges"] = mended.branching;
  done["split_vertices"] = mended.split_vertices;
  done["cut_edges"] = mended.cut;
  done["turned_faces"] = mended.turned;
  done["unused_vertices"] = mended.unused;
  done["crossings_removed"] = repaired.crossings_removed;
  done["holes_filled"] = repaired.n_filled();
  return done;
}

Outcome run_repair(const RepairArguments& arguments, Context& context) {
  Outcome outcome;
  mesh_format(arguments.output);
  RepairedMeshOptions options;
  set_weld(arguments.weld, options);
  options.orient = arguments.orient;
  options.fill_holes = parse_fill_holes(arguments.fill_holes);
  MeshFile input;
  {
    const ScopedStage stage(outcome.times, "read");
    input = read_mesh_file(arguments.input, &outcome.warnings);
  }
  const TriangleMesh& mesh = input.mesh;
  RepairedMesh repaired;
  try {
    repaired = repaired_mesh(mesh, options, context.progress);
  } catch (const InvalidInput& problem) {
    throw InvalidInput(concat(arguments.input, ": ", problem.what()));
  }
  add_run(repaired.times, repaired.warnings, outcome);
  const bool is_written = repaired.flaws.empty() || arguments.accept_flaws;
  if (is_written) {
    const ScopedStage stage(outcome.times, "write");
    write_made_mesh(arguments.output, repaired.mesh, input, false, outcome);
  }
  Json& figures = outcome.figures;
  figures["vertices"] = repaired.mesh.n_vertices();
  figures["faces"] = repaired.mesh.n_triangles();
  figures["input_vertices"] = mesh.n_vertices();
  figures["input_faces"] = mesh.n_triangles();
  figures["components"] = repaired.topology.n_components;
  figures["watertight"] = repaired.topology.is_watertight();
  figures["volume"] = repaired.volume ? Json(*repaired.volume) : Json(nullptr);
  figures["weld_tolerance"] = repaired.mended.tolerance;
  figures["done"] = figures_of(repaired);
  Json holes = Json::array();
  for (const MeshHole& hole : repaired.holes)
    if (!hole.filled) holes.push_back({{"edges", hole.rim.size()}, {"vertex", hole.rim[0]}});
  figures["holes"] = holes;
  Json crossings = Json::array();
  for (const auto& [f, g] : repaired.crossings) crossings.push_back({f, g});
  figures["crossings"] = crossings;
  figures["flaws"] = repaired.flaws;
  figures["written"] = is_written;

  for (const std::string& line : repaired.done) outcome.lines.push_back(line);
  if (repaired.done.empty()) outcome.lines.emplace_back("nothing to repair");
  if (!holes.empty() && options.fill_holes == 0)
    outcome.lines.push_back(concat(holes.size(), holes.size() == 1 ? " border is" : " borders are",
                                   " left; --fill-holes N fills those of up to N edges"));
  if (is_written)
    outcome.lines.push_back(concat("wrote ", arguments.output, ": ", repaired.mesh.n_vertices(),
                                   " vertices, ", repaired.mesh.n_triangles(), " triangles",
                                   repaired.topology.is_watertight() ? ", closed" : ""));
  report_flaws(repaired.flaws, concat("not all of ", arguments.input, " could be repaired"), arguments.output,
               arguments.accept_flaws, outcome);
  return outcome;
}

}  // namespace

void add_repair(CLI::App& app) {
  auto arguments = std::make_shared<RepairArguments>();
  CLI::App* command = add_command(app, "repair", "Mend a mesh: weld, orient, separate sheets, fill holes.",
                                  "batten repair broken.stl -o sound.ply --fill-holes 50",
                                  [arguments](Context& context) { return run_repair(*arguments, context); });
  command->add_option("IN", arguments->input, "Mesh: PLY, OBJ, OFF or STL")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write; the extension decides the format")
      ->required();
  command
      ->add_option("--weld", arguments->weld,
                   "Weld borders that lie within this distance: auto, 0.01mm, 0.001% of the diameter, or off")
      ->check(parses("auto|LENGTH|off", [](const std::string& text) {
        RepairedMeshOptions options;
        set_weld(text, options);
      }));
  command->add_flag("--orient", arguments->orient,
                    "Turn closed parts outward, and inward those that lie within another");
  command
      ->add_option("--fill-holes", arguments->fill_holes,
                   "Fill holes of up to N edges by fair surfaces, or all of them; 0 fills none")
      ->check(parses("N|all", [](const std::string& text) { parse_fill_holes(text); }));
  command->add_flag("--accept-flaws", arguments->accept_flaws,
                    "Write the result although not all could be repaired");
}

}  // namespace batten::cli
