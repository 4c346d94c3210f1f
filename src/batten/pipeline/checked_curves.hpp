#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/operators/curve_continuity.hpp"

namespace batten {

/// How smoothly a surface has to pass under a curve: without a gap, with one normal, with one curvature.
enum class ContinuityClass { G0, G1, G2 };

constexpr auto choices_of(ContinuityClass) {
  return choices<ContinuityClass>(
      "continuity", {{ContinuityClass::G0, "g0"}, {ContinuityClass::G1, "g1"}, {ContinuityClass::G2, "g2"}});
}

enum class CurveVerdict {
  Pass,
  Fail,
  Sharp,   ///< marked as sharp: held to G0 alone, which it passes
  Border,  ///< the surface lies on one side of it alone
};

constexpr auto choices_of(CurveVerdict) {
  return choices<CurveVerdict>("verdict", {{CurveVerdict::Pass, "pass"},
                                           {CurveVerdict::Fail, "fail"},
                                           {CurveVerdict::Sharp, "sharp"},
                                           {CurveVerdict::Border, "border"}});
}

/// What check_curves() asks of a surface.
struct CurveCheckOptions {
  ContinuityClass require = ContinuityClass::G1;
  double gap = 1e-3;                ///< G0: largest gap, as a share of the diameter of the mesh, above 0
  double tolerance = radians(0.5);  ///< G1: largest angle between the normals of both sides, 0 … π, above 0
  /// G2: largest difference of the curvatures across the curve as a share of the larger one, above 0. Where
  /// both are below 1 / diameter, that counts for the larger one: nobody sees a jump on a plane.
  double curvature = 0.1;
  double distance =
      0.01;  ///< largest distance of the curve from the mesh, as a share of the diameter, above 0
  ContinuityOptions measure;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A curve and how the surface passes under it.
struct CheckedCurve {
  std::string name;
  CurveVerdict verdict = CurveVerdict::Pass;
  std::vector<std::string> reasons;  ///< of a failure, half sentences with figure and tolerance
  CurveContinuity figures;
  double max_curvature_share = 0;  ///< the largest difference of curvatures as a share of the larger one
  Eigen::Vector3d worst =
      Eigen::Vector3d::Zero();  ///< where the first reason is at its worst; else of the normals
};

/// The verdicts on all curves of a network.
struct CurveCheck {
  std::vector<CheckedCurve> curves;  ///< one per curve of the network, in its order
  int n_checked = 0;                 ///< all but the borders
  int n_failed = 0;
  double diameter = 0;  ///< diagonal of the bounding box of the mesh
  StageTimes times;

  bool passes() const { return n_failed == 0; }
};

/// Whether a surface is as smooth across the curves of a network as asked, by curve_continuity(): the figures
/// are those of quadrics fitted to either side. A curve where nothing can be measured (too few vertices on a
/// side) fails: it says nothing in favour of the surface. Linear in the samples.
/// @throws InvalidInput on a network without curves, bad options, and as curve_continuity(); Cancelled.
CurveCheck check_curves(const TriangleMesh& mesh, const CurveNetwork& network,
                        const CurveCheckOptions& options = {}, const Progress& progress = {});

/// What lies around a place of a curve, to be looked at.
struct Surroundings {
  TriangleMesh mesh;                                  ///< triangles with a corner within the radius
  CurveNetwork network;                               ///< the pieces of the curve within the radius
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the surface there, a mean
  double spread = 0;                                  ///< of the normals about it, root mean square, radians
};

/// @param curve index into network.curves. @throws InvalidInput when no triangle lies within the radius.
Surroundings surroundings(const TriangleMesh& mesh, const CurveNetwork& network, int curve,
                          const Eigen::Vector3d& place, double radius);

}  // namespace batten
