#include "batten/remeshing/regularization.hpp"

#include "remeshing/surfaces.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

using fixtures::cube;

// Diffusion moves area, it makes none; with one curvature everywhere it evens areas out.
TEST(RegularizedAreas, KeepTheTotalAndBecomeMoreEven) {
  const TriangleMesh input = cube(6);
  const SparseMatrix K = clamped_stiffness(input.triangles, edge_lengths(input.positions, input.triangles),
                                           input.positions.rows());
  Random random(9);
  Eigen::VectorXd areas(input.n_vertices());
  for (Eigen::Index v = 0; v < areas.size(); ++v) areas[v] = 1 + random.uniform();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(areas.size());
  const Eigen::VectorXd even = regularized_areas(K, areas, Eigen::VectorXd::Zero(areas.size()), ones).areas;
  EXPECT_NEAR(even.sum(), areas.sum(), 1e-9);
  const auto variance = [](const Eigen::VectorXd& a) { return (a.array() - a.mean()).square().mean(); };
  EXPECT_LT(variance(even), 0.5 * variance(areas));
  // Where curvature differs wildly from vertex to vertex, the weights stop nearly all of it (2.30).
  Eigen::VectorXd H(areas.size());
  for (Eigen::Index v = 0; v < H.size(); ++v) H[v] = random.uniform();
  EXPECT_GT(variance(regularized_areas(K, areas, H, ones, 1e-6).areas), 0.5 * variance(areas));
}

}  // namespace
}  // namespace batten
