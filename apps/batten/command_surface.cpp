#include "command.hpp"

#include <memory>
#include <set>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::cli {

namespace {

struct SurfaceArguments {
  std::string input, output, rebuilds = "auto", method = "curvature", constraints = "hard", map = "plane";
  std::string edge_length = "auto";
  double soft_weight = 1;
  int base_order = 2;
};

template <typename Value>
Value chosen_value(const std::string& text, std::initializer_list<std::pair<const char*, Value>> choices) {
  for (const auto& [name, value] : choices)
    if (text == name) return value;
  throw CLI::ValidationError(text, "is not one of the choices");
}

int parse_rebuilds(const std::string& text) {
  long value = 0;
  if (text == "auto") return -1;
  if (!parse_integer(text, value) || value < 0 || value > 20)
    throw CLI::ValidationError("--rebuilds", "takes auto or 0 to 20, got " + text);
  return static_cast<int>(value);
}

/// What a surface is as a whole.
struct Topology {
  long vertices = 0, edges = 0, faces = 0, components = 0, boundary_loops = 0;
  long euler() const { return vertices - edges + faces; }
  /// Σ (2 − 2g − b) = χ over the components.
  long genus() const { return components - (euler() + boundary_loops) / 2; }
};

Topology topology_of(const TriangleMesh& mesh) {
  Topology t;
  t.faces = static_cast<long>(mesh.n_triangles());
  const std::vector<int> opposite = opposite_half_edges(mesh.triangles);
  std::vector<int> parent(static_cast<std::size_t>(mesh.n_vertices()));
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<int>(v);
  const auto root = [&parent](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<char> used(parent.size(), 0);
  std::vector<int> next_on_border(parent.size(), -1);
  for (std::size_t h = 0; h < opposite.size(); ++h) {
    const auto f = static_cast<Eigen::Index>(h / 3);
    const int a = mesh.triangles(f, (h + 1) % 3), b = mesh.triangles(f, (h + 2) % 3);
    used[a] = used[b] = 1;
    parent[root(a)] = root(b);
    if (opposite[h] < 0) next_on_border[a] = b;
    if (opposite[h] < 0 || opposite[h] > static_cast<int>(h)) ++t.edges;
  }
  for (std::size_t v = 0; v < parent.size(); ++v) {
    t.vertices += used[v];
    if (used[v] && parent[v] == static_cast<int>(v)) ++t.components;
  }
  for (std::size_t v = 0; v < parent.size(); ++v) {
    if (next_on_border[v] < 0) continue;
    ++t.boundary_loops;
    for (int w = static_cast<int>(v); next_on_border[w] >= 0;) {
      const int next = next_on_border[w];
      next_on_border[w] = -1;
      w = next;
    }
  }
  return t;
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

Outcome run_surface(const SurfaceArguments& arguments, Context& context) {
  Outcome outcome;
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
  mesh_format(arguments.output);  // an unknown extension fails before the work, not after it

  CurveNetwork network;
  {
    const ScopedStage stage(outcome.times, "read");
    network = read_network(arguments.input, &outcome.warnings);
  }
  if (arguments.edge_length != "auto")
    options.edge_length =
        parse_length(arguments.edge_length).in_file_units(bounding_box_diagonal(network.positions));
  SurfaceResult surface = surface_network(network, options, context.progress);
  outcome.times.add(surface.times);
  outcome.warnings.insert(outcome.warnings.end(), surface.warnings.begin(), surface.warnings.end());
  const TriangleMesh mesh = without_loose_vertices(surface.mesh);

  Topology topology;
  MeshQuality quality;
  std::size_t intersections = 0;
  {
    const ScopedStage stage(outcome.times, "check");
    topology = topology_of(mesh);
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
  Json& figures = outcome.figures;
  figures["curves"] = network.curves.size();
  figures["nodes"] = nodes.nodes.size();
  figures["segments"] = nodes.segments.size();
  figures["cycles"] = surface.n_cycles;
  figures["components"] = topology.components;
  figures["boundary_loops"] = topology.boundary_loops;
  figures["vertices"] = topology.vertices;
  figures["faces"] = topology.faces;
  figures["genus"] = topology.genus();
  figures["euler_characteristic"] = topology.euler();
  figures["watertight"] = topology.boundary_loops == 0;
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

  outcome.lines.push_back(concat(arguments.output, ": ", topology.vertices, " vertices, ", topology.faces,
                                 " triangles over ", surface.n_cycles, " patches"));
  outcome.lines.push_back(topology.boundary_loops == 0
                              ? concat("closed surface of genus ", topology.genus())
                              : concat("open surface with ", topology.boundary_loops, " boundary loops"));
  outcome.lines.push_back(concat(surface.rebuilds, " rebuilds of the Laplacian; smallest angle ",
                                 degrees(quality.min_angle), " degrees; ", surface.folded_triangles,
                                 " folded, ", surface.degenerate_triangles, " degenerate, ", intersections,
                                 " crossing triangles"));
  return outcome;
}

}  // namespace

void add_surface(CLI::App& app) {
  auto arguments = std::make_shared<SurfaceArguments>();
  CLI::App* command = add_command(app, "surface", "Fill a curve network with a fair surface.",
                                  "batten surface net.net -o surface.ply",
                                  [arguments](Context& context) { return run_surface(*arguments, context); });
  command->add_option("network", arguments->input, "Network with normals: .net, .obj or .json")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write: .ply, .obj, .off or .stl")
      ->required();
  command
      ->add_option("--rebuilds", arguments->rebuilds,
                   "Rebuilds of the Laplacian from the solved mesh: auto, or 0 to 20")
      ->check([](const std::string& text) {
        try {
          parse_rebuilds(text);
        } catch (const CLI::ValidationError& error) {
          return std::string(error.what());
        }
        return std::string();
      });
  command
      ->add_option(
          "--method", arguments->method,
          "curvature (default), or a baseline: harmonic, biharmonic, triharmonic, biharmonic-normals")
      ->check(CLI::IsMember({"curvature", "harmonic", "biharmonic", "triharmonic", "biharmonic-normals"}));
  command
      ->add_option("--constraints", arguments->constraints,
                   "hard: through the curves exactly; soft: near them, for noisy curves")
      ->check(CLI::IsMember({"hard", "soft"}));
  command->add_option("--soft-weight", arguments->soft_weight, "Weight of soft constraints; no unit")
      ->check(CLI::PositiveNumber);
  command->add_option("--map", arguments->map, "Plane layout of patches: plane, circle, polygon")
      ->check(CLI::IsMember({"plane", "circle", "polygon"}));
  command
      ->add_option("--base-order", arguments->base_order,
                   "Power of the Laplacian of the base geometry: 1, 2, 3")
      ->check(CLI::Range(1, 3));
  command
      ->add_option(
          "--edge-length", arguments->edge_length,
          "Length of edges inside patches (2mm, 0.05, 1.5%); auto: 0.71 of the mean edge of the curves")
      ->check([](const std::string& text) {
        if (text == "auto") return std::string();
        try {
          return parse_length(text).value > 0 ? std::string() : "--edge-length must be positive: " + text;
        } catch (const InvalidInput& error) {
          return std::string(error.what());
        }
      });
}

}  // namespace batten::cli
