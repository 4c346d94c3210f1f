#include "batten/rotation/wahba.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAgreement = 1e-10;

Matrix3d random_rotation(Random& random) {
  const Vector3d v = random.normal3();
  return Eigen::Quaterniond(random.normal(), v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

/// Gravity and the magnetic field at an inclination of 60° (S 3.4.2), as a device in orientation X sees them.
std::vector<VectorPair> sensor_pairs(const Matrix3d& X) {
  const Vector3d up(0, 0, 1);
  const Vector3d field(0.5, 0, -std::sqrt(3.0) / 2);
  return {{up, X.transpose() * up}, {field, X.transpose() * field}};
}

TEST(Wahba, FindsTheOrientationOfExactVectors) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3d X = random_rotation(random);
    for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
      EXPECT_LT((solve_wahba(sensor_pairs(X), method) - X).norm(), 1e-12);
      EXPECT_LT(wahba_cost(sensor_pairs(X), solve_wahba(sensor_pairs(X), method)), 1e-28);
    }
  }
}

// Half turns are where a quaternion's w vanishes.
TEST(Wahba, FindsHalfTurnsAndTheIdentity) {
  for (const Vector3d& turn :
       {Vector3d(0, 0, 0), Vector3d(kPi, 0, 0), Vector3d(0, kPi, 0), Vector3d(0, 0, kPi)})
    for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd})
      EXPECT_LT((solve_wahba(sensor_pairs(so3_exp(turn)), method) - so3_exp(turn)).norm(), 1e-12);
}

// Vectors that fit no rotation: the two algorithms share no step, and neither a random turn of the solution
// lowers the cost.
TEST(Wahba, BothMethodsAgreeOnNoisyVectorsOfAnyNumberAndWeight) {
  Random random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const Matrix3d X = random_rotation(random);
    std::vector<VectorPair> pairs;
    const std::uint64_t n = 2 + random.below(7);
    for (std::uint64_t i = 0; i < n; ++i) {
      const Vector3d e = random.direction() * random.uniform(0.1, 10);
      pairs.push_back({e, X.transpose() * e + 0.3 * e.norm() * random.normal3(), random.uniform(0.1, 5)});
    }
    const Matrix3d by_q = solve_wahba(pairs, WahbaMethod::Quaternion);
    const Matrix3d by_svd = solve_wahba(pairs, WahbaMethod::Svd);
    EXPECT_LT((by_q - by_svd).norm(), kAgreement);
    EXPECT_NEAR(by_q.determinant(), 1, 1e-12);
    const double cost = wahba_cost(pairs, by_q);
    for (int k = 0; k < 5; ++k)
      EXPECT_GE(wahba_cost(pairs, so3_exp(0.01 * random.normal3()) * by_q), cost - 1e-12);
  }
}

// A weight of 3 is the same as the pair three times; a weight of 0 as its absence; a common factor is
// nothing.
TEST(Wahba, WeightsCountAsRepetitions) {
  Random random(3);
  const std::vector<VectorPair> pairs = {{random.direction(), random.direction(), 1},
                                         {random.direction(), random.direction(), 3},
                                         {random.direction(), random.direction(), 0}};
  std::vector<VectorPair> repeated = {pairs[0], pairs[1], pairs[1], pairs[1]};
  for (VectorPair& pair : repeated) pair.weight = 1e-9;
  for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd})
    EXPECT_LT((solve_wahba(pairs, method) - solve_wahba(repeated, method)).norm(), kAgreement);
}

// A weight of 0 is how a caller leaves a sensor out that measured nothing: its vectors are not looked at.
TEST(Wahba, PairsOfWeightZeroMayHoldAnyVectors) {
  Random random(4);
  const Vector3d nothing(0, 0, 0), broken(NAN, 0, 0);
  const Matrix3d X = random_rotation(random);
  const std::vector<VectorPair> pairs = sensor_pairs(X);
  std::vector<VectorPair> more = {
      {nothing, random.direction(), 0}, pairs[0], {random.direction(), broken, 0}, pairs[1]};
  for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
    EXPECT_EQ(solve_wahba(more, method), solve_wahba(pairs, method));
    EXPECT_EQ(wahba_cost(more, X), wahba_cost(pairs, X));
    // They do not count towards the two that are needed either, and the message says how many are left.
    try {
      solve_wahba({pairs[0], {pairs[1].reference, pairs[1].measured, 0}}, method);
      FAIL() << "one vector does not determine a rotation";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("got 1"), std::string::npos) << error.what();
    }
  }
}

