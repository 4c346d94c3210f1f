#include <array>

#include <Eigen/Eigenvalues>

#include "batten/modelling/edge_courses_detail.hpp"

namespace batten::detail {

using Eigen::Vector3d;

Vector3d normal_of_curves_at(const PolylineMesh& mesh, int vertex) {
  constexpr int kSamples = 16;
  const Vector3d here = mesh.vertex(vertex).position;
  // Where all curves leave in one direction, their further course tells: a hole is nearly flat.
  for (const int reach : {1, kSamples}) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int e : mesh.vertex(vertex).edges) {
      const SketchEdge& edge = mesh.edge(e);
      if (!edge.drawn) continue;
      const Points samples = edge.polyline->sampled(kSamples);
      const bool forward = edge.vertices[0] == vertex;
      for (int k = 1; k <= reach; ++k) {
        const Vector3d offset = samples.row(forward ? k : kSamples - k).transpose() - here;
        if (const double length = offset.norm(); length > 0) spread += offset * offset.transpose() / length;
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    if (axes.eigenvalues()(1) > 0.05 * axes.eigenvalues()(2)) return axes.eigenvectors().col(0);
  }
  return Vector3d::Zero();
}

Points course_of_edge(const PolylineMesh& mesh, const SketchEdge& edge, int n) {
  Points points = edge.polyline->sampled(n);
  if (edge.drawn) return points;
  const Vector3d from = points.row(0), to = points.row(n), chord = to - from;
  std::array<Vector3d, 2> tangents;
  for (size_t k = 0; k < 2; ++k) {
    const Vector3d normal = normal_of_curves_at(mesh, edge.vertices[k]),
                   in_plane = chord - chord.dot(normal) * normal;
    tangents[k] =
        in_plane.norm() > 0.2 * chord.norm() ? (chord.norm() * in_plane.normalized()).eval() : chord;
  }
  for (int i = 1; i < n; ++i) {
    const double t = static_cast<double>(i) / n, s = 1 - t;
    points.row(i) = s * s * (1 + 2 * t) * from + t * t * (1 + 2 * s) * to + t * s * s * tangents[0] -
                    t * t * s * tangents[1];
  }
  return points;
}

}  // namespace batten::detail
