#pragma once
#include "command.hpp"

#include <string>
#include <string_view>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"
#include "batten/pipeline/step_surface.hpp"

namespace batten::cli {

/// How surfaces of patches are written for CAD, as `surface`, `reconstruct` and `sketch` share it.
struct StepArguments {
  std::string tolerance = "0.01%";
  int max_patches = SplineFacesOptions{}.most_patches;
};

void add_step_options(CLI::App& command, StepArguments& arguments);

/// By its extension, as cad_format(). @param standard the format that `-` stands for, as an extension.
bool is_cad_file(const std::string& path, std::string_view standard = "ply");

/// The format of a file for CAD; `-` is STEP. @throws UnknownExtension.
CadFormat cad_format_of(const std::string& path);

/// Writes the faces of a mesh of patches and adds figures ("step"), a line, warnings and times.
/// @param network the one that the mesh fills, for the names.
/// @param unit of the mesh, a length. @throws InvalidInput where it is none, and as step_surface().
void write_step(const std::string& path, const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                const CurveNetwork& network, const std::string& unit, const StepArguments& arguments,
                const Context& context, Outcome& outcome);

}  // namespace batten::cli