// [markley1988]: the solution is unique while σ₂ + sign(det B) σ₃ > 0. Three axes of equal weight have B =
// ±I/3. All kept, the identity is the only solution; all reversed, every half turn costs the same (trace −1,
// like any other), so there is none. With unequal weights the reversed axes have one again: the half turn
// that reverses the heaviest two, (−1, −1, +1) in the order of weights, which costs 4 times the lightest.
TEST(Wahba, ReflectedVectorsDetermineARotationUnlessTheirTwoLightestSpreadsAreEqual) {
  const auto axes = [](double sign, const Vector3d& weights) {
    std::vector<VectorPair> pairs;
    for (int i = 0; i < 3; ++i) pairs.push_back({Vector3d::Unit(i), sign * Vector3d::Unit(i), weights[i]});
    return pairs;
  };
  for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
    EXPECT_LT((solve_wahba(axes(1, {1, 1, 1}), method) - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_THROW(solve_wahba(axes(-1, {1, 1, 1}), method), InvalidInput);
    EXPECT_THROW(solve_wahba(axes(-1, {2, 1, 1}), method), InvalidInput);
    const std::vector<VectorPair> reversed = axes(-1, {5, 3, 2});
    const Matrix3d X = solve_wahba(reversed, method);
    EXPECT_LT((X - Matrix3d(Vector3d(-1, -1, 1).asDiagonal())).norm(), 1e-14);
    EXPECT_NEAR(wahba_cost(reversed, X), 4 * 2, 1e-14);
  }
}

// An infinite weight would fix its vector; a large one leaves the other pair only the turn about it.
TEST(Wahba, TheHeavierVectorIsMetTheBetter) {
  const Vector3d up(0, 0, 1);
  const Vector3d tilted = Vector3d(0.2, 0, 1).normalized();
  const Vector3d field(1, 0, 0);
  const Matrix3d X = solve_wahba({{up, tilted, 1e6}, {field, field, 1}});
  EXPECT_LT((X * tilted - up).norm(), 1e-5);
}

// docs/methods.md#conventions: Wahba's A is the transpose of X; with (2.26) the same quaternion put into the
// ordinary matrix gives X. The columns of X are the device axes (forward, normal, forward × normal) in the
// world: a device that moves east with its face up on a table has t = east, N = up, B = east × up.
TEST(Wahba, GivesTheFrameWhoseColumnsAreTheDeviceAxesInTheWorld) {
  const Vector3d up(0, 0, 1);
  const Vector3d field(0.5, 0, -std::sqrt(3.0) / 2);  // x is magnetic north
  const Vector3d east(0, -1, 0);                      // z up and x north: y is west
  // Measured in device axes: up is the second axis; the field has no forward part (north is to the left of
  // somebody who goes east, and forward × normal = east × up points south).
  const Vector3d measured_up(0, 1, 0);
  const Vector3d measured_field(0, -std::sqrt(3.0) / 2, -0.5);
  for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
    const Matrix3d X = solve_wahba({{up, measured_up}, {field, measured_field}}, method);
    EXPECT_LT((X.col(0) - east).norm(), 1e-12);
    EXPECT_LT((X.col(1) - up).norm(), 1e-12);
    EXPECT_LT((X.col(2) - east.cross(up)).norm(), 1e-12);
    const Matrix3d A = X.transpose();
    EXPECT_LT((A * field - measured_field).norm(), 1e-12);
  }
}

TEST(Wahba, RefusesWhatDoesNotDetermineARotation) {
  const Vector3d x(1, 0, 0);
  const Vector3d y(0, 1, 0);
  const Vector3d zero(0, 0, 0);
  for (const WahbaMethod method : {WahbaMethod::Quaternion, WahbaMethod::Svd}) {
    EXPECT_THROW(solve_wahba({}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y}, {y, x, 0}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y}, {x, y}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y}, {y, y}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y}, {-x, -y}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, zero}, {y, x}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, Vector3d(NAN, 0, 0)}, {y, x}}, method), InvalidInput);
    EXPECT_THROW(solve_wahba({{x, y, -1}, {y, x}}, method), InvalidInput);
  }
}

}  // namespace
}  // namespace batten
