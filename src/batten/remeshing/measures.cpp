#include "batten/remeshing/measures.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Points of the original whose normals are compared.
constexpr int kNormalSamples = 100000;

/// Var(A) / (Nv Ā²) over the vertices in use.
double area_variance(const TriangleMesh& mesh) {
  const Eigen::VectorXd areas = lumped_mass(mesh.positions, mesh.triangles);
  double sum = 0, squares = 0;
  int count = 0;
  for (Eigen::Index v = 0; v < areas.size(); ++v)
    if (areas[v] > 0) {
      sum += areas[v];
      squares += areas[v] * areas[v];
      ++count;
    }
  return sum > 0 ? std::max(0.0, count * squares / (sum * sum) - 1) : 0.0;
}

/// Var(E) of (2.51) per vertex of the mesh, over the squared mean edge.
Eigen::VectorXd edge_variances(const HalfedgeMesh& mesh) {
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(mesh.vertex_capacity());
  double total = 0;
  int count = 0;
  for (int v = 0; v < mesh.vertex_capacity(); ++v) {
    if (!mesh.has_vertex(v)) continue;
    double sum = 0, squares = 0;
    int d = 0;
    mesh.for_each_neighbour(v, [&](int u) {
      const double length = (mesh.position(u) - mesh.position(v)).norm();
      sum += length;
      squares += length * length;
      ++d;
    });
    variances[v] = std::max(0.0, squares / d - sum * sum / (d * d));
    total += sum;
    count += d;
  }
  const double mean = total / std::max(count, 1);
  return mean > 0 ? Eigen::VectorXd(variances / (mean * mean)) : variances;
}

/// Vertices where curvature is none of a smooth surface: on borders, and on edges that turn by more than
/// `crease_angle`, whose cotangent curvature is that of the edge and grows with the fineness of the mesh.
std::vector<char> left_out(const HalfedgeMesh& mesh, double crease_angle) {
  std::vector<char> result(mesh.vertex_capacity(), 0);
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.is_representative(h)) continue;
    bool out = mesh.is_border_edge(h);
    if (!out) {
      const Vector3d a = mesh.area_normal(HalfedgeMesh::face(h)),
                     b = mesh.area_normal(HalfedgeMesh::face(mesh.opposite(h)));
      out = std::atan2(a.cross(b).norm(), a.dot(b)) > crease_angle;
    }
    if (out) result[mesh.from(h)] = result[mesh.to(h)] = 1;
  }
  return result;
}

double variance(const Eigen::VectorXd& values, const std::vector<char>& left_out) {
  double sum = 0, squares = 0;
  int count = 0;
  for (Eigen::Index v = 0; v < values.size(); ++v)
    if (left_out[v] == 0) {
      sum += values[v];
      squares += values[v] * values[v];
      ++count;
    }
  return count > 0 ? squares / count - sum * sum / (static_cast<double>(count) * count) : 0.0;
}

double relative(double change, double before) {
  return before > 0 ? change / before : 0.0;
}

