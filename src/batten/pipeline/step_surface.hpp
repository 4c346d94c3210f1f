#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/modelling/spline_faces.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/subdivision/step.hpp"

namespace batten {

/// Options of step_surface().
struct StepSurfaceOptions {
  SplineFacesOptions faces;
  StepOptions step;
  CadFormat format = CadFormat::Step;
  /// The network that the mesh fills: edges and faces are named after its curves, a face after its patch and
  /// the curves around it. Null: without names. Not kept.
  const CurveNetwork* network = nullptr;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A surface of patches for CAD.
struct StepSurface {
  SplineFaces faces;
  std::string text;                   ///< of the file
  double diameter = 0;                ///< of the mesh, in its unit
  std::vector<std::string> warnings;  ///< options are named in backquotes
  /// What makes the faces useless: they leave the surface by more than 1 % of the diameter, or fold.
  std::vector<std::string> flaws;
  StageTimes times;
};

/// B-spline faces of a surface, spline_faces(), as the text of a file, format_cad(): a solid where it
/// is closed, else shells.
/// @throws InvalidInput and Error as these; where Open Cascade is missing, before any work. Cancelled.
StepSurface step_surface(const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                         const StepSurfaceOptions& options = {}, const Progress& progress = {});

}  // namespace batten
