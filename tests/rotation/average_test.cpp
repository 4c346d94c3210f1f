#include "batten/rotation/average.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {
namespace {

std::vector<Eigen::Matrix3d> cloud(Random& random, const Eigen::Matrix3d& centre, int n, double spread) {
  std::vector<Eigen::Matrix3d> rotations;
  for (int i = 0; i < n; ++i) rotations.push_back(centre * so3_exp(spread * random.normal3()));
  return rotations;
}

double chordal_energy(const Eigen::Matrix3d& A, const std::vector<Eigen::Matrix3d>& rotations,
                      const std::vector<double>& weights) {
  double energy = 0;
  for (size_t i = 0; i < rotations.size(); ++i) energy += weights[i] * (A - rotations[i]).squaredNorm();
  return energy;
}

TEST(RotationAverage, MinimisesTheChordalEnergy) {
  // The minimiser of Σ α ‖A − Aᵢ‖² is also the rotation nearest to Σ α Aᵢ: a second implementation by SVD.
  Random random(1);
  for (const double spread : {1e-6, 0.05, 0.5}) {
    const std::vector<Eigen::Matrix3d> rotations = cloud(random, so3_exp(random.normal3()), 9, spread);
    std::vector<double> weights;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Matrix3d& R : rotations) sum += weights.emplace_back(random.uniform(0, 2)) * R;
    const Eigen::Matrix3d A = rotation_average(rotations, weights);
    EXPECT_LT((A - nearest_rotation(sum)).norm(), 1e-10);
    const double least = chordal_energy(A, rotations, weights);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Matrix3d other = A * so3_exp(0.01 * random.normal3());
      EXPECT_GT(chordal_energy(other, rotations, weights), least);
    }
  }
}

TEST(RotationAverage, DoesNotSeeTheSignOfQuaternionsAndTurnsWithTheFrame) {
  Random random(2);
  std::vector<Eigen::Quaterniond> a, b, turned;
  const Eigen::Quaterniond turn(so3_exp(random.normal3()));
  for (const Eigen::Matrix3d& R : cloud(random, so3_exp(random.normal3()), 5, 0.3)) {
    a.emplace_back(R);
    b.emplace_back(R);
    if (b.size() % 2 == 0) b.back().coeffs() *= -1;
    turned.push_back(turn * a.back());
  }
  EXPECT_LT(rotation_average(a).angularDistance(rotation_average(b)), 1e-14);
  EXPECT_LT(rotation_average(turned).angularDistance(turn * rotation_average(a)), 1e-7);
}

TEST(RotationAverage, OfOneRotationIsThatRotation) {
  const Eigen::Matrix3d R = so3_exp({0.3, -2, 1});
  EXPECT_LT((rotation_average(std::vector<Eigen::Matrix3d>{R}) - R).norm(), 1e-14);
}

TEST(RotationAverageWithNormal, GoesFromThePlainAverageToTheGivenNormal) {
  Random random(3);
  const std::vector<Eigen::Matrix3d> rotations = cloud(random, so3_exp(random.normal3()), 7, 0.1);
  const Eigen::Matrix3d plain = rotation_average(rotations);
  const Eigen::Vector3d normal = (plain.col(1) + 0.2 * random.direction()).normalized();
  EXPECT_LT((rotation_average_with_normal(rotations, {}, normal, 0) - plain).norm(), 1e-10);
  double last = (plain.col(1) - normal).norm();
  for (const double w : {0.2, 0.5, 0.9, 0.99, 1 - 1e-9}) {
    const Eigen::Matrix3d A = rotation_average_with_normal(rotations, {}, normal, w);
    EXPECT_NEAR(A.determinant(), 1, 1e-12);
    const double distance = (A.col(1) - normal).norm();
    EXPECT_LT(distance, last);
    last = distance;
  }
  EXPECT_LT(last, 1e-6);
}

TEST(RotationAverageWithNormal, MaximisesTheStatedEnergy) {
  Random random(4);
  const std::vector<Eigen::Matrix3d> rotations = cloud(random, so3_exp(random.normal3()), 6, 0.3);
  const Eigen::Vector3d normal = random.direction();
  const double w = 0.4;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (const Eigen::Matrix3d& R : rotations) mean += R / 6;
  const auto energy = [&](const Eigen::Matrix3d& A) {
    return (1 - w) * (A * mean.transpose()).trace() + w * A.col(1).dot(normal);
  };
  const Eigen::Matrix3d A = rotation_average_with_normal(rotations, {}, normal, w);
  for (int i = 0; i < 200; ++i) EXPECT_LE(energy(so3_exp(random.normal3()) * A), energy(A) + 1e-12);
}

TEST(RotationAverage, RefusesEmptyNegativeAndVanishingWeights) {
  const std::vector<Eigen::Matrix3d> one{Eigen::Matrix3d::Identity()};
  EXPECT_THROW(rotation_average(std::vector<Eigen::Matrix3d>{}), InvalidInput);
  EXPECT_THROW(rotation_average(one, {-1}), InvalidInput);
  EXPECT_THROW(rotation_average(one, {0}), InvalidInput);
  EXPECT_THROW(rotation_average(one, {1, 1}), InvalidInput);
  EXPECT_THROW(rotation_average_with_normal(one, {}, Eigen::Vector3d::Zero(), 0.5), InvalidInput);
  EXPECT_THROW(rotation_average_with_normal(one, {}, Eigen::Vector3d::UnitX(), 1), InvalidInput);
}

}  // namespace
}  // namespace batten
