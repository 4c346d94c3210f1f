#include "batten/implicit/slope_search.hpp"

#include "implicit/strokes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// Sites on three great circles of the unit sphere and, where it is closed, one place outside that says which
/// side is which.
FieldConditions circles_of_a_sphere(int n, bool closed) {
  FieldConditions conditions;
  conditions.sites.resize(3 * n + (closed ? 6 : 0), 3);
  conditions.across.resize(3 * n, 3);
  conditions.aside.resize(3 * n, 3);
  for (int k = 0; k < 3 * n; ++k) {
    const int axis = k % 3;
    const double a = test::kTurn * (k / 3 + 0.3) / n;
    Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
    x[(axis + 1) % 3] = std::cos(a);
    x[(axis + 2) % 3] = std::sin(a);
    conditions.sites.row(k) = x;
    // Turned by any angle: the search must not depend on it.
    const Eigen::RowVector3d side = Eigen::RowVector3d::Unit(axis);
    conditions.across.row(k) = std::cos(k) * x + std::sin(k) * side;
    conditions.aside.row(k) = -std::sin(k) * x + std::cos(k) * side;
  }
  conditions.values = Eigen::VectorXd::Zero(conditions.sites.rows());
  conditions.smoothing = Eigen::VectorXd::Constant(conditions.sites.rows(), 1e-6);
  for (int k = 0; closed && k < 6; ++k) {
    conditions.sites.row(3 * n + k) = (k < 3 ? 1.6 : -1.6) * Eigen::RowVector3d::Unit(k % 3);
    conditions.values[3 * n + k] = 0.6;
  }
  return conditions;
}

Points normals_of(const FieldConditions& conditions, const FoundSlopes& found) {
  Points normals(conditions.across.rows(), 3);
  for (Eigen::Index j = 0; j < normals.rows(); ++j)
    normals.row(j) =
        found.slopes[2 * j] * conditions.across.row(j) + found.slopes[2 * j + 1] * conditions.aside.row(j);
  return normals;
}

TEST(FindSlopes, PointOutOfASphereWhoseOutsideIsKnown) {
  const FieldConditions conditions = circles_of_a_sphere(12, true);
  const FoundSlopes found = find_slopes(SlopeEnergy(conditions));
  const Points normals = normals_of(conditions, found);
  for (Eigen::Index j = 0; j < normals.rows(); ++j) {
    EXPECT_NEAR(normals.row(j).norm(), 1, 1e-12);
    EXPECT_GT(normals.row(j).dot(conditions.sites.row(j)), std::cos(2 * test::kTurn / 360)) << j;
  }
}

// Without an outside they point all out or all in.
TEST(FindSlopes, AgreeOnASideWhereNoneIsKnown) {
  const FieldConditions conditions = circles_of_a_sphere(12, false);
  const Points normals = normals_of(conditions, find_slopes(SlopeEnergy(conditions)));
  const double side = normals.row(0).dot(conditions.sites.row(0)) > 0 ? 1 : -1;
  for (Eigen::Index j = 0; j < normals.rows(); ++j)
    EXPECT_GT(side * normals.row(j).dot(conditions.sites.row(j)), std::cos(2 * test::kTurn / 360)) << j;
}

TEST(FindSlopes, GoDownFromAnyStartAndTellTheEnergy) {
  const FieldConditions conditions = circles_of_a_sphere(8, true);
  const SlopeEnergy energy(conditions);
  Random random(2);
  Eigen::VectorXd start(energy.n_slopes());
  for (double& s : start) s = random.normal();
  const FoundSlopes found = descended_slopes(energy, start);
  const auto energy_of = [&](const Eigen::VectorXd& s) {
    return s.dot(energy.hessian() * s) + 2 * energy.pull().dot(s);
  };
  EXPECT_NEAR(found.energy, energy_of(found.slopes), 1e-6 * std::abs(found.energy));
  for (Eigen::Index j = 0; j + 1 < start.size(); j += 2) start.segment<2>(j).normalize();
  EXPECT_LT(found.energy, energy_of(start));
  EXPECT_LE(find_slopes(energy).energy, found.energy + 1e-6 * std::abs(found.energy));
  EXPECT_EQ(find_slopes(energy).slopes, find_slopes(energy).slopes);
}

TEST(FindSlopes, CanBeCancelled) {
  const SlopeEnergy energy(circles_of_a_sphere(8, true));
  EXPECT_THROW(find_slopes(energy, Progress([](std::string_view, double) { return false; })), Cancelled);
}

}  // namespace
}  // namespace batten
