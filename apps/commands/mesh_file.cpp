#include "commands/mesh_file.hpp"

#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/pipeline/mesh_input.hpp"
#include "batten/pipeline/repaired_mesh.hpp"

namespace batten::commands {

void prepare_mesh(const std::string& name, MeshFile& file, std::vector<std::string>& warnings, bool repair,
                  const Progress& progress) {
  if (const auto problem = mesh_problem(file.mesh)) throw InvalidInput(concat(name, ": ", *problem));
  if (!repair) {
    if (file.mesh.n_vertices() < file.mesh.n_triangles()) return;  // no soup
    TriangleMesh welded = file.mesh;
    const auto note = weld_soup(welded);
    if (!note) return;
    warnings.push_back(concat(name, ": ", *note));
    if (welded.n_triangles() != file.mesh.n_triangles())
      file.attributes = carried_attributes(file, welded, warnings, progress);
    file.mesh = std::move(welded);
    return;
  }
  RepairedMesh repaired = repaired_mesh(file.mesh, {}, progress);
  file.attributes = carried_attributes(file, repaired.mesh, warnings, progress);
  file.mesh = std::move(repaired.mesh);
  for (const std::string& done : repaired.done) warnings.push_back(concat(name, " repaired: ", done));
  for (const std::string& flaw : repaired.flaws) warnings.push_back(concat(name, " not repaired: ", flaw));
}

MeshFile made_file(TriangleMesh mesh, const MeshFile& input, bool same_faces,
                   std::vector<std::string>& warnings, const Progress& progress) {
  MeshFile made{std::move(mesh), {}};
  made.attributes = same_faces ? input.attributes : carried_attributes(input, made.mesh, warnings, progress);
  return made;
}

}  // namespace batten::commands
