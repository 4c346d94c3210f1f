#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/simplification/history.hpp"
#include "batten/simplification/p_laplacian.hpp"

namespace batten {

/// How edges are chosen for collapse.
enum class SimplifyMethod {
  /// By the error alone. The default: least distance for a number of faces.
  Quadric,
  /// H 2.4: in levels, by the error and by the length of edges after a p-Laplacian flow (2.100), which draws
  /// vertices to the features. Coarser detail in flat parts, the same amount of work per level.
  PLaplacian,
};

constexpr auto choices_of(SimplifyMethod) {
  return choices<SimplifyMethod>("simplification method", {{SimplifyMethod::Quadric, "quadric"},
                                                           {SimplifyMethod::PLaplacian, "plaplacian"}});
}

/// Options of simplify(). Exactly one of `faces`, `remove` and `max_error` says where to stop.
struct SimplifyOptions {
  SimplifyMethod method = SimplifyMethod::Quadric;
  /// At most this many faces; 0 for another criterion. At least 1.
  Eigen::Index faces = 0;
  /// The fraction of the faces to remove, in (0, 1); 0 for another criterion.
  double remove = 0;
  /// The largest distance between the two surfaces, in either direction, in the unit of the mesh; 0 for
  /// another criterion. Measured at every input vertex, at area samples of the input, and at vertices,
  /// edge midpoints and centres of the result.
  double max_error = 0;
  /// Levels of the p-Laplacian method and of `keep_levels`, at least 1. H (2.99)
  int levels = 3;
  /// Keep the mesh of every level with the map from the vertices of the level before.
  bool keep_levels = false;
  /// Record every change, so that the result can be refined again step by step.
  bool keep_history = false;
  /// Edges whose faces turn by more than this angle (radians, in (0, π)) stay edges: vertices on them move
  /// along them only. 0: they are kept only as far as the error asks for it, which it does where they matter.
  double keep_edges = 0;
  /// Border vertices all stay, bit for bit, and no border edge goes: pieces of one mesh that are simplified
  /// apart still meet. false: borders lose vertices as their shape allows.
  bool hold_border = false;
  /// Exponents of error and length in (2.100); the p-Laplacian method only.
  double alpha = 1, beta = 1;
  /// The flow of the p-Laplacian method.
  PLaplacianOptions flow;
  /// Rounds of the final fit, which moves vertices and turns edges so that the result lies closer to the
  /// input with better triangles; 0 leaves the bare collapses.
  int fit_rounds = 6;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A mesh on the way.
struct SimplifyLevel {
  TriangleMesh mesh;
  /// Per vertex of the level before (the input for the first): the vertex of this level that stands for it.
  std::vector<int> vertex_of_finer;
};

/// The simplified mesh, and how far it is from the input.
struct SimplifyResult {
  TriangleMesh mesh;
  /// Per input vertex the vertex of `mesh` that stands for it; −1 where no face used it.
  std::vector<int> vertex_map;
  /// From fine to coarse, the last equal to `mesh`; empty without keep_levels.
  std::vector<SimplifyLevel> levels;
  /// Empty without keep_history.
  SimplificationHistory history;
  /// Root mean square and largest distance of samples of the input from the result, in the unit of the mesh.
  double rms_error = 0, max_error = 0;
  Eigen::Index collapses = 0;
  bool reached = true;  ///< false: topology or kept edges allow no more collapses
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Reduces the number of faces of a triangle mesh.
///
/// Edges are collapsed in the order of the volume and area they disturb (memoryless quadrics after
/// [lindstrom1998], which hold the enclosed volume); the result is then fitted to the input in the
/// least-squares sense. No collapse, move or flip folds a face, makes it degenerate, or makes it touch
/// another: what does not intersect itself does not after. Topology and borders are kept, the
/// latter in shape or, with `hold_border`, exactly.
/// Values per vertex and normals are dropped.
///
/// Vertices where several fans of faces meet are split, with a warning.
/// @throws InvalidInput on bad options and on meshes that are no oriented manifold, naming the place;
/// Cancelled.
SimplifyResult simplify(const TriangleMesh& mesh, const SimplifyOptions& options,
                        const Progress& progress = {});

/// Faces to be left after each level: the shares of H (2.99) of what is to be removed,
/// (3(n − 1) − 2k) / (2 n (n − 1)) for k = 0 … n − 1, which sum to one; all at once for n = 1.
std::vector<Eigen::Index> faces_per_level(Eigen::Index faces, Eigen::Index target, int levels);

}  // namespace batten
