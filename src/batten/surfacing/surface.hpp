#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

/// How the surface is made (docs/methods.md#surfacing).
enum class SurfaceMethod {
  Curvature,          ///< S 4.5: mean curvature from propagated normals; follows positions and normals
  Harmonic,           ///< baseline LX = 0
  Biharmonic,         ///< baseline L²X = 0
  Triharmonic,        ///< baseline L³X = 0
  BiharmonicNormals,  ///< baseline (4.27): biharmonic with prescribed normals
};
constexpr auto choices_of(SurfaceMethod) {
  return choices<SurfaceMethod>("method", {{SurfaceMethod::Curvature, "curvature"},
                                           {SurfaceMethod::Harmonic, "harmonic"},
                                           {SurfaceMethod::Biharmonic, "biharmonic"},
                                           {SurfaceMethod::Triharmonic, "triharmonic"},
                                           {SurfaceMethod::BiharmonicNormals, "biharmonic-normals"}});
}

/// How the boundary of a patch is laid out in the plane before it is triangulated (S fig. 4.11).
enum class PatchMap { Plane, Circle, Polygon };
constexpr auto choices_of(PatchMap) {
  return choices<PatchMap>(
      "map", {{PatchMap::Plane, "plane"}, {PatchMap::Circle, "circle"}, {PatchMap::Polygon, "polygon"}});
}

/// Options of surface_network(). The defaults are those of the acceptance tests: one set for all networks.
struct SurfaceOptions {
  SurfaceMethod method = SurfaceMethod::Curvature;
  PatchMap map = PatchMap::Plane;
  /// Power of the Laplacian that gives the base geometry: 1, 2 or 3 (S fig. 4.12).
  int base_order = 2;
  /// Rebuilds of the Laplacian from the solved mesh; −1 lets the criterion of docs/surface.md decide.
  int rebuilds = -1;
  /// Soft constraints (4.24): vertices of the network may move. Off: they are interpolated exactly.
  bool soft_constraints = false;
  /// Weight of the soft constraints without a unit: with 1, a wave along a curve of 15 % of the diameter
  /// keeps half its height; the length goes with the weight to the power −1/3 (docs/surface.md).
  double soft_weight = 1.0;
  /// Length of the edges inside patches, in the unit of the network (areas at most half its square); 0 takes
  /// 0.71 of the mean edge around each patch.
  double edge_length = 0;
  /// More triangles than this, by an estimate before any is made, are refused: 20 million take about 20 GB.
  double max_triangles = 20e6;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A surface and how it came about.
struct SurfaceResult {
  /// Vertex i < network.positions.rows() is vertex i of the network where a curve uses it. `mesh.normals` are
  /// the propagated normals N* of (4.12b), equal to the given ones on the network.
  TriangleMesh mesh;
  std::vector<int> patch_of_triangle;  ///< the cycle that each triangle fills
  std::vector<char> on_network;        ///< per vertex: lies on a curve
  int n_cycles = 0;
  int rebuilds = 0;                   ///< rebuilds done and kept
  int patches_in_space = 0;           ///< patches that no plane map could lay out
  int folded_triangles = 0;           ///< turned away from the propagated normals; 0 in a sound surface
  std::vector<int> folded;            ///< which, ascending; of the surface as built, whatever moved since
  int degenerate_triangles = 0;       ///< with an angle below half a degree
  double last_move = 0;               ///< mean way of the vertices in the last rebuild, ÷ diameter
  std::vector<std::string> warnings;  ///< in words, with patch, curve and node
  StageTimes times;
};

/// Fills the patches of a network with one fair triangle mesh through its curves and normals (S 4.4–4.5).
/// @throws InvalidInput, SolverFailure, Cancelled.
SurfaceResult surface_network(const CurveNetwork& network, const SurfaceOptions& options = {},
                              const Progress& progress = {});

/// The same with patches that are known, as estimate_cycles() gives them: normals only shape the surface.
/// A patch that cannot be filled is left open and told in the warnings, as long as another can. Vertices of
/// different cycles may lie at one place: the patches then meet in a crease, each with its own normals, and
/// are not joined there.
/// @throws InvalidInput also when a cycle names a vertex that the network does not have.
SurfaceResult surface_network(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                              const SurfaceOptions& options = {}, const Progress& progress = {});

/// Which patches a move solves for.
enum class SurfaceReach {
  /// Those around curves that lie or look otherwise than when the surface was built; all others stay as they
  /// were built. They meet as smoothly as any two patches, and a move costs as much as those patches do.
  Touched,
  /// All: what happens in a patch is felt in its neighbours too, a tenth as much with every curve between.
  All,
};

/// What a move of SurfaceSolver solves for.
struct SurfaceMoveOptions {
  SurfaceReach reach = SurfaceReach::Touched;
  /// For while a curve is dragged: curves carry the surface with them, but its normals, the fit to their
  /// curvature and the counts of folded triangles wait for the next whole move. About a third of the time.
  bool positions_only = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Vertices first … end − 1.
struct VertexRange {
  Eigen::Index first = 0, end = 0;
};

/// What a move has changed in the mesh, to the last bit: ranges increase and do not touch.
struct SurfaceMove {
  std::vector<VertexRange> positions, normals;
  int patches_solved = 0;  ///< of those that keep a factor of their own; 1 where all share one
};

/// The same, kept for further solves: build once, then move the curves or turn their normals many times.
class SurfaceSolver {
 public:
  /// Does what surface_network() does and keeps the triangles, the metric and the factors.
  SurfaceSolver(const CurveNetwork& network, const SurfaceOptions& options = {},
                const Progress& progress = {});
  /// The same with patches that are known.
  SurfaceSolver(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                const SurfaceOptions& options = {}, const Progress& progress = {});
  ~SurfaceSolver();
  SurfaceSolver(SurfaceSolver&&) noexcept;
  SurfaceSolver& operator=(SurfaceSolver&&) noexcept;

  /// The surface as it is now.
  const SurfaceResult& result() const;

  /// Solves again for moved vertices and turned normals of the same network: back-substitutions in the metric
  /// of the surface that was built, whose factors are made by the first move. The result depends on the
  /// surface that was built and on this call alone (`positions_only`: normals aside), so moves do not add up
  /// errors, and moving nothing gives the surface that was built.
  /// @param positions, normals n × 3 as in the network. @throws InvalidInput on other sizes or numbers that
  /// are not finite, SolverFailure; the result is then as before.
  SurfaceMove move(const Points& positions, const Points& normals, const SurfaceMoveOptions& options = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace batten
