#include "batten/remeshing/measures.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/remeshing/area_samples.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Points of the original whose normals are compared.
constexpr double kNormalSamples = 1e5;

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

RemeshMeasures remesh_measures(const TriangleMesh& original, const TriangleMesh& result,
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
  const Eigen::VectorXd edges = edge_variances(HalfedgeMesh(after.positions, after.triangles));
  const Eigen::VectorXd edges_before = edge_variances(HalfedgeMesh(before.positions, before.triangles));
  double change = 0, size = 0, edge_change = 0;
  for (Eigen::Index v = 0; v < before.n_vertices(); ++v) {
    const Eigen::Index u = nearest[v].element;
    edge_change += std::pow(edges[u] - edges_before[v], 2);
    if (curvature_before.on_border[v] != 0 || curvature.on_border[u] != 0) continue;
    change += std::pow(curvature.mean[u] - curvature_before.mean[v], 2);
    size += std::pow(curvature_before.mean[v], 2);
  }
  measures.curvature_change = relative(std::sqrt(change), std::sqrt(size));
  measures.edge_variance_change = relative(std::sqrt(edge_change), edges_before.norm());
  const double spread = variance(curvature_before.mean, curvature_before.on_border);
  measures.curvature_variance_change =
      relative(std::abs(variance(curvature.mean, curvature.on_border) - spread), spread);

  progress.report("measuring", 0.5);
  const TriangleTree tree(after.positions, after.triangles);
  const double diameter = bounding_box_diagonal(before.positions);
  if (diameter > 0) measures.mean_distance = distances(tree.closest(before.positions)).mean() / diameter;

  double area = 0;
  for (const AreaSample& sample : area_samples(before.positions, before.triangles, 1e300))
    area += sample.area;
  const std::vector<AreaSample> samples =
      area_samples(before.positions, before.triangles, area / kNormalSamples);
  Points points(static_cast<Eigen::Index>(samples.size()), 3);
  for (std::size_t s = 0; s < samples.size(); ++s)
    points.row(static_cast<Eigen::Index>(s)) = samples[s].point;
  const std::vector<ClosestPoint> closest = tree.closest(points);
  double sum = 0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Eigen::Index f = closest[s].element;
    const Vector3d a = after.positions.row(after.triangles(f, 0)),
                   b = after.positions.row(after.triangles(f, 1)),
                   c = after.positions.row(after.triangles(f, 2));
    const Vector3d normal = (b - a).cross(c - a);
    sum +=
        samples[s].area * std::atan2(samples[s].normal.cross(normal).norm(), samples[s].normal.dot(normal));
  }
  if (area > 0) measures.normal_error = sum / area;
  return measures;
}

}  // namespace batten
