#pragma once
#include "command.hpp"
#include "coons_stage.hpp"

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/control_cage.hpp"
#include "batten/operators/curve_continuity.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten::cli {

/// How the surface of a sketched model is made.
struct ModelSurfaceOptions {
  std::string method = "v2";  ///< of model_surface_methods()
  int splits = 3;             ///< v2, curvature: of every face before the flow, 1 to 6
  int levels = 3;             ///< of subdivision afterwards, 0 to 6
  CoonsArguments coons;       ///< v1
};

/// The names of the methods, in the order in which they are compared.
const std::vector<std::string>& model_surface_methods();

/// The surface of a model.
struct ModelSurface {
  TriangleMesh mesh;  ///< without triangles where only the cage was asked for
  ControlCage cage;   ///< its limit surface is what STEP files hold; empty where the scheme has none
  Json figures = Json::object();
  std::vector<std::string> warnings;
  std::vector<std::string> lines;  ///< what a person reads
  StageTimes times;
};

/// @param with_mesh false: only the cage.
/// @throws InvalidInput where the method refuses the model, with the faces and the remedy; SolverFailure;
/// Cancelled.
ModelSurface make_model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options, bool with_mesh,
                                const Progress& progress);

/// How a surface meets across the drawn curves of its model.
struct ModelContinuity {
  struct CurveEntry {
    int curve = 0;
    double sharpness = 0;  ///< largest of its edges
    CurveContinuity figures;
  };
  std::vector<CurveEntry> curves;  ///< those with a surface on both sides, by their numbers
  CurveContinuity smooth;          ///< along edges of sharpness 0 but for what is near corners
  int worst_curve = -1;            ///< the smooth one with the largest normal jump, or −1
  /// Along edges of sharpness 0 close to vertices where a sharp curve begins or the directions of the smooth
  /// curves do not lie in a plane: no surface through the curves is smooth there.
  CurveContinuity corners;
  CurveContinuity sharp;
};

/// Measures along the drawn curves (ties that tools made are left out).
/// @param splits those of the flow: "close to" is the first or last piece of an edge in 2^splits.
ModelContinuity model_continuity(const PolylineMesh& model, const TriangleMesh& mesh, int splits,
                                 const Progress& progress);

/// As --json has it: degrees, distances over the diameter and curvatures times the diameter.
Json continuity_json(const ModelContinuity& continuity, double diameter);

}  // namespace batten::cli
