#include "batten/operators/mesh_variation.hpp"

#include "operators/sample_meshes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

// Of the four corners of a unit square with one diagonal: two edges of length 1, or 1, 1 and √2, whose
// variance is that of (0, 0, √2 − 1): (√2 − 1)² · 2/9.
TEST(EdgeLengthVariances, AreExactOnASquareWithADiagonal) {
  const TriangleMesh mesh = samples::square(2);
  const Eigen::VectorXd variances = edge_length_variances(mesh.positions, mesh.triangles);
  const double at_diagonal = std::pow(std::sqrt(2.0) - 1, 2) * 2 / 9;
  EXPECT_NEAR(variances[0], at_diagonal, 1e-15);
  EXPECT_NEAR(variances[3], at_diagonal, 1e-15);
  EXPECT_NEAR(variances[1], 0, 1e-15);
  EXPECT_NEAR(variances[2], 0, 1e-15);
}

// Mixed Voronoi areas of the square of 3 × 3 vertices: the middle owns 1/4, sides 1/8, corners 1/16 of 1.
// Mean 1/9, mean square (1/16 + 4/64 + 4/256)/9; whatever the unit.
TEST(AreaVariance, IsExactOnAGridAndFreeOfTheUnit) {
  const TriangleMesh mesh = samples::square(3);
  const double expected = 81 * (1.0 / 16 + 4.0 / 64 + 4.0 / 256) / 9 - 1;
  EXPECT_NEAR(area_variance(mesh.positions, mesh.triangles), expected, 1e-14);
  EXPECT_NEAR(area_variance(1e3 * mesh.positions, mesh.triangles), expected, 1e-14);
  EXPECT_EQ(area_variance(Points(0, 3), Triangles(0, 3)), 0);
}

// Vertices in reverse order are the same mesh.
TEST(MeshVariation, VanishesForTheSameSurfaceWithOtherNumbers) {
  const TriangleMesh mesh = samples::torus(12);
  const auto last = static_cast<int>(mesh.n_vertices()) - 1;
  const Points reversed = mesh.positions.colwise().reverse();
  const Triangles renumbered = (last - mesh.triangles.array()).matrix();
  const MeshVariation variation = mesh_variation(mesh.positions, mesh.triangles, reversed, renumbered);
  EXPECT_NEAR(variation.mean_curvature, 0, 1e-9);
  EXPECT_NEAR(variation.edge_variance, 0, 1e-9);
  EXPECT_NEAR(variation.area_variance, 0, 1e-9);
  EXPECT_NEAR(variation.curvature_variance, 0, 1e-9);
}

// Twice as large: H is halved, a change of 1/2; lengths and their variance grow by 2 and 4, a change of 3;
// Var(H) falls to a quarter, a change of 3/4; the relative variance of areas stays. The shape is centred, so
// that every vertex of the small one is matched with its own image or with one of the same curvature at most.
TEST(MeshVariation, IsExactForAScaledSphereAndTorus) {
  const TriangleMesh sphere = samples::octasphere(6, 1);
  const MeshVariation s =
      mesh_variation(sphere.positions, sphere.triangles, 2 * sphere.positions, sphere.triangles);
  EXPECT_NEAR(s.mean_curvature, 0.5, 1e-9);
  EXPECT_NEAR(s.edge_variance, 3, 1e-9);
  EXPECT_NEAR(s.area_variance, 0, 1e-9);
  EXPECT_NEAR(s.curvature_variance, 0.75, 1e-9);
}

// The same torus with half as many vertices: H and H0 are estimates of one function, so that the change is
// that of the discretisation and of the distance to the nearest vertex, and falls in proportion to the edges.
TEST(MeshVariation, OfACoarserMeshOfTheSameSurfaceFallsWithTheEdges) {
  const auto change = [](int n) {
    const TriangleMesh fine = samples::torus(2 * n), coarse = samples::torus(n);
    return mesh_variation(fine.positions, fine.triangles, coarse.positions, coarse.triangles).mean_curvature;
  };
  const double at_16 = change(16), at_32 = change(32);
  EXPECT_LT(at_16, 0.2);
  EXPECT_NEAR(at_16 / at_32, 2, 0.5);
}

