#pragma once
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/io/mesh_attributes.hpp"

namespace batten::commands {

/// Makes a mesh that was read ready for every command on meshes: a soup of triangles is welded; with `repair`
/// everything is mended that `batten repair` mends without options. What was done is told in the warnings.
/// @param name what sentences call the mesh, such as its path. @throws InvalidInput with what
/// mesh_problem() says of it; Cancelled.
void prepare_mesh(const std::string& name, MeshFile& file, std::vector<std::string>& warnings, bool repair,
                  const Progress& progress);

/// A mesh made of `input` with the attributes of that: as they are where `same_faces`, else those of
/// carried_attributes(). What is dropped on the way is told in the warnings.
MeshFile made_file(TriangleMesh mesh, const MeshFile& input, bool same_faces,
                   std::vector<std::string>& warnings, const Progress& progress = {});

}  // namespace batten::commands
