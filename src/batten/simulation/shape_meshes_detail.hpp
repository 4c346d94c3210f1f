#pragma once
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/triangle_mesh.hpp"
#include "batten/simulation/shapes.hpp"

// Triangle meshes of the shapes. Private to the room.
namespace batten::detail {

/// Arrays under construction.
struct ShapeMeshBuilder {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;  ///< counter-clockwise from outside

  int add(const Eigen::Vector3d& p) {
    positions.push_back(p);
    return static_cast<int>(positions.size()) - 1;
  }

  /// The mesh with the normals of the surface.
  TriangleMesh finish(const ImplicitFunction& surface) const;
};

/// The unit sphere as an octahedron whose edges are split into n, each vertex moved by `place`: 8 n²
/// triangles.
ShapeMeshBuilder star_mesh(int n, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place);

/// A grid of nu × nv cells, two triangles each; closed directions wrap around.
/// @param place maps (i / nu, j / nv); its partial derivatives in this order make a right hand with the
/// outward normal.
ShapeMeshBuilder grid_mesh(int nu, int nv, bool wrap_u, bool wrap_v,
                           const std::function<Eigen::Vector3d(double, double)>& place);

/// The unit disc as `rings` rings of 6, 12, 18 … vertices about its middle: 6 · rings² triangles.
ShapeMeshBuilder disc_mesh(int rings, const std::function<Eigen::Vector3d(double, double)>& place);

/// The mesh of a shape with edges of about `edge`, in the unit of the shape.
ShapeMeshBuilder build_mesh(AnalyticShape shape, double edge);

}  // namespace batten::detail
