#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/modelling/base_mesh.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// How the refined mesh of H 6.2 becomes a smooth surface (H 6.3).
enum class FinalScheme {
  CatmullClark,           ///< the smoothest
  Nuliss,                 ///< through the vertices of the refined mesh
  NulissMod,              ///< along the polylines; not smooth across them
  NulissModCatmullClark,  ///< one level of the one, then the other (H fig. 7.3)
};

constexpr auto choices_of(FinalScheme) {
  return choices<FinalScheme>("scheme", {{FinalScheme::CatmullClark, "catmull-clark"},
                                         {FinalScheme::Nuliss, "nuliss"},
                                         {FinalScheme::NulissMod, "nulissmod"},
                                         {FinalScheme::NulissModCatmullClark, "nulissmod+catmull-clark"}});
}
/// Whether the last levels are Catmull–Clark's, so that the limit surface is one of B-splines.
constexpr bool ends_in_catmull_clark(FinalScheme scheme) {
  return scheme == FinalScheme::CatmullClark || scheme == FinalScheme::NulissModCatmullClark;
}

/// Options of coons_surface(). The defaults are those of H 6.2, with the better search.
struct CoonsOptions {
  /// How faces are divided into triangles and quads.
  SplitSearch search = SplitSearch::Optimal;
  /// Steps of basic refinement S, 1 to 6: each quad of the base mesh becomes 4^S. H: two are enough.
  int steps = 2;
  FinalScheme scheme = FinalScheme::CatmullClark;
  /// Levels of subdivision, 0 to 6; NulissModCatmullClark needs one at least.
  int levels = 3;
  /// Schemes that end in Catmull–Clark: vertices of the cage are moved so that the limit surface goes through
  /// the refined mesh. Off: the refined mesh is the cage, and the surface passes its curves by (H 6.3).
  bool through_curves = true;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The surface of H 6.1 to 6.3 and its stages.
struct CoonsSurface {
  BaseMesh base;  ///< triangles and quads with a curve along every edge
  /// All quads, counter-clockwise seen from outside; sharp edges as creases (sharpness 1 for ever, below that
  /// four levels times the sharpness); with the NULISS schemes a polyline along every edge.
  ControlCage refined;
  std::vector<char> on_curve;     ///< per vertex of `refined`: on a drawn curve
  std::vector<int> face_of_quad;  ///< face of the model, per quad of `refined`
  /// Per edge of the model (empty for removed ones): its vertices in `refined`, from end to end.
  std::vector<std::vector<int>> vertices_of_edge;
  /// With schemes that end in Catmull–Clark the cage of the limit surface; else empty.
  ControlCage cage;
  /// How far the limit surface is from its curves, ÷ diameter. Where it has not converged the cage is the
  /// best found: warn.
  IterativeReport cage_fit{.iterations = 0, .residual = 0, .converged = true};
  /// The finished surface: quads, on the limit surface with Catmull–Clark, to be cut into triangles along
  /// the diagonal from their first corner. Its first vertices are those of `refined`.
  PolygonMesh fine;
  Points normals;                 ///< of the limit surface, one per vertex of `fine`
  std::vector<int> face_of_fine;  ///< face of the model, per quad of `fine`
  StageTimes times;
};

/// The surface of FIRES V1 (H 6.1 to 6.3): faces are divided into triangles and quads, these are refined over
/// bilinearly blended Coons patches, and the result is subdivided. Closed components are turned so that their
/// normals point outwards. Time and memory are linear in the number of faces that come out.
/// @throws InvalidInput on bad options, an empty model, more than 2 million quads, and where the surface
/// folds, crosses itself or leaves its curves, with the faces; SolverFailure; Cancelled.
CoonsSurface coons_surface(const PolylineMesh& mesh, const CoonsOptions& options = {},
                           const Progress& progress = {});

}  // namespace batten
