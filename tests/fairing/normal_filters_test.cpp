#include "batten/fairing/normal_filters.hpp"

#include "fairing/shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/noise.hpp"

namespace batten {
namespace {

using fixtures::cube;
using fixtures::Mesh;

// On a clean cube the normals across an edge differ by √2, four times the range: their weight is e^−8 in each
// of the twenty passes, so hardly anything changes.
TEST(BilateralNormals, LeaveACubeAlone) {
  const Mesh mesh = cube(8);
  const Points normals = face_normals(mesh.positions, mesh.triangles);
  EXPECT_LT((bilateral_normals(mesh.positions, mesh.triangles) - normals).rowwise().norm().maxCoeff(), 0.03);
}

// Published results: on polyhedra at this noise both end at a few degrees, the noise being some 12°.
TEST(NormalFilters, RecoverTheNormalsOfANoisyCube) {
  const Mesh mesh = cube(16);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.1, 5);
  const double before = fixtures::normal_error_deg(noisy, mesh.positions, mesh.triangles);
  for (const bool guided : {false, true}) {
    const Points normals =
        guided ? guided_normals(noisy, mesh.triangles) : bilateral_normals(noisy, mesh.triangles);
    EXPECT_NEAR((normals.rowwise().norm().array() - 1).abs().maxCoeff(), 0, 1e-12);
    const Points X = move_to_normals(noisy, mesh.triangles, normals, 10);
    EXPECT_LT(fixtures::normal_error_deg(X, mesh.positions, mesh.triangles), 0.3 * before) << guided;
  }
}

// Given the exact normals, both refits find the clean shape up to what noise leaves open.
TEST(NormalFilters, RefitsFollowExactNormals) {
  const Mesh mesh = cube(10);
  const Points normals = face_normals(mesh.positions, mesh.triangles);
  EXPECT_LT((refit_to_normals(mesh.positions, mesh.triangles, normals, 0.1) - mesh.positions).norm(), 1e-9);
  EXPECT_LT((move_to_normals(mesh.positions, mesh.triangles, normals, 5) - mesh.positions).norm(), 1e-9);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 5);
  for (const Points& X : {refit_to_normals(noisy, mesh.triangles, normals, 1e-3),
                          move_to_normals(noisy, mesh.triangles, normals, 200)})
    EXPECT_LT(fixtures::normal_error_deg(X, mesh.positions, mesh.triangles), 1.0);
}

TEST(NormalFilters, KeepTheBorderWhenAsked) {
  const Mesh mesh = fixtures::sheet(6, 6, 1, 1);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 5);
  const Points normals = face_normals(mesh.positions, mesh.triangles);
  const Points moved = move_to_normals(noisy, mesh.triangles, normals, 10, true);
  const Points refitted = refit_to_normals(noisy, mesh.triangles, normals, 0.1, true);
  for (int i = 0; i <= 6; ++i) {
    EXPECT_EQ(moved.row(i), noisy.row(i));
    EXPECT_EQ(refitted.row(i), noisy.row(i));
  }
}

TEST(NormalFilters, RefuseBadInput) {
  const Mesh mesh = cube(2);
  NormalFilterOptions options;
  options.range = 0;
  EXPECT_THROW(guided_normals(mesh.positions, mesh.triangles, options), InvalidInput);
  EXPECT_THROW(move_to_normals(mesh.positions, mesh.triangles, Points(3, 3), 1), InvalidInput);
  EXPECT_THROW(refit_to_normals(mesh.positions, mesh.triangles, Points(3, 3), 1), InvalidInput);
}

}  // namespace
}  // namespace batten
