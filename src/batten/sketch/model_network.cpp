#include "batten/sketch/model_network.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Unit normals at the vertices of a quad mesh: means of the corner normals, weighted by their angles, so
/// that quads of unequal size around a vertex do not pull. Where they cancel, as at the corner of a foot
/// where the sheet turns back on itself, that of the widest corner.
Points quad_normals(const PolygonMesh& mesh) {
  Points normals = Points::Zero(mesh.positions.rows(), 3), widest = normals;
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(normals.rows()), sums = angles;
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[static_cast<size_t>(mesh.offsets[static_cast<size_t>(f)])];
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector3d here = mesh.positions.row(c[k]);
      const Eigen::Vector3d next = mesh.positions.row(c[(k + 1) % 4]).transpose() - here;
      const Eigen::Vector3d last = mesh.positions.row(c[(k + 3) % 4]).transpose() - here;
      const Eigen::Vector3d cross = next.cross(last);
      const double angle = std::atan2(cross.norm(), next.dot(last));
      normals.row(c[k]) += angle * cross.stableNormalized().transpose();
      sums(c[k]) += angle;
      if (cross.norm() > 0 && angle > angles(c[k])) {
        angles(c[k]) = angle;
        widest.row(c[k]) = cross.stableNormalized().transpose();
      }
    }
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    if (const double length = normals.row(v).norm(); length > 0.05 * sums(v))
      normals.row(v) /= length;
    else
      normals.row(v) = widest.row(v);
  return normals;
}

}  // namespace

CurveNetwork network_of_model(const PolylineMesh& mesh, const DiffusionSurface& surface) {
  const Points normals = quad_normals(surface.refined.mesh);
  CurveNetwork network;
  std::vector<int> number(static_cast<size_t>(normals.rows()), -1), used;
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const SketchEdge& edge = mesh.edges()[e];
    if (!edge.alive) continue;
    NetworkCurve curve;
    curve.name = concat("c", edge.curve);
    curve.boundary = edge.faces[0] < 0 || edge.faces[1] < 0;
    for (const int v : surface.vertices_of_edge[e]) {
      int& own = number[static_cast<size_t>(v)];
      if (own < 0) {
        own = static_cast<int>(used.size());
        used.push_back(v);
      }
      curve.vertices.push_back(own);
    }
    network.curves.push_back(std::move(curve));
  }
  network.positions.resize(static_cast<Eigen::Index>(used.size()), 3);
  network.normals.resize(network.positions.rows(), 3);
  for (size_t k = 0; k < used.size(); ++k) {
    network.positions.row(static_cast<Eigen::Index>(k)) = surface.refined.mesh.positions.row(used[k]);
    network.normals.row(static_cast<Eigen::Index>(k)) = normals.row(used[k]);
  }
  // Ends of edges are nodes even where two edges meet smoothly.
  for (const NetworkCurve& curve : network.curves)
    for (const int end : {curve.vertices.front(), curve.vertices.back()})
      if (std::find(network.tagged_nodes.begin(), network.tagged_nodes.end(), end) ==
          network.tagged_nodes.end())
        network.tagged_nodes.push_back(end);
  return network;
}

}  // namespace batten
