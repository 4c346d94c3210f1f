#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/step.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

/// The limit surface for CAD.
struct CagePatchesOptions {
  double tolerance = BsplineOptions{}.tolerance;  ///< as BsplineOptions::tolerance
  StepOptions step;
  CadFormat format = CadFormat::Step;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Options of subdivided_cage(). The defaults are those of `batten subdivide`.
struct SubdividedCageOptions {
  /// Schemes that make one level each before `subdivision.scheme` makes the rest.
  std::vector<SubdivisionScheme> first_schemes;
  SubdivisionOptions subdivision;  ///< its levels count those of `first_schemes`
  bool refine = true;              ///< false: only what `patches` says
  /// Also the limit surface as B-splines, from the cage that `first_schemes` leave, and as STEP. Only with
  /// Catmull–Clark, whose limit is made of B-splines. Needs Open Cascade: see has_step().
  std::optional<CagePatchesOptions> patches;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The refined mesh.
struct RefinedCage {
  ControlCage cage;        ///< on the limit surface with option `limit`
  Points normals;          ///< n × 3, of the limit surface where it is smooth everywhere; else 0 × 3
  TriangleMesh triangles;  ///< the same: quads cut along the diagonal from their first corner, others by ears
};

/// The limit surface as B-splines.
struct CagePatches {
  BsplineSurface surface;
  std::size_t n_exact = 0;  ///< patches that are the limit surface itself
  std::size_t n_sharp = 0;  ///< edges
  double diameter = 0;      ///< of the cage, in its unit
  double deviation = 0;     ///< of the limit surface from its patches, mm
  std::string text;         ///< of the file
};

/// What a cage is and what became of it.
struct SubdividedCage {
  Eigen::Index n_vertices = 0, n_faces = 0;  ///< of the cage, as the following
  std::size_t n_sharp_edges = 0, n_sharp_vertices = 0, n_polylines = 0;
  MeshTopology topology;
  std::optional<RefinedCage> refined;
  std::optional<CagePatches> patches;
  std::vector<std::string> warnings;  ///< options are named in backquotes
  StageTimes times;
};

/// Refines a cage, as a mesh, as B-splines for CAD, or both: subdivide(), limit_bsplines(), format_cad().
/// @throws InvalidInput as these; Error when Open Cascade cannot write; Cancelled.
SubdividedCage subdivided_cage(const ControlCage& cage, const SubdividedCageOptions& options = {},
                               const Progress& progress = {});

}  // namespace batten