// A flat mesh has no curvature to compare with: that figure is undefined, the others stand.
TEST(MeshVariation, HasNoRatioToNothing) {
  const TriangleMesh flat = samples::square(5, 0.3), even = samples::square(5);
  const MeshVariation variation =
      mesh_variation(flat.positions, flat.triangles, even.positions, even.triangles);
  EXPECT_TRUE(std::isnan(variation.mean_curvature));
  EXPECT_TRUE(std::isnan(variation.curvature_variance));
  EXPECT_GT(variation.area_variance, 0);
  EXPECT_GT(variation.edge_variance, 0);
  EXPECT_THROW(mesh_variation(flat.positions, flat.triangles, Points(0, 3), Triangles(0, 3)), InvalidInput);
}

// Twice the size, every variance fourfold: over the squared mean edge the same. The sphere about its own
// middle, so that every vertex has its image or one like it as the nearest.
TEST(MeshVariation, OfEdgesIsFreeOfTheSizeWhereAsked) {
  const TriangleMesh mesh = samples::octasphere(6, 1);
  const Points large = 2 * mesh.positions;
  EXPECT_NEAR(
      mesh_variation(mesh.positions, mesh.triangles, large, mesh.triangles, {{}, {}, true}).edge_variance, 0,
      1e-9);
}

// One vertex of a sphere pulled out changes the curvature there and at its neighbours, and nowhere else. With
// these left out on both sides nothing is left.
TEST(MeshVariation, DoesNotCountWhatIsLeftOut) {
  const TriangleMesh sphere = samples::octasphere(6, 1);
  Points pulled = sphere.positions;
  const int at = 5;
  pulled.row(at) *= 1.05;
  MeshVariationOptions options;
  EXPECT_GT(
      mesh_variation(sphere.positions, sphere.triangles, pulled, sphere.triangles, options).mean_curvature,
      0.01);
  options.original_left_out.assign(sphere.n_vertices(), 0);
  for (Eigen::Index f = 0; f < sphere.n_triangles(); ++f)
    if ((sphere.triangles.row(f).array() == at).any())
      for (int k = 0; k < 3; ++k) options.original_left_out[sphere.triangles(f, k)] = 1;
  options.left_out = options.original_left_out;
  const MeshVariation rest =
      mesh_variation(sphere.positions, sphere.triangles, pulled, sphere.triangles, options);
  EXPECT_NEAR(rest.mean_curvature, 0, 1e-12);
  EXPECT_NEAR(rest.curvature_variance, 0, 1e-9);
  options.left_out.pop_back();
  EXPECT_THROW(mesh_variation(sphere.positions, sphere.triangles, pulled, sphere.triangles, options),
               InvalidInput);
}

TEST(MeshVariation, NamesTheListThatDoesNotFitItsMesh) {
  MeshVariationOptions options;
  EXPECT_EQ(options.problem(4, 5), std::nullopt);
  options.original_left_out.assign(4, 0);
  options.left_out.assign(5, 0);
  EXPECT_EQ(options.problem(4, 5), std::nullopt);
  EXPECT_EQ(options.problem(4, 6),
            "left_out must have an entry per vertex or none, got 5 entries for 6 vertices");
  EXPECT_EQ(options.problem(3, 5),
            "original_left_out must have an entry per vertex or none, got 4 entries for 3 vertices");
}

// Two triangles over the unit square, folded by 40° along their diagonal: its two ends, above 40° none.
TEST(VerticesOnCreases, AreThoseOfEdgesThatTurnByMore) {
  TriangleMesh mesh = samples::square(2);
  const double fold = 40 * kPi / 180;
  // Corner 1 turned about the diagonal from 0 to 3, which it is 1/√2 away from.
  const Eigen::RowVector3d middle(0.5, 0.5, 0), out = mesh.positions.row(1) - middle;
  mesh.positions.row(1) =
      middle + std::cos(fold) * out + Eigen::RowVector3d(0, 0, std::sin(fold) / std::sqrt(2.0));
  EXPECT_EQ(vertices_on_creases(mesh.positions, mesh.triangles, fold - 0.01),
            (std::vector<char>{1, 0, 0, 1}));
  EXPECT_EQ(vertices_on_creases(mesh.positions, mesh.triangles, fold + 0.01), std::vector<char>(4, 0));
}

}  // namespace
}  // namespace batten
