#include <cmath>
#include <optional>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/engine/handle_drag_detail.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten::detail {

namespace {

Handles region_of(const TriangleMesh& mesh, const Eigen::Vector3d& place, double radius, double reach) {
  const MeshEdges edges = mesh_edges(mesh.triangles, mesh.n_vertices());
  const std::vector<int> part = triangle_components(edges);
  const Eigen::VectorXd distance = (mesh.positions.rowwise() - place.transpose()).rowwise().norm();
  std::vector<char> is_moved_part(part.size() + 1, 0), may_move(at(mesh.n_vertices()), 0);
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      if (distance[mesh.triangles(f, k)] <= radius) is_moved_part[at(part[at(f)])] = 1;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      if (is_moved_part[at(part[at(f)])]) may_move[at(mesh.triangles(f, k))] = 1;
  Handles handles;
  std::vector<int>& moved = handles.moved.emplace_back().vertices;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (may_move[at(v)] && distance[v] <= radius)
      moved.push_back(v);
    else if (!may_move[at(v)] || distance[v] > reach)
      handles.fixed.push_back(v);
  }
  return handles;
}

}  // namespace

void HandleDrag::grab(SharedMesh mesh, const Eigen::Vector3d& place, double radius, double reach,
                      DeformationEnergy energy, const Progress& progress) {
  if (!place.allFinite()) throw InvalidInput("the place to take hold of must be three finite numbers");
  if (!(radius > 0) || !(reach > radius) || !std::isfinite(reach))
    throw InvalidInput(concat("the handle must have a radius above 0 and its reach be larger, got ", radius,
                              " and ", reach));
  if (const std::optional<std::string> found = mesh_problem(*mesh)) throw InvalidInput(*found);
  Handles handles = region_of(*mesh, place, radius, reach);
  if (handles.moved[0].vertices.empty())
    throw InvalidInput(concat("no vertex lies within ", radius, " of the place; take a larger handle"));
  if (handles.fixed.empty()) throw InvalidInput("nothing would stay where it is; take a smaller reach");
  DeformOptions options;
  options.energy = energy;
  options.detail = DetailPreservation::None;
  auto deformer =
      std::make_unique<Deformer>(mesh->positions, mesh->triangles, handles.vertices(), options, progress);
  split_ = split_at_creases(*mesh);
  origin_ = middle_of(mesh->positions);
  mesh_ = std::move(mesh);
  handles_ = std::move(handles);
  deformer_ = std::move(deformer);
}

void HandleDrag::add_grabbed(Draft& draft) const {
  draft.json["origin"] = json_of(origin_);
  draft.json["n_moved"] = handles_.moved[0].vertices.size();
  draft.json["n_fixed"] = handles_.fixed.size();
  draft.add_indices("moved", handles_.moved[0].vertices);
  draft.add_indices("fixed", handles_.fixed);
  draft.add_points("positions", split_.spread(mesh_->positions), origin_);
  draft.add_points("normals", split_.normals, Eigen::RowVector3d::Zero());
  draft.add_triangles("triangles", split_.triangles);
}

void HandleDrag::pull(Draft& draft, const HandleMotion& motion, const Progress& progress) {
  if (!deformer_) throw InvalidInput("no place of a mesh is held; take hold of one with 'grab' first");
  HandleMotion& moved = handles_.moved[0];
  moved.translation = motion.translation;
  moved.axis = motion.axis;
  moved.angle = motion.angle;
  moved.about = motion.about;
  if (const std::optional<std::string> found = handles_.problem(mesh_->n_vertices()))
    throw InvalidInput(*found);
  const Points positions =
      split_.spread(deformer_->deform(handles_.targets(mesh_->positions), nullptr, progress).positions);
  draft.json["origin"] = json_of(origin_);
  draft.add_points("positions", positions, origin_);
  // Copies of a vertex share the triangles of one side of their crease alone.
  draft.add_points("normals", vertex_normals(positions, split_.triangles), Eigen::RowVector3d::Zero());
}

}  // namespace batten::detail
