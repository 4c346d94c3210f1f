#pragma once
#include "command.hpp"
#include "model_surface.hpp"

#include <string>
#include <vector>

#include "batten/report/report.hpp"

namespace batten::cli {

struct SketchComparisonOptions {
  std::vector<std::string> methods;  ///< of model_surface_methods()
  std::vector<std::string> models;   ///< only those of these names; empty: all
  ModelSurfaceOptions surface;       ///< splits and levels
  bool pictures = false;
};

/// What compare_sketch_surfaces() found.
struct SketchComparison {
  ReportGrid grid;
  std::vector<ReportPicture> pictures;
  Json models = Json::array();  ///< per model its counts and per method the figures, or why it was refused
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Makes the surfaces of the networks of sketch_network_names() and of all sessions (*.jsonl) of a folder by
/// each method, and measures them: distance from the truth where there is one, and how normals and curvatures
/// jump across the drawn curves. A session with the name of a network is passed over.
/// @param folder empty: no sessions.
/// @throws InvalidInput naming a model that is not there; FileError when a session cannot be read; Cancelled.
SketchComparison compare_sketch_surfaces(const std::string& folder, const SketchComparisonOptions& options,
                                         const Progress& progress);

}  // namespace batten::cli
