#pragma once
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/operators/curve_continuity.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// How a surface meets across the drawn curves of its model.
struct ModelContinuity {
  /// The figures of one curve.
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

/// Measures along the drawn curves (ties that tools made are left out). Angles in radians, lengths in the
/// unit of the model.
/// @param mesh a surface of the model. @param splits those of the flow, 1 to 6: "close to" a corner is the
/// first or last piece of an edge in 2^splits.
/// @throws Cancelled.
ModelContinuity model_continuity(const PolylineMesh& model, const TriangleMesh& mesh, int splits,
                                 const Progress& progress = {});

}  // namespace batten
