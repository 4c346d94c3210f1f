#include "batten/pipeline/step_surface.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

/// Above, CAD programs take a smooth edge for a sharp one.
constexpr double kVisibleJump = radians(0.1);
/// Beyond these the faces are not the surface any more.
constexpr double kFoldedJump = radians(30.0), kLostDeviation = 0.01;

}  // namespace

std::optional<std::string> StepSurfaceOptions::problem() const {
  if (!(step.millimetres_per_unit > 0) || !std::isfinite(step.millimetres_per_unit))
    return concat("millimetres_per_unit must be above 0, got ", step.millimetres_per_unit);
  return faces.problem();
}

StepSurface step_surface(const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                         const StepSurfaceOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  require_step();
  StepSurface result;
  result.diameter = bounding_box_diagonal(mesh.positions);
  {
    const ScopedStage stage(result.times, "splines");
    result.faces = spline_faces(mesh, patch_of_triangle, options.faces, progress.part("splines", 0, 0.9));
  }
  {
    const ScopedStage stage(result.times, "step");
    progress.report("step", 0.9);
    result.step = format_step(result.faces.surface, options.step);
  }
  const double deviation = result.faces.surface.deviation / result.diameter,
               jump = result.faces.surface.normal_jump;
  if (jump > kFoldedJump)
    result.flaws.push_back(
        concat("B-spline faces fold where patches are too bent for few faces: normals differ by up to ",
               degrees(jump), " degrees along smooth curves; divide large patches by more curves"));
  if (deviation > kLostDeviation)
    result.flaws.push_back(concat("B-spline faces leave the surface by ", 100 * deviation,
                                  " % of the diameter; divide large patches by more curves"));
  if (!result.flaws.empty()) return result;
  if (deviation > options.faces.tolerance)
    result.warnings.push_back(concat("the B-spline faces leave the surface by ", 100 * deviation,
                                     " % of the diameter, `step_tolerance` ", 100 * options.faces.tolerance,
                                     " %: more triangles (a shorter `edge_length`) determine more knots"));
  if (jump > kVisibleJump)
    result.warnings.push_back(concat(
        "the normals of neighbouring faces differ by up to ", degrees(jump),
        " degrees along curves that are not sharp; a looser `step_tolerance` or more curves may help"));
  return result;
}

}  // namespace batten
