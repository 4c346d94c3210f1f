#include "batten/pipeline/mesh_input.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/areas.hpp"

namespace batten {

namespace {

// Sixth powers of lengths occur (squared volumes): they must stay numbers.
constexpr double kSmallestSize = 1e-45, kLargestSize = 1e45;

}  // namespace

std::optional<std::string> mesh_problem(const TriangleMesh& mesh) {
  if (mesh.n_triangles() == 0) return "there are no faces, so nothing to process";
  if (!mesh.positions.allFinite()) return "a position is not finite; remove it";
  if (mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= mesh.n_vertices())
    return concat("a face has a vertex outside 0 to ", mesh.n_vertices() - 1);
  const double size = (mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff()).maxCoeff();
  if (size > 0 && !(size > kSmallestSize && size < kLargestSize))
    return concat(
        "the mesh is ", size,
        " large, where squares and volumes are out of the range of numbers; give it in another unit");
  if (!(face_areas(mesh.positions, mesh.triangles).maxCoeff() > 0))
    return "no face has an area; check the positions";
  return std::nullopt;
}

std::string place_in_words(const Eigen::RowVector3d& point) {
  return concat('(', point.x(), ", ", point.y(), ", ", point.z(), ')');
}

std::string place_in_words(const TriangleMesh& mesh, int triangle) {
  return place_in_words((mesh.positions.row(mesh.triangles(triangle, 0)) +
                         mesh.positions.row(mesh.triangles(triangle, 1)) +
                         mesh.positions.row(mesh.triangles(triangle, 2))) /
                        3);
}

void require_processable(const TriangleMesh& mesh) {
  if (const auto problem = mesh_problem(mesh)) throw InvalidInput(*problem);
}

}  // namespace batten
