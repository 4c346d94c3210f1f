#include "batten/mesh/compare.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

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

DirectedComparison measure(const Shape& from, const ShapeTree& to, const CompareOptions& options,
                           std::uint64_t stream) {
  DirectedComparison result;
  const std::vector<int> vertices = used_vertices(from);
  Points used(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    used.row(static_cast<Eigen::Index>(i)) = from.positions.row(vertices[i]);
  const Eigen::VectorXd at_vertices = distances(to.closest(used));
  result.vertices = distance_figures(at_vertices);
  result.vertex_distances =
      Eigen::VectorXd::Constant(from.positions.rows(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    result.vertex_distances[vertices[i]] = at_vertices[static_cast<Eigen::Index>(i)];
  Random random(options.seed, stream);
  result.samples = distance_figures(distances(to.closest(sample_uniformly(from, options.samples, random))));
  return result;
}

}  // namespace

Comparison compare(const Shape& a, const Shape& b, const CompareOptions& options, const Progress& progress) {
  if (options.samples < 1) throw InvalidInput(concat("samples must be at least 1, got ", options.samples));
  Comparison comparison;
  const ShapeTree tree_b(b);
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
  progress.report("compare", 0);
  comparison.a_to_b = measure(moved, tree_b, options, 3);
  progress.report("compare", 0.5);
  comparison.b_to_a = measure(b, ShapeTree(moved), options, 4);
  return comparison;
}

}  // namespace batten
