#include "commands/repair.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

namespace {

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

Json mended_json(const RepairedMesh& repaired) {
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

}  // namespace

RepairedMeshOptions options_of(const RepairArguments& arguments) {
  RepairedMeshOptions options;
  set_weld(arguments.weld, options);
  options.orient = arguments.orient;
  options.fill_holes = parse_fill_holes(arguments.fill_holes);
  return options;
}

Json figures_of(const TriangleMesh& input, const RepairedMesh& repaired) {
  Json figures = Json::object();
  figures["vertices"] = repaired.mesh.n_vertices();
  figures["faces"] = repaired.mesh.n_triangles();
  figures["input_vertices"] = input.n_vertices();
  figures["input_faces"] = input.n_triangles();
  figures["components"] = repaired.topology.n_components;
  figures["watertight"] = repaired.topology.is_watertight();
  figures["volume"] = repaired.volume ? Json(*repaired.volume) : Json(nullptr);
  figures["weld_tolerance"] = repaired.mended.tolerance;
  figures["done"] = mended_json(repaired);
  Json holes = Json::array();
  for (const MeshHole& hole : repaired.holes)
    if (!hole.filled) holes.push_back({{"edges", hole.rim.size()}, {"vertex", hole.rim[0]}});
  figures["holes"] = holes;
  Json crossings = Json::array();
  for (const auto& [f, g] : repaired.crossings) crossings.push_back({f, g});
  figures["crossings"] = crossings;
  figures["flaws"] = repaired.flaws;
  return figures;
}

}  // namespace batten::commands
