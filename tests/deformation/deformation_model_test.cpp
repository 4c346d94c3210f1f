#include "deformation/tube.hpp"

#include <algorithm>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/deformation/deformation_matrices_detail.hpp"
#include "batten/deformation/deformation_model_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Matrix3d;

const Matrix3d kTurn = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();

DeformOptions options_of(DeformationEnergy energy, DetailPreservation detail) {
  DeformOptions options;
  options.energy = energy;
  options.detail = detail;
  return options;
}

// Turned by nothing the differentials are those of the rest shape, and turned as one they turn as one. All of
// them are differences: moving the rest shape changes nothing.
TEST(DeformationModel, DifferentialsTurnWithTheShape) {
  const fixtures::Tube tube = fixtures::bumpy_tube(16, 3, 0.1, 0.2);
  const auto n = static_cast<std::size_t>(tube.positions.rows());
  for (const auto energy :
       {DeformationEnergy::Stretch, DeformationEnergy::Bend, DeformationEnergy::Combined}) {
    const DeformOptions options = options_of(energy, DetailPreservation::ShapeMatching);
    const DeformationModel model(tube.positions, tube.triangles, options, 4);
    const Points forces = model.displacement_forces();
    const double size = forces.cwiseAbs().maxCoeff();
    EXPECT_LT((model.turned_rest(std::vector<Matrix3d>(n, Matrix3d::Identity())) - forces).norm(),
              1e-9 * size);
    EXPECT_LT((model.turned_rest(std::vector<Matrix3d>(n, kTurn)) - forces * kTurn.transpose()).norm(),
              1e-9 * size);
    const Points moved = tube.positions.rowwise() + Eigen::RowVector3d(3, -1, 2);
    EXPECT_LT((DeformationModel(moved, tube.triangles, options, 4).displacement_forces() - forces).norm(),
              1e-8 * size);
  }
}

// A turned copy of the shape keeps its detail where the detail turns with it.
TEST(DeformationModel, DetailTurnsWithTheNormals) {
  const fixtures::Tube tube = fixtures::bumpy_tube(16, 3, 0.1, 0.2);
  DeformationModel model(tube.positions, tube.triangles,
                         options_of(DeformationEnergy::Bend, DetailPreservation::GaussNewton), 4);
  model.follow_normals(tube.triangles, std::vector<char>(static_cast<std::size_t>(tube.positions.rows()), 1));
  std::vector<Matrix3d> rotations;
  const Points still = model.detail_forces(tube.positions, rotations);
  rotations.clear();
  const Points turned = model.detail_forces(tube.positions * kTurn.transpose(), rotations);
  EXPECT_LT((turned - still * kTurn.transpose()).norm(), 1e-9 * still.norm());
}

TEST(DeformationMatrices, PartsAreKnownByTheirLowestVertex) {
  Triangles triangles(3, 3);
  triangles << 5, 2, 6, 1, 4, 3, 6, 2, 7;
  EXPECT_EQ(connected_parts(triangles, 8), (std::vector{0, 1, 2, 1, 1, 2, 2, 2}));
}

TEST(DeformationMatrices, MollifiedTrianglesAreNotFlat) {
  EdgeLengths lengths(2, 3);
  lengths << 1, 1, 2, 1, 1, 1;  // the first one is a line
  const double least = 1e-2 * lengths.mean();
  const EdgeLengths longer = mollified(lengths);
  const double added = longer(0, 0) - lengths(0, 0);
  EXPECT_LT((longer.array() - lengths.array() - added).abs().maxCoeff(), 1e-15);
  EXPECT_NEAR(longer(0, 0) + longer(0, 1) - longer(0, 2), least, 1e-15);
  const EdgeLengths good = EdgeLengths::Ones(2, 3);
  EXPECT_EQ(mollified(good), good);
}

/// A stiffness matrix with one negative weight, between vertices 0 and 1.
Eigen::MatrixXd stiffness() {
  Eigen::MatrixXd weights(4, 4);
  weights << 0, -0.5, 1, 2, -0.5, 0, 3, 0, 1, 3, 0, 0.25, 2, 0, 0.25, 0;
  Eigen::MatrixXd K = -weights;
  K.diagonal() = weights.rowwise().sum();
  return K;
}

TEST(DeformationMatrices, ClampedWeightsKeepTheSumOfRows) {
  SparseMatrix K = stiffness().sparseView();
  clamp_weights(K);
  const Eigen::MatrixXd clamped(K);
  EXPECT_EQ(clamped(0, 1), 0);
  EXPECT_EQ(clamped(0, 2), -1);
  EXPECT_EQ(clamped(0, 0), 3);
  EXPECT_LT(clamped.rowwise().sum().cwiseAbs().maxCoeff(), 1e-15);
}

// xᵀ K_g x = Σ w (g_i + g_j) / 2 (x_i − x_j)² over the edges.
TEST(DeformationMatrices, WeightedStiffnessIsThatOfTheWeightedEnergy) {
  const Eigen::MatrixXd K = stiffness();
  const Eigen::VectorXd g = Eigen::Vector4d(0.5, 2, 3, 0.1), x = Eigen::Vector4d(1, -1, 0.5, 2);
  double energy = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) energy += -K(i, j) * (g[i] + g[j]) / 2 * (x[i] - x[j]) * (x[i] - x[j]);
  const Eigen::MatrixXd weighted(weighted_stiffness(K.sparseView(), g));
  EXPECT_NEAR(x.dot(weighted * x), energy, 1e-13);
  EXPECT_LT((weighted - weighted.transpose()).norm(), 1e-15);
}

TEST(DeformationMatrices, PartsOfAMatrixAreItsRowsAndColumns) {
  const Eigen::MatrixXd K = stiffness();
  const std::vector<int> rows = {1, -1, 0, 2}, columns = {-1, 0, -1, 1};
  const Eigen::MatrixXd part(part_of(K.sparseView(), rows, columns, 3, 2, false));
  Eigen::MatrixXd expected(3, 2);
  expected << K(2, 1), K(2, 3), K(0, 1), K(0, 3), K(3, 1), K(3, 3);
  EXPECT_EQ(part, expected);
  const Eigen::MatrixXd lower(part_of(K.sparseView(), rows, rows, 3, 3, true));
  EXPECT_EQ(lower(1, 0), K(0, 2));
  EXPECT_EQ(lower(0, 1), 0);
}

}  // namespace
}  // namespace batten::detail
