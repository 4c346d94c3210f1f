#include "openmesh.hpp"

#include <chrono>
#include <ctime>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace batten {

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

}  // namespace

OpenMeshDecimation decimate_with_openmesh(const TriangleMesh& mesh, Eigen::Index n_faces) {
  Mesh work;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    work.add_vertex({mesh.positions(v, 0), mesh.positions(v, 1), mesh.positions(v, 2)});
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    work.add_face(Mesh::VertexHandle(mesh.triangles(f, 0)), Mesh::VertexHandle(mesh.triangles(f, 1)),
                  Mesh::VertexHandle(mesh.triangles(f, 2)));
  work.request_face_normals();
  OpenMeshDecimation result;
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  work.update_face_normals();
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(work);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(flipping);
  decimater.module(quadric).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, static_cast<std::size_t>(n_faces));
  result.cpu_seconds = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  work.garbage_collection();
  result.mesh.positions.resize(static_cast<Eigen::Index>(work.n_vertices()), 3);
  result.mesh.triangles.resize(static_cast<Eigen::Index>(work.n_faces()), 3);
  for (const auto v : work.vertices()) {
    const OpenMesh::Vec3d& p = work.point(v);
    result.mesh.positions.row(v.idx()) << p[0], p[1], p[2];
  }
  for (const auto f : work.faces()) {
    int k = 0;
    for (auto v = work.cfv_iter(f); v.is_valid(); ++v) result.mesh.triangles(f.idx(), k++) = v->idx();
  }
  return result;
}

}  // namespace batten
