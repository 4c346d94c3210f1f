#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// How vertices are spread in the surface.
enum class RemeshMethod {
  /// Adaptive remeshing (H 2.2): areas diffused up to changes of curvature, then tangential relocation.
  Adaptive,
  /// The Laplacian flow (H 2.46, 2.47; [botsch2004]), for comparison.
  LaplacianFlow,
};

constexpr auto choices_of(RemeshMethod) {
  return choices<RemeshMethod>("remeshing method",
                               {{RemeshMethod::Adaptive, "ar"}, {RemeshMethod::LaplacianFlow, "lf"}});
}

/// What the new triangles should be like.
struct RemeshOptions {
  RemeshMethod method = RemeshMethod::Adaptive;
  /// Edge length in the unit of the mesh. The result has as many vertices as triangles of this mean edge take
  /// on the same area. 0: the mean edge length of the input.
  double edge_length = 0;
  /// Number of vertices, instead of an edge length; 0 leaves it to the edge length. Met within some 2 %.
  int n_vertices = 0;
  /// 0: edges of one length. 1: as fine as curvature asks (h ∝ κ^(−1/2), from a quarter to four times the
  /// length). See adaptive_sizes().
  double adaptivity = 0.1;
  /// Edges whose faces meet at more than this angle, and borders, are kept: their vertices stay on them. A
  /// crease is followed beyond where it fades below the angle, to half of it, while it stands out.
  /// Radians, in (0, π]; π keeps only borders.
  double keep_edges = radians(30.0);
  /// Border vertices all stay, bit for bit, and none come in between: pieces of one mesh that are remeshed
  /// apart still meet. Beside a border with shorter edges the new ones are shorter too. false: vertices move
  /// along the border curves.
  bool hold_border = false;
  /// A wanted edge length per vertex of the input (n values, positive, unit of the mesh), or empty. Instead
  /// of curvature; scaled only where n_vertices is given.
  Eigen::VectorXd sizes;
  /// Most rounds of STEP 0 to 2, at least 1.
  int max_iterations = 8;
  /// Stop when Var(A) / (N Ā²) changes by less between rounds (H: 1e-6, there absolute), A being vertex areas
  /// relative to the wanted ones; at least 0.
  double tolerance = 1e-6;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How remeshing went.
struct RemeshReport {
  int iterations = 0;
  bool converged = false;  ///< stopped by the tolerance
  int feature_edges = 0;   ///< kept edges in the result, borders included
  int split_vertices = 0;  ///< vertices added where fans of the input only touched
  int corners = 0;  ///< vertices that were never moved; with `hold_border` all on the border are among them
  std::vector<double> area_variance;  ///< Var(A) / (N Ā²) of relative areas after every round
  double target_vertices = 0;
  bool is_faceted = false;  ///< the input was taken for a part of flat facets, all of which are kept
  /// Pairs of triangles that cross, as self_intersections() counts them up to 10,000: in the result, and in
  /// the input, which is searched only where the result has any.
  std::size_t crossings = 0, input_crossings = 0;
  SolveQuality solves;  ///< of the diffusion of areas and the fit to the surface
};

/// The new mesh.
struct RemeshResult {
  TriangleMesh mesh;
  RemeshReport report;
  StageTimes times;
};

/// Replaces the triangles of a surface by better ones of about the wanted size.
///
/// Rounds of splits, collapses and flips, of area diffusion and of tangential relocation (H 2.2.2), each
/// closed by a projection to the input surface; then (not with LaplacianFlow) vertices are moved and edges
/// turned to where the new triangles fit the old surface best, in place and in normals, and triangles that
/// cross where those of the input did not are mended. Vertices on kept edges move along the input's feature
/// curves, corners stay.
/// @throws InvalidInput when the mesh is empty or not an oriented manifold, or an option is out of range.
RemeshResult remesh(const TriangleMesh& mesh, const RemeshOptions& options = {},
                    const Progress& progress = {});

}  // namespace batten
