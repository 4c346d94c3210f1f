#include "batten/mesh/compare.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

DistanceFigures distance_figures(const Eigen::VectorXd& distances) {
  DistanceFigures figures;
  figures.count = distances.size();
  if (distances.size() == 0) return figures;
  figures.max = distances.maxCoeff();
  figures.mean = distances.mean();
  // Scaled before squaring, so that sizes of 1e-200 and 1e200 are no trouble.
  if (figures.max > 0)
    figures.rms = figures.max * std::sqrt((distances / figures.max).squaredNorm() / distances.size());
  return figures;
}

namespace {

/// Angles between the normals of pairs of faces; pairs with a face without area are left out.
Eigen::VectorXd normal_angles(const Shape& from, const std::vector<int>& faces, const Shape& to,
                              const std::vector<ClosestPoint>& nearest) {
  const Points n = face_normals(from.positions, from.triangles), m = face_normals(to.positions, to.triangles);
  Eigen::VectorXd angles(static_cast<Eigen::Index>(faces.size()));
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Eigen::RowVector3d a = n.row(faces[i]), b = m.row(nearest[i].element);
    if (a.squaredNorm() > 0 && b.squaredNorm() > 0) angles[count++] = std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return angles.head(count);
}

DirectedComparison measure(const Shape& from, const Shape& to_shape, const ShapeTree& to,
                           const CompareOptions& options, std::uint64_t stream, const Progress& progress) {
  DirectedComparison result;
  progress.report("compare", 0);
  const std::vector<int> vertices = used_vertices(from);
  Points used(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    used.row(static_cast<Eigen::Index>(i)) = from.positions.row(vertices[i]);
  const Eigen::VectorXd at_vertices = distances(to.closest(used, progress.part("compare", 0, 0.5)));
  result.vertices = distance_figures(at_vertices);
  result.vertex_distances =
      Eigen::VectorXd::Constant(from.positions.rows(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    result.vertex_distances[vertices[i]] = at_vertices[static_cast<Eigen::Index>(i)];
  Random random(options.seed, stream);
  std::vector<int> elements;
  const Points samples = sample_uniformly(from, options.samples, random, &elements);
  const std::vector<ClosestPoint> nearest = to.closest(samples, progress.part("compare", 0.5, 1));
  result.samples = distance_figures(distances(nearest));
  if (from.is_surface() && to_shape.is_surface())
    result.normal_angles = distance_figures(normal_angles(from, elements, to_shape, nearest));
  return result;
}

}  // namespace

std::optional<std::string> CompareOptions::problem() const {
  if (samples < 1) return concat("samples must be at least 1, got ", samples);
  return std::nullopt;
}

Comparison compare(const Shape& a, const Shape& b, const CompareOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  Comparison comparison;
  progress.report("compare", 0);
  const ShapeTree tree_b(b);
  progress.report("compare", 0);
  { const ShapeTree check(a); }
  comparison.diameter = diameter(b);
  if (!(comparison.diameter > 0))
    throw InvalidInput("the second shape is a single point, so it has no diameter");
  Shape moved = a;
  if (options.registration != RegistrationKind::None) {
    RegistrationOptions registration;
    registration.kind = options.registration;
    registration.seed = options.seed;
    registration.samples = options.registration_samples;
    comparison.registration = register_shapes(a, b, registration, progress);
    moved.positions = comparison.registration.transform(a.positions);
  } else {
    comparison.registration.converged = true;
  }
  comparison.a_to_b = measure(moved, b, tree_b, options, 3, progress.part("compare", 0, 0.5));
  progress.report("compare", 0.5);
  const ShapeTree tree_a(moved);
  comparison.b_to_a = measure(b, moved, tree_a, options, 4, progress.part("compare", 0.5, 1));
  return comparison;
}

}  // namespace batten
