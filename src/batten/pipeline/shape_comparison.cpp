#include "batten/pipeline/shape_comparison.hpp"

#include <algorithm>
#include <utility>

#include "batten/mesh/adjacency.hpp"

namespace batten {

namespace {

bool is_oriented_manifold(const Shape& shape) {
  if (!shape.is_surface()) return false;
  const MeshTopology topology = mesh_topology(shape.triangles, shape.positions.rows());
  return topology.is_manifold() && topology.is_oriented();
}

}  // namespace

Shape shape_of(const TriangleMesh& mesh) {
  return {mesh.positions, mesh.triangles, Segments(0, 2)};
}

Shape shape_of(const CurveNetwork& network) {
  Eigen::Index n = 0;
  for (const NetworkCurve& curve : network.curves) n += static_cast<Eigen::Index>(curve.vertices.size()) - 1;
  Shape shape{network.positions, Triangles(0, 3), Segments(n, 2)};
  Eigen::Index s = 0;
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i)
      shape.segments.row(s++) << curve.vertices[i], curve.vertices[i + 1];
  return shape;
}

ShapeComparison compared_shapes(const Shape& a, const Shape& b, const CompareOptions& options,
                                const Progress& progress) {
  ShapeComparison result;
  {
    const ScopedStage stage(result.times, "compare");
    result.distances = compare(a, b, options, progress);
  }
  const DirectedComparison &there = result.distances.a_to_b, &back = result.distances.b_to_a;
  result.hausdorff = std::max({there.samples.max, there.vertices.max, back.samples.max, back.vertices.max});
  if (!result.distances.registration.converged)
    result.warnings.emplace_back(
        "the registration stopped before it had converged; the distances may be too large");
  if (a.is_surface() && b.is_surface()) {
    const ScopedStage stage(result.times, "variation");
    if (is_oriented_manifold(a) && is_oriented_manifold(b))
      result.variation =
          mesh_variation(b.positions, b.triangles, result.distances.registration.transform(a.positions),
                         a.triangles, {}, progress);
  }
  return result;
}

TriangleMesh measured_mesh(TriangleMesh a, const Comparison& distances) {
  const SimilarityTransform& transform = distances.registration.transform;
  a.positions = transform(a.positions);
  if (a.normals.rows() > 0) a.normals = transform.rotated(a.normals);
  a.vertex_values["distance"] = distances.a_to_b.vertex_distances;
  return a;
}

TruthErrors truth_errors(const Shape& made, const Shape& truth, RegistrationKind registration,
                         const Progress& progress) {
  CompareOptions options;
  options.registration = registration;
  const Comparison found = compare(made, truth, options, progress);
  const double percent = 100 / found.diameter;
  TruthErrors errors;
  errors.diameter = found.diameter;
  errors.vertices = percent * found.a_to_b.vertex_distances;
  errors.figures = errors.lengths = found.a_to_b.vertices;
  for (double* value : {&errors.figures.max, &errors.figures.mean, &errors.figures.rms}) *value *= percent;
  errors.normal_angles = found.a_to_b.normal_angles;
  return errors;
}

}  // namespace batten
