#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/modelling/continuity.hpp"
#include "batten/modelling/model_surface.hpp"
#include "batten/report/report.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten::experiments {

struct SketchComparisonOptions {
  std::vector<ModelSurfaceMethod> methods;
  std::vector<std::string> models;  ///< only those of these names; empty: all
  ModelSurfaceOptions surface;      ///< splits and levels
  bool pictures = false;
};

/// The surface of one model by one method. Lengths over the diameter of the model.
struct MeasuredSurface {
  ModelSurfaceMethod method = ModelSurfaceMethod::Diffusion;
  std::string refusal;   ///< why there is none; then nothing else holds
  ModelSurface surface;  ///< its mesh and cage are empty: they would fill the memory
  Eigen::Index n_vertices = 0, n_triangles = 0;
  double seconds = 0;
  struct Deviation {
    double mean = 0, max = 0;
  };
  std::optional<Deviation> deviation;  ///< from the truth, where there is one
  ModelContinuity continuity;
  double diameter = 0;
};

struct ComparedModel {
  std::string name;
  SketchCounts counts;
  std::vector<MeasuredSurface> surfaces;
};

/// What compare_sketch_surfaces() found.
struct SketchComparison {
  ReportGrid grid;
  std::vector<ReportPicture> pictures;
  std::vector<ComparedModel> models;
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Makes the surfaces of the models of example_model_names() and of all sessions (*.jsonl) of a folder by
/// each method, and measures them: distance from the truth where there is one, and how normals and curvatures
/// jump across the drawn curves. A session with the name of a network is passed over.
/// @param folder empty: no sessions.
/// @throws InvalidInput naming a model that is not there; FileError when a session cannot be read; Cancelled.
SketchComparison compare_sketch_surfaces(const std::string& folder, const SketchComparisonOptions& options,
                                         const Progress& progress);

}  // namespace batten::experiments
