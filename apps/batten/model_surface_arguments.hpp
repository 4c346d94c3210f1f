#pragma once
#include "command.hpp"

#include <string>

#include "batten/modelling/continuity.hpp"
#include "batten/modelling/model_surface.hpp"

namespace batten::cli {

/// How the surface of a sketched model is made, as `sketch` has it.
struct ModelSurfaceArguments {
  std::string method = "v2", scheme = "catmull-clark", search = "optimal";
  int splits = 3, levels = 3, refinements = 2;
  bool approximate = false;
};

void add_model_surface_options(CLI::App& command, ModelSurfaceArguments& arguments);

/// Refuses options that do not go together, in words.
/// @param command `sketch`, parsed. @throws CLI::ValidationError.
void check_model_surface_arguments(const CLI::App& command, const ModelSurfaceArguments& arguments);

ModelSurfaceOptions model_surface_options(const ModelSurfaceArguments& arguments);

/// Counts and figures of a surface, as --json has them.
Json figures_json(const ModelSurface& surface);

/// As --json has it: degrees, distances over the diameter and curvatures times the diameter.
Json continuity_json(const ModelContinuity& continuity, double diameter);

}  // namespace batten::cli
