#include "batten/pipeline/network_surface.hpp"

#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/pipeline/surface_flaws.hpp"
#include "batten/pipeline/surface_uncertainty.hpp"
#include "batten/strokes/mended_network.hpp"

namespace batten {

namespace {

/// The mesh without vertices that no triangle uses (samples of the network that lie on no curve).
TriangleMesh without_loose_vertices(TriangleMesh mesh, std::vector<char>& on_network) {
  std::vector<int> number(at(mesh.n_vertices()), -1);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) number[at(mesh.triangles(f, k))] = 0;
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
      on_network[at(number[v])] = on_network[v];
    }
  for (const auto& [name, values] : mesh.vertex_values) {
    Eigen::VectorXd& kept = packed.vertex_values[name];
    kept.resize(n);
    for (std::size_t v = 0; v < number.size(); ++v)
      if (number[v] >= 0) kept[number[v]] = values[static_cast<Eigen::Index>(v)];
  }
  on_network.resize(at(n));
  packed.triangles = mesh.triangles.unaryExpr([&](int v) { return number[at(v)]; });
  return packed;
}

SurfaceOptions surface_options(const NetworkSurfaceOptions& options, double diameter) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  SurfaceOptions surface = options.surface;
  if (options.edge_length) surface.edge_length = options.edge_length->in_file_units(diameter);
  return surface;
}

NetworkSurface checked(SurfaceResult surface, const CurveNetwork& network, const Progress& progress) {
  NetworkSurface result;
  result.times = std::move(surface.times);
  result.warnings = std::move(surface.warnings);
  result.n_cycles = surface.n_cycles;
  result.rebuilds = surface.rebuilds;
  result.last_move = surface.last_move;
  result.patches_in_space = surface.patches_in_space;
  result.folded_triangles = surface.folded_triangles;
  result.degenerate_triangles = surface.degenerate_triangles;
  result.patch_of_triangle = std::move(surface.patch_of_triangle);
  std::vector<char> on_network = std::move(surface.on_network);
  result.mesh = without_loose_vertices(std::move(surface.mesh), on_network);
  {
    const ScopedStage stage(result.times, "check");
    progress.report("check", 0);
    result.topology = mesh_topology(result.mesh.triangles, result.mesh.n_vertices());
    progress.report("check", 0.2);
    result.quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
    const auto crossings = self_intersections(result.mesh.positions, result.mesh.triangles,
                                              kMostListedIntersections, progress.part("check", 0.3, 0.9));
    result.crossing_pairs = crossings.size();
    result.flaws =
        surface_flaws(result.mesh, {result.patch_of_triangle, on_network, surface.folded, crossings});
  }
  const NetworkTopology topology = network_topology(network);
  result.n_curves = network.curves.size();
  result.n_nodes = topology.nodes.size();
  result.n_segments = topology.segments.size();
  result.diameter = bounding_box_diagonal(network.positions);
  return result;
}

}  // namespace

std::optional<std::string> NetworkSurfaceOptions::problem() const {
  if (edge_length && !(edge_length->value > 0 && std::isfinite(edge_length->value)))
    return concat("edge_length must be positive, got ", edge_length->value);
  return surface.problem();
}

NetworkSurface network_surface(const CurveNetwork& network, const NetworkSurfaceOptions& options,
                               const Progress& progress) {
  const SurfaceOptions surface = surface_options(options, bounding_box_diagonal(network.positions));
  return checked(surface_network(network, surface, progress), network, progress);
}

NetworkSurface network_surface(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                               const NetworkSurfaceOptions& options, const Progress& progress) {
  const SurfaceOptions surface = surface_options(options, bounding_box_diagonal(network.positions));
  SurfaceResult filled = surface_network(network, cycles, surface, progress);
  FlatteningReport flattening;
  if (options.flatten_crossings) flattening = flatten_crossing_patches(filled, progress);
  NetworkSurface result = checked(std::move(filled), network, progress);
  result.flattening = std::move(flattening);
  return result;
}

NetworkSurface uncertain_surface(const CurveNetwork& network, const NetworkUncertainty& of_network,
                                 const NetworkSurfaceOptions& options, const Progress& progress) {
  SurfaceSolver solver(network, surface_options(options, bounding_box_diagonal(network.positions)), progress);
  SurfaceResult surface = solver.result();
  {
    const ScopedStage stage(surface.times, "uncertainty");
    surface.mesh.vertex_values["uncertainty"] =
        surface_uncertainty(solver, network, of_network, progress).deviations;
  }
  return checked(std::move(surface), network, progress);
}

CurvesSurface curves_surface(const CurveNetwork& curves, const StrokeNetworkOptions& strokes,
                             const NetworkSurfaceOptions& options, const Progress& progress) {
  CurvesSurface result;
  if (curves.has_normals()) {
    NetworkMendingOptions mending;
    mending.weld_tolerance = strokes.weld_tolerance;
    MendedNetwork mended = mended_network(curves, mending);
    result.network = std::move(mended.network);
    result.surface = network_surface(result.network, options, progress);
    result.surface.warnings.insert(result.surface.warnings.begin(), mended.warnings.begin(),
                                   mended.warnings.end());
    return result;
  }
  result.strokes = stroke_network(curves, strokes, progress);
  result.network = result.strokes->network;
  result.surface = network_surface(result.network, result.strokes->estimate.cycles, options, progress);
  return result;
}

}  // namespace batten
