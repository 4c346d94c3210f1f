#include "surface_stage.hpp"

#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::cli {

namespace {

template <typename Value>
Value chosen_value(const std::string& text, std::initializer_list<std::pair<const char*, Value>> choices) {
  for (const auto& [name, value] : choices)
    if (text == name) return value;
  throw InvalidInput(text + " is not one of the choices");
}

int parse_rebuilds(const std::string& text) {
  long value = 0;
  if (text == "auto") return -1;
  if (!parse_integer(text, value) || value < 0 || value > 20)
    throw InvalidInput("--rebuilds takes auto or 0 to 20, got " + text);
  return static_cast<int>(value);
}

/// The mesh without vertices that no triangle uses (samples of the network that lie on no curve).
TriangleMesh without_loose_vertices(const TriangleMesh& mesh) {
  std::vector<int> number(static_cast<std::size_t>(mesh.n_vertices()), -1);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) number[mesh.triangles(f, k)] = 0;
  int n = 0;
  for (int& v : number)
    if (v == 0) v = n++;
  if (n == mesh.n_vertices()) return mesh;
  TriangleMesh packed;
  packed.positions.resize(n, 3);
  packed.normals.resize(n, 3);
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] >= 0) {
      packed.positions.row(number[v]) = mesh.positions.row(static_cast<Eigen::Index>(v));
      packed.normals.row(number[v]) = mesh.normals.row(static_cast<Eigen::Index>(v));
    }
  packed.triangles = mesh.triangles.unaryExpr([&](int v) { return number[v]; });
  return packed;
}

}  // namespace

void check_surface_output(const SurfaceArguments& arguments) {
  mesh_format(arguments.output);
}

void run_surface_stage(const SurfaceArguments& arguments, const CurveNetwork& network, const Context& context,
                       Outcome& outcome, const std::vector<NetworkCycle>& cycles) {
  SurfaceOptions options;
  options.rebuilds = parse_rebuilds(arguments.rebuilds);
  options.method = chosen_value<SurfaceMethod>(arguments.method,
                                               {{"curvature", SurfaceMethod::Curvature},
                                                {"harmonic", SurfaceMethod::Harmonic},
                                                {"biharmonic", SurfaceMethod::Biharmonic},
                                                {"triharmonic", SurfaceMethod::Triharmonic},
                                                {"biharmonic-normals", SurfaceMethod::BiharmonicNormals}});
  options.map = chosen_value<PatchMap>(
      arguments.map,
      {{"plane", PatchMap::Plane}, {"circle", PatchMap::Circle}, {"polygon", PatchMap::Polygon}});
  options.soft_constraints = arguments.constraints == "soft";
  options.soft_weight = arguments.soft_weight;
  options.base_order = arguments.base_order;
  check_surface_output(arguments);
  if (arguments.edge_length != "auto")
    options.edge_length =
        parse_length(arguments.edge_length).in_file_units(bounding_box_diagonal(network.positions));
  const SurfaceResult surface = cycles.empty() ? surface_network(network, options, context.progress)
                                               : surface_network(network, cycles, options, context.progress);
  outcome.times.add(surface.times);
  outcome.warnings.insert(outcome.warnings.end(), surface.warnings.begin(), surface.warnings.end());
  TriangleMesh mesh = without_loose_vertices(surface.mesh);

  MeshTopology topology;
  MeshQuality quality;
  std::size_t intersections = 0;
  {
    const ScopedStage stage(outcome.times, "check");
    topology = mesh_topology(mesh.triangles, mesh.n_vertices());
    quality = mesh_quality(mesh.positions, mesh.triangles);
    intersections = self_intersections(mesh.positions, mesh.triangles).size();
    if (intersections > 0)
      outcome.warnings.push_back(
          concat("the surface crosses itself at ", intersections,
                 " pairs of triangles; see whether its curves do, or add a curve there"));
  }
  {
    const ScopedStage stage(outcome.times, "write");
    write_mesh(arguments.output, mesh);
  }

  const NetworkTopology nodes = network_topology(network);
  const auto genus = topology.genus();
  Json& figures = outcome.figures;
  figures["curves"] = network.curves.size();
  figures["nodes"] = nodes.nodes.size();
  figures["segments"] = nodes.segments.size();
  figures["cycles"] = surface.n_cycles;
  figures["components"] = topology.n_components;
  figures["boundary_loops"] = topology.n_boundary_loops;
  figures["vertices"] = topology.n_vertices;
  figures["faces"] = topology.n_triangles;
  figures["genus"] = genus ? Json(*genus) : Json(nullptr);
  figures["euler_characteristic"] = topology.euler_characteristic;
  figures["watertight"] = topology.is_watertight();
  figures["diameter"] = bounding_box_diagonal(network.positions);
  figures["method"] = arguments.method;
  figures["rebuilds"] = surface.rebuilds;
  figures["last_move"] = surface.last_move;
  figures["patches_in_space"] = surface.patches_in_space;
  figures["folded_faces"] = surface.folded_triangles;
  figures["degenerate_faces"] = surface.degenerate_triangles;
  figures["self_intersections"] = intersections;
  figures["min_angle_deg"] = degrees(quality.min_angle);
  figures["mean_edge"] = quality.mean_edge;
  figures["output"] = arguments.output;

  outcome.lines.push_back(concat(arguments.output, ": ", topology.n_vertices, " vertices, ",
                                 topology.n_triangles, " triangles over ", surface.n_cycles, " patches"));
  outcome.lines.push_back(topology.n_boundary_loops == 0
                              ? concat("closed surface of genus ", genus.value_or(0))
                              : concat("open surface with ", topology.n_boundary_loops, " boundary loops"));
  outcome.lines.push_back(concat(surface.rebuilds, " rebuilds of the Laplacian; smallest angle ",
                                 degrees(quality.min_angle), " degrees; ", surface.folded_triangles,
                                 " folded, ", surface.degenerate_triangles, " degenerate, ", intersections,
                                 " crossing triangles"));
  outcome.exhibit.network = network;
  outcome.exhibit.mesh = std::move(mesh);
}

void add_surface_options(CLI::App& command, SurfaceArguments& arguments) {
  command.add_option("-o,--output", arguments.output, "Mesh to write: .ply, .obj, .off or .stl")->required();
  command
      .add_option("--rebuilds", arguments.rebuilds,
                  "Rebuilds of the Laplacian from the solved mesh: auto, or 0 to 20")
      ->check(parses("auto|NUMBER", [](const std::string& text) { parse_rebuilds(text); }));
  command
      .add_option("--method", arguments.method,
                  "curvature (default), or a baseline: harmonic, biharmonic, triharmonic, biharmonic-normals")
      ->check(CLI::IsMember({"curvature", "harmonic", "biharmonic", "triharmonic", "biharmonic-normals"}));
  command
      .add_option("--constraints", arguments.constraints,
                  "hard: through the curves exactly; soft: near them, for noisy curves")
      ->check(CLI::IsMember({"hard", "soft"}));
  command.add_option("--soft-weight", arguments.soft_weight, "Weight of soft constraints; no unit")
      ->check(CLI::PositiveNumber);
  command.add_option("--map", arguments.map, "Plane layout of patches: plane, circle, polygon")
      ->check(CLI::IsMember({"plane", "circle", "polygon"}));
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
}

}  // namespace batten::cli
