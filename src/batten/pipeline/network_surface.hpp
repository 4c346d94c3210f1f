#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/scan/uncertainty.hpp"
#include "batten/strokes/stroke_network.hpp"
#include "batten/surfacing/flattening.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {

/// Options of network_surface() and curves_surface(). The defaults are those of `batten surface`.
struct NetworkSurfaceOptions {
  SurfaceOptions surface;
  /// Length of edges inside patches, above 0; relative: of the diameter of the network. Nothing: what
  /// `surface.edge_length` says.
  std::optional<Length> edge_length;
  /// Of stroke sets alone, whose normals are estimated: patches that would cross others or fold are filled
  /// flatter (flatten_crossing_patches()). Costs a search for crossings for every patch that is tried.
  bool flatten_crossings = true;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A surface through a network, checked. Lengths in the unit of the network.
struct NetworkSurface {
  TriangleMesh mesh;  ///< with the propagated normals; without vertices that no triangle uses
  std::vector<int> patch_of_triangle;                     ///< the cycle that each triangle fills
  std::size_t n_curves = 0, n_nodes = 0, n_segments = 0;  ///< of the network
  int n_cycles = 0;
  MeshTopology topology;
  MeshQuality quality;
  double diameter = 0;
  int rebuilds = 0;                            ///< of the Laplacian, done and kept
  double last_move = 0;                        ///< see SurfaceResult
  int patches_in_space = 0;                    ///< patches that no plane map could lay out
  std::optional<FlatteningReport> flattening;  ///< where the patches were given
  int folded_triangles = 0;
  int degenerate_triangles = 0;
  std::size_t crossing_pairs = 0;  ///< pairs of triangles that cross; counted up to kMostListedIntersections
  /// Why this is no surface of its curves, with patches and places; empty for a sound one: triangles that
  /// cross or are turned over, patches that lie across the normals of their curves or far away from them.
  std::vector<std::string> flaws;
  std::vector<std::string> warnings;
  StageTimes times;

  bool is_sound() const { return flaws.empty(); }
};

/// Fills a network with a fair surface and checks it: surface_network(), packing, topology, quality,
/// crossings. @throws InvalidInput, SolverFailure, Cancelled.
NetworkSurface network_surface(const CurveNetwork& network, const NetworkSurfaceOptions& options = {},
                               const Progress& progress = {});

/// The same with patches that are known, as stroke_network() gives them; crossing patches are flattened.
NetworkSurface network_surface(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                               const NetworkSurfaceOptions& options = {}, const Progress& progress = {});

/// The same with how sure it is: the value `uncertainty` of the mesh, per vertex in the unit of the network
/// (SurfaceUncertainty::deviations). Costs a solve for every draw of the network.
NetworkSurface uncertain_surface(const CurveNetwork& network, const NetworkUncertainty& of_network,
                                 const NetworkSurfaceOptions& options = {}, const Progress& progress = {});

/// What curves became.
struct CurvesSurface {
  std::optional<StrokeNetwork> strokes;  ///< where the curves had no normals
  CurveNetwork network;                  ///< the network that was filled
  NetworkSurface surface;
};

/// The surface of any curves: a network with normals is mended (mended_network()) and filled; a stroke set
/// becomes a network with patches and normals first. @throws InvalidInput, SolverFailure, Cancelled.
CurvesSurface curves_surface(const CurveNetwork& curves, const StrokeNetworkOptions& strokes = {},
                             const NetworkSurfaceOptions& options = {}, const Progress& progress = {});

}  // namespace batten
