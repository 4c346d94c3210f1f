#include <limits>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/motion_detail.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

Motion summed(const InertialErrors& errors, int steps = 10) {
  Random random(3);
  Motion motion;
  Vector3d rate = random.normal3(), force = 10 * random.normal3();
  for (int i = 0; i < steps; ++i) {
    const Vector3d next_rate = rate + 0.3 * random.normal3(), next_force = force + random.normal3();
    motion.append(0.01, rate, next_rate, force, next_force, errors);
    rate = next_rate;
    force = next_force;
  }
  return motion;
}

// Central differences over all fifteen errors.
TEST(Motion, DerivativesAreThoseOfItsSums) {
  InertialErrors base;
  base.gyroscope_bias = {0.02, -0.01, 0.03};
  base.gyroscope_matrix << 0.01, 0.002, 0, 0.003, -0.01, 0.001, 0, 0.002, 0.02;
  base.accelerometer_bias = {0.1, 0, -0.1};
  const Motion motion = summed(base);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < InertialErrors::kCount; ++i) {
    const auto moved = [&](double by) {
      InertialErrors errors = base;
      double* const values = i < InertialErrors::kMatrix  ? errors.gyroscope_bias.data() + i
                             : i < InertialErrors::kForce ? errors.gyroscope_matrix.data() + i - 3
                                                          : errors.accelerometer_bias.data() + i - 12;
      *values += by;
      return summed(errors);
    };
    const Motion a = moved(-kStep), b = moved(kStep);
    EXPECT_LT((so3_log(a.R.transpose() * b.R) / (2 * kStep) - motion.R_by.col(i)).norm(), 1e-8) << i;
    EXPECT_LT(((b.v - a.v) / (2 * kStep) - motion.v_by.col(i)).norm(), 2e-3) << i;
    EXPECT_LT(((b.p - a.p) / (2 * kStep) - motion.p_by.col(i)).norm(), 2e-4) << i;
  }
}

// A steady turn with a force that turns against it: in the axes of the start the force stands still.
TEST(Motion, ASteadyForceGivesAParabola) {
  const Vector3d rate(0, 0, 1.5), force(2, 0, 0);
  Motion motion;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    const double dt = 0.005;
    const Vector3d before = so3_exp(-rate * (i * dt)) * force,
                   after = so3_exp(-rate * ((i + 1) * dt)) * force;
    motion.append(dt, rate, rate, before, after, {});
  }
  EXPECT_NEAR(motion.time, 1, 1e-12);
  EXPECT_LT((motion.v - force).norm(), 1e-9);
  EXPECT_LT((motion.p - force / 2).norm(), 1e-9);
  EXPECT_LT((so3_log(motion.R) - rate).norm(), 1e-9);
  EXPECT_NEAR(motion.turned, 1.5, 1e-9);
}

TEST(Motion, ShortGapsAreBridgedByStraightLinesLongOnesAreNot) {
  const double missing = std::numeric_limits<double>::quiet_NaN();
  Points readings = Points::Constant(7, 3, missing);
  readings.row(1).setConstant(1);
  readings.row(3).setConstant(3);
  readings.row(6).setConstant(6);
  Eigen::VectorXd time(7);
  time << 0, 0.1, 0.2, 0.3, 0.4, 1.0, 1.1;
  const SensorStream stream = filled_stream(readings, time, 0.25);
  EXPECT_EQ(stream.known, (std::vector<char>{1, 1, 1, 1, 0, 0, 1}));
  EXPECT_NEAR(stream.values(2, 0), 2, 1e-12);
  EXPECT_EQ(stream.values(0, 0), 1);  // before the first reading there is that one alone
}

}  // namespace
}  // namespace batten
