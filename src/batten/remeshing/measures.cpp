#include "batten/remeshing/measures.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/mesh_variation.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Points of the original whose normals are compared.
constexpr int kNormalSamples = 100000;

/// 0 for a ratio to nothing: what was flat, or even, and is so still.
double known(double ratio) {
  return std::isfinite(ratio) ? ratio : 0.0;
}

/// Mean angle between the normals of one surface and those of the nearest triangles of another, at random
/// points: centres of triangles are where a remeshing may have fitted them.
double normal_error(const TriangleMesh& from, const TriangleMesh& to, const TriangleTree& to_tree,
                    const Progress& progress) {
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
  const std::vector<ClosestPoint> closest = to_tree.closest(points, progress);
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
  measures.original_area_variance = area_variance(before.positions, before.triangles);
  measures.area_variance = area_variance(after.positions, after.triangles);
  MeshVariationOptions options;
  options.original_left_out = vertices_on_creases(before.positions, before.triangles, crease_angle);
  options.left_out = vertices_on_creases(after.positions, after.triangles, crease_angle);
  options.relative_edges = true;
  const MeshVariation variation =
      mesh_variation(before.positions, before.triangles, after.positions, after.triangles, options,
                     progress.part("measuring", 0.1, 0.5));
  measures.curvature_change = known(variation.mean_curvature);
  measures.edge_variance_change = known(variation.edge_variance);
  measures.area_variance_change = known(variation.area_variance);
  measures.curvature_variance_change = known(variation.curvature_variance);

  progress.report("measuring", 0.5);
  const TriangleTree tree(after.positions, after.triangles);
  const double diameter = bounding_box_diagonal(before.positions);
  if (diameter > 0)
    measures.mean_distance =
        distances(tree.closest(before.positions, progress.part("measuring", 0.5, 0.8))).mean() / diameter;

  progress.report("measuring", 0.8);
  measures.normal_error = normal_error(before, after, tree, progress.part("measuring", 0.8, 1));
  return measures;
}

}  // namespace batten
