#pragma once
#include "command.hpp"

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
  int splits = 3;             ///< of every face before the flow, 1 to 6
  int levels = 3;             ///< of Catmull-Clark afterwards, 0 to 6
};

/// The names of the methods, in the order in which they are compared.
const std::vector<std::string>& model_surface_methods();

/// The surface of a model.
struct ModelSurface {
  TriangleMesh mesh;  ///< without triangles where only the cage was asked for
  ControlCage cage;   ///< its limit surface is what STEP files hold
  Json figures = Json::object();
  std::vector<std::string> warnings;
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
  CurveContinuity smooth, sharp;   ///< over the edges of sharpness 0, and over the others
  int worst_curve = -1;            ///< the smooth one with the largest normal jump, or −1
};

/// Measures along the drawn curves (ties that tools made are left out) and their pieces between vertices.
ModelContinuity model_continuity(const PolylineMesh& model, const TriangleMesh& mesh,
                                 const Progress& progress);

/// As --json has it: degrees, distances over the diameter and curvatures times the diameter.
Json continuity_json(const ModelContinuity& continuity, double diameter);

}  // namespace batten::cli
