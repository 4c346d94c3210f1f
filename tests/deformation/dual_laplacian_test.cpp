#include "batten/deformation/dual_laplacian.hpp"

#include "mesh/shapes.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {
namespace {

/// A torus, whose normals spread in every ring: (2 + cos v) wide.
Shape torus() {
  return fixtures::grid(24, 12, true, true, [](double u, double v) {
    const double a = 2 * M_PI * u, b = 2 * M_PI * v;
    return Eigen::Vector3d((2 + std::cos(b)) * std::cos(a), (2 + std::cos(b)) * std::sin(a), std::sin(b));
  });
}

/// Vectors of any length along the normals, outwards and inwards, and a little beside them.
Points about_normals(const Shape& shape) {
  Random random(6);
  Points vectors = vertex_normals(shape.positions, shape.triangles);
  for (Eigen::Index v = 0; v < vectors.rows(); ++v)
    vectors.row(v) = random.uniform(-2, 2) * (vectors.row(v) + 0.03 * random.normal3().transpose());
  return vectors;
}

// Of the shape itself the vectors come back; of a turned one they come turned; a larger one keeps their
// lengths (H 2.77).
TEST(DualLaplacian, VectorsTurnWithTheSurfaceAndKeepTheirLength) {
  const Shape shape = torus();
  const Points delta = about_normals(shape);
  const DualLaplacian dual(shape.positions, shape.triangles, delta);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, -2, 0.5).normalized()).matrix();
  Points same, turned, larger;
  dual.evaluate(shape.positions, same);
  dual.evaluate(shape.positions * R.transpose(), turned);
  dual.evaluate(3 * shape.positions, larger);
  int followed = 0;
  for (Eigen::Index v = 0; v < delta.rows(); ++v) {
    if (!dual.followed()[static_cast<size_t>(v)]) {
      EXPECT_EQ(same.row(v).norm(), 0) << v;
      continue;
    }
    ++followed;
    EXPECT_LT((same.row(v) - delta.row(v)).norm(), 0.16 * delta.row(v).norm()) << v;
    EXPECT_NEAR(same.row(v).norm(), delta.row(v).norm(), 1e-12);
    EXPECT_LT((turned.row(v) - same.row(v) * R.transpose()).norm(), 1e-9) << v;
    EXPECT_LT((larger.row(v) - same.row(v)).norm(), 1e-9) << v;
  }
  EXPECT_GT(followed, 9 * delta.rows() / 10);
}

// Vectors along the normals are expressed exactly, also where the surface is flat; vectors within a flat
// surface not at all, and it is said.
TEST(DualLaplacian, SaysWhereTheNormalsCannotExpressAVector) {
  const Shape flat =
      fixtures::grid(5, 5, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  Points up = Points::Zero(flat.positions.rows(), 3), along = up, result;
  up.col(2).setConstant(0.25);
  along.col(0).setConstant(0.25);
  const DualLaplacian upright(flat.positions, flat.triangles, up),
      within(flat.positions, flat.triangles, along);
  EXPECT_TRUE(
      std::all_of(upright.followed().begin(), upright.followed().end(), [](char f) { return f == 1; }));
  upright.evaluate(flat.positions, result);
  EXPECT_LT((result - up).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(std::all_of(within.followed().begin(), within.followed().end(), [](char f) { return f == 0; }));
  within.evaluate(flat.positions, result);
  EXPECT_EQ(result.cwiseAbs().maxCoeff(), 0);
}

}  // namespace
}  // namespace batten
