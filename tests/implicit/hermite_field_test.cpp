#include "batten/implicit/hermite_field.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

/// Random sites with random perpendicular directions at the first n.
FieldConditions random_conditions(int m, int n, double smoothing = 0) {
  Random random(3);
  FieldConditions conditions;
  conditions.sites.resize(m, 3);
  conditions.values.resize(m);
  conditions.smoothing = Eigen::VectorXd::Constant(m, smoothing);
  conditions.across.resize(n, 3);
  conditions.aside.resize(n, 3);
  for (int i = 0; i < m; ++i) {
    conditions.sites.row(i) = random.normal3();
    conditions.values[i] = random.normal();
  }
  for (int j = 0; j < n; ++j) {
    const Eigen::Vector3d u = random.direction(), v = u.cross(random.direction()).normalized();
    conditions.across.row(j) = u;
    conditions.aside.row(j) = v;
  }
  return conditions;
}

Eigen::VectorXd random_slopes(Eigen::Index n) {
  Random random(9);
  Eigen::VectorXd slopes(n);
  for (double& s : slopes) s = random.normal();
  return slopes;
}

TEST(HermiteField, HasTheValuesAndSlopesThatWereAsked) {
  const FieldConditions conditions = random_conditions(40, 25);
  const SlopeEnergy energy(conditions);
  const Eigen::VectorXd slopes = random_slopes(energy.n_slopes());
  const HermiteField field = energy.field(slopes);
  for (Eigen::Index i = 0; i < conditions.sites.rows(); ++i) {
    Eigen::Vector3d gradient;
    EXPECT_NEAR(field.value(conditions.sites.row(i).transpose(), gradient), conditions.values[i], 1e-8);
    if (i >= conditions.across.rows()) continue;
    EXPECT_NEAR(gradient.dot(conditions.across.row(i).transpose()), slopes[2 * i], 1e-7);
    EXPECT_NEAR(gradient.dot(conditions.aside.row(i).transpose()), slopes[2 * i + 1], 1e-7);
  }
}

TEST(HermiteField, GradientIsThatOfDifferencesAndTheValueTheSameWithoutIt) {
  const SlopeEnergy energy(random_conditions(200, 150));  // more sites than are taken at a time
  const HermiteField field = energy.field(random_slopes(energy.n_slopes()));
  Random random(4);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d x = random.normal3();
    Eigen::Vector3d gradient;
    const double f = field.value(x, gradient);
    EXPECT_NEAR(field.value(x), f, 1e-9 * (1 + std::abs(f)));
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(i);
      EXPECT_NEAR((field.value(x + step) - field.value(x - step)) / 2e-5, gradient[i],
                  1e-5 * (1 + gradient.norm()));
    }
  }
}

TEST(HermiteField, IsAPlaneThroughValuesAndSlopesOfOne) {
  FieldConditions conditions = random_conditions(30, 10);
  const Eigen::Vector3d c(0.3, -1, 2);
  conditions.values = (conditions.sites * c).array() + 0.7;
  Eigen::VectorXd slopes(20);
  for (int j = 0; j < 10; ++j) {
    slopes[2 * j] = conditions.across.row(j).dot(c);
    slopes[2 * j + 1] = conditions.aside.row(j).dot(c);
  }
  const HermiteField field = SlopeEnergy(conditions).field(slopes);
  const Eigen::Vector3d far(5, -8, 3);
  EXPECT_NEAR(field.value(far), c.dot(far) + 0.7, 1e-6);
}

// The energy is least at slopes_of_values(), where its gradient 2 (H s + p) vanishes, and H and H⁻¹ belong
// together.
TEST(SlopeEnergy, IsLeastAtTheSlopesOfTheValuesAlone) {
  const SlopeEnergy energy(random_conditions(40, 25, 1e-3));
  EXPECT_LT((energy.hessian() * energy.slopes_of_values() + energy.pull()).norm(),
            1e-9 * energy.pull().norm());
  const Eigen::MatrixXd one = energy.hessian() * energy.inverse();
  EXPECT_LT((one - Eigen::MatrixXd::Identity(one.rows(), one.cols())).norm(), 1e-7);
  const HermiteField with = energy.field(energy.slopes_of_values());
  FieldConditions values = random_conditions(40, 25, 1e-3);
  values.across.resize(0, 3);
  values.aside.resize(0, 3);
  const HermiteField without = SlopeEnergy(values).field(Eigen::VectorXd(0));
  Random random(6);
  for (int k = 0; k < 10; ++k) {
    const Eigen::Vector3d x = random.normal3();
    EXPECT_NEAR(with.value(x), without.value(x), 1e-7);
  }
}

TEST(SlopeEnergy, SmoothingGivesWayToWrongValues) {
  FieldConditions conditions = random_conditions(40, 0, 1e6);
  const HermiteField field = SlopeEnergy(conditions).field(Eigen::VectorXd(0));
  // So dear that the field is the plane of least squares: third derivatives cost nothing there.
  Eigen::MatrixXd A(40, 4);
  A << conditions.sites, Eigen::VectorXd::Ones(40);
  const Eigen::Vector4d plane = A.colPivHouseholderQr().solve(conditions.values);
  const Eigen::Vector3d x(0.2, -0.4, 0.9);
  EXPECT_NEAR(field.value(x), plane.head<3>().dot(x) + plane[3], 1e-3);
}

TEST(FieldConditions, NameWhatIsWrong) {
  FieldConditions conditions = random_conditions(10, 4);
  conditions.smoothing[3] = -1;
  EXPECT_NE(conditions.problem()->find("smoothing of site 3"), std::string::npos);
  conditions = random_conditions(10, 4);
  conditions.across.row(2) *= 2;
  EXPECT_NE(conditions.problem()->find("site 2"), std::string::npos);
  conditions = random_conditions(10, 4);
  conditions.values[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SlopeEnergy{conditions}, InvalidInput);
  EXPECT_THROW(SlopeEnergy{random_conditions(3, 0)}, InvalidInput);
  conditions = random_conditions(10, 4);
  conditions.sites.row(1) = conditions.sites.row(0);
  EXPECT_THROW(SlopeEnergy{conditions}, SolverFailure);
}

}  // namespace
}  // namespace batten
