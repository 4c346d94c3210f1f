#pragma once
#include "command.hpp"

#include <string>

#include "batten/modelling/coons_surface.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten::cli {

/// The options of `sketch --method v1` alone.
struct CoonsArguments {
  std::string scheme = "catmull-clark", search = "optimal";
  int refinements = 2;
  bool approximate = false;
};

void add_coons_options(CLI::App& command, CoonsArguments& arguments);

/// Refuses options that do not go together, in words.
/// @param command `sketch`, parsed. @throws CLI::ValidationError.
void check_coons_arguments(const CLI::App& command, const CoonsArguments& arguments,
                           const std::string& method, int levels);

/// Makes the surface; figures, lines and times go to `outcome`, counts of the surface to `figures`.
CoonsSurface run_coons_stage(const CoonsArguments& arguments, const PolylineMesh& mesh, int levels,
                             const Context& context, Outcome& outcome, Json& figures);

/// The quads of its finished surface, cut as coons_surface() has checked them.
Triangles triangles_of(const PolygonMesh& quads);

}  // namespace batten::cli