/// Mean angle between the normals of one surface and those of the nearest triangles of another, at random
/// points: centres of triangles are where a remeshing may have fitted them.
double normal_error(const TriangleMesh& from, const TriangleMesh& to, const TriangleTree& to_tree) {
  const Points normals = face_normals(from.positions, from.triangles);
  const Points to_normals = face_normals(to.positions, to.triangles);
  const Eigen::VectorXd areas = face_areas(from.positions, from.triangles);
  Random random(1);
  Points points(kNormalSamples, 3);
  std::vector<Eigen::Index> triangle(kNormalSamples);
  const double step = areas.sum() / kNormalSamples;
  if (!(step > 0)) return 0;
  Eigen::Index f = 0;
  double below = 0;
  for (int s = 0; s < kNormalSamples; ++s) {
    // One point in every one of equal shares of the area.
    const double at = (s + random.uniform()) * step;
    while (f + 1 < areas.size() && below + areas[f] < at) below += areas[f++];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const auto corner = [&](int k) { return from.positions.row(from.triangles(f, k)); };
    points.row(s) = (1 - u - v) * corner(0) + u * corner(1) + v * corner(2);
    triangle[s] = f;
  }
  const std::vector<ClosestPoint> closest = to_tree.closest(points);
  double sum = 0;
  for (int s = 0; s < kNormalSamples; ++s) {
    const Vector3d a = normals.row(triangle[s]), b = to_normals.row(closest[s].element);
    sum += std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return sum / kNormalSamples;
}

/// The mesh with only the vertices that triangles use, so that numbers agree between all that is measured.
TriangleMesh compacted(const TriangleMesh& mesh) {
  const HalfedgeMesh::Compact compact =
      HalfedgeMesh(mesh.positions, mesh.triangles, NonManifoldVertices::Split).compacted();
  TriangleMesh result;
  result.positions = compact.positions;
  result.triangles = compact.triangles;
  return result;
}

}  // namespace

RemeshMeasures remesh_measures(const TriangleMesh& original, const TriangleMesh& result, double crease_angle,
                               const Progress& progress) {
  if (original.n_triangles() == 0 || result.n_triangles() == 0)
    throw InvalidInput("there are no triangles to measure");
  progress.report("measuring", 0);
  const TriangleMesh before = compacted(original), after = compacted(result);
  RemeshMeasures measures;
  measures.original_area_variance = area_variance(before);
  measures.area_variance = area_variance(after);
  measures.area_variance_change = relative(std::abs(measures.area_variance - measures.original_area_variance),
                                           measures.original_area_variance);

  // The nearest vertex by the tree of segments, whose ends may be the same.
  Segments vertices(after.n_vertices(), 2);
  for (Eigen::Index v = 0; v < after.n_vertices(); ++v) vertices.row(v).setConstant(static_cast<int>(v));
  const std::vector<ClosestPoint> nearest = SegmentTree(after.positions, vertices).closest(before.positions);
  const Curvatures curvature = discrete_curvatures(after.positions, after.triangles);
  const Curvatures curvature_before = discrete_curvatures(before.positions, before.triangles);
  const HalfedgeMesh connected(after.positions, after.triangles),
      connected_before(before.positions, before.triangles);
  const Eigen::VectorXd edges = edge_variances(connected), edges_before = edge_variances(connected_before);
  const std::vector<char> out = left_out(connected, crease_angle),
                          out_before = left_out(connected_before, crease_angle);
  double change = 0, size = 0, edge_change = 0;
  for (Eigen::Index v = 0; v < before.n_vertices(); ++v) {
    const Eigen::Index u = nearest[v].element;
    edge_change += std::pow(edges[u] - edges_before[v], 2);
    if (out_before[v] != 0 || out[u] != 0) continue;
    change += std::pow(curvature.mean[u] - curvature_before.mean[v], 2);
    size += std::pow(curvature_before.mean[v], 2);
  }
  const double diameter = bounding_box_diagonal(before.positions);
  // A flat surface has no curvature but rounding, which says nothing.
  const double rounding = 1e-9 * std::sqrt(static_cast<double>(before.n_vertices()));
  if (std::sqrt(size) * diameter > rounding)
    measures.curvature_change = relative(std::sqrt(change), std::sqrt(size));
  measures.edge_variance_change = relative(std::sqrt(edge_change), edges_before.norm());
  const double spread = variance(curvature_before.mean, out_before);
  measures.curvature_variance_change = relative(std::abs(variance(curvature.mean, out) - spread), spread);

  progress.report("measuring", 0.5);
  const TriangleTree tree(after.positions, after.triangles);
  if (diameter > 0) measures.mean_distance = distances(tree.closest(before.positions)).mean() / diameter;

  measures.normal_error = normal_error(before, after, tree);
  return measures;
}

}  // namespace batten
