#include "batten/deformation/deformer.hpp"

#include "deformation/tube.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using fixtures::bent;
using fixtures::bumpy_tube;
using fixtures::flipped_faces;
using fixtures::mean_normal_angle_deg;
using fixtures::rows_of;
using fixtures::Tube;
using fixtures::twisted;

const DeformationEnergy kEnergies[] = {DeformationEnergy::Stretch, DeformationEnergy::Bend,
                                       DeformationEnergy::Combined, DeformationEnergy::TotalCurvature};
const DetailPreservation kDetails[] = {DetailPreservation::None, DetailPreservation::ShapeMatching,
                                       DetailPreservation::GaussNewton};

// Handles that stay: the rest shape has displacement 0 and turned differentials of its own, so it is the
// solution of every energy.
TEST(Deformer, LeavesTheShapeWhereItIsWhenHandlesStay) {
  const Tube tube = bumpy_tube(24, 4, 0.08, 0.15);
  for (const DeformationEnergy energy : kEnergies)
    for (const DetailPreservation detail : kDetails) {
      DeformOptions options;
      options.energy = energy;
      options.detail = detail;
      const Deformer deformer(tube.positions, tube.triangles, tube.ends, options);
      const Deformer::Result result = deformer.deform(rows_of(tube.positions, tube.ends));
      // GaussNewton expresses vectors by face normals up to the directions it leaves out.
      const double tolerance = detail == DetailPreservation::GaussNewton ? 2e-2 : 1e-8;
      EXPECT_LT((result.positions - tube.positions).rowwise().norm().maxCoeff(), tolerance)
          << static_cast<int>(energy) << ' ' << static_cast<int>(detail);
    }
}

// Translations are in the null space of every Laplacian: the linear solution is the translated shape,
// exactly.
TEST(Deformer, CarriesTranslationsOverExactly) {
  const Tube tube = bumpy_tube(20, 3, 0.1, 0.2);
  const Eigen::RowVector3d shift(0.3, -2, 5);
  for (const DeformationEnergy energy : kEnergies) {
    DeformOptions options;
    options.energy = energy;
    options.detail = DetailPreservation::None;
    const Deformer deformer(tube.positions, tube.triangles, tube.ends, options);
    const Points targets = rows_of(tube.positions, tube.ends).rowwise() + shift;
    const Points expected = tube.positions.rowwise() + shift;
    EXPECT_LT((deformer.deform(targets).positions - expected).cwiseAbs().maxCoeff(), 1e-7);
  }
}

// The linear solution is linear in the targets: T = (T + r) − r, and with random r neither of these moves a
// handle affinely, so that both take the way by back-substitution that a turned and shifted handle does not.
TEST(Deformer, AnswersToTurnedHandlesAsBackSubstitutionDoes) {
  const Tube tube = bumpy_tube(20, 3, 0.1, 0.2);
  const Points rest = rows_of(tube.positions, tube.ends);
  const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Points targets = rest, random = Points(rest.rows(), 3);
  Random generator(3);
  const double middle = 0.5 * (tube.positions.col(2).minCoeff() + tube.positions.col(2).maxCoeff());
  for (Eigen::Index c = 0; c < rest.rows(); ++c) {
    if (rest(c, 2) > middle) targets.row(c) = rest.row(c) * turn.transpose() + Eigen::RowVector3d(0.1, 0, 2);
    random.row(c) = 0.1 * generator.direction().transpose();
  }
  for (const double soft : {0.0, 10.0})
    for (const DeformationEnergy energy : kEnergies) {
      DeformOptions options;
      options.energy = energy;
      options.detail = DetailPreservation::None;
      options.soft_weight = soft;
      const Deformer deformer(tube.positions, tube.triangles, tube.ends, options);
      const Points expected = tube.positions + deformer.deform(targets + random).positions -
                              deformer.deform(rest + random).positions;
      for (int drag = 0; drag < 2; ++drag)
        EXPECT_LT((deformer.deform(targets).positions - expected).cwiseAbs().maxCoeff(), 1e-9)
            << static_cast<int>(energy) << ' ' << soft;
    }
}

// Shape matching keeps every edge when all handles turn alike: the turned shape has zero energy.
TEST(Deformer, ShapeMatchingFollowsARigidMotion) {
  const Tube tube = bumpy_tube(20, 3, 0.1, 0.2);
  const Matrix3d R = Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Points expected = tube.positions * R.transpose();
  for (const DeformationEnergy energy : {DeformationEnergy::Stretch, DeformationEnergy::Bend}) {
    DeformOptions options;
    options.energy = energy;
    options.detail = DetailPreservation::ShapeMatching;
    options.max_iterations = 1000;
    options.tolerance = 1e-9;
    const Deformer deformer(tube.positions, tube.triangles, tube.ends, options);
    EXPECT_LT((deformer.deform(rows_of(expected, tube.ends)).positions - expected).cwiseAbs().maxCoeff(),
              1e-5);
  }
}

// The acceptance figures: the same bumps on the tube twisted by 90° and bent by 120° by formula.
TEST(Deformer, KeepsBumpsUnderTwistAndBend) {
  const Tube tube = bumpy_tube(64, 6, 0.08, 0.1);
  const Deformer deformer(tube.positions, tube.triangles, tube.ends);  // total curvature, Gauss-Newton
  for (const Points& truth : {twisted(tube, radians(90.0)), bent(tube, radians(120.0))}) {
    const Deformer::Result result = deformer.deform(rows_of(truth, tube.ends));
    EXPECT_TRUE(result.report.converged);
    EXPECT_LE(mean_normal_angle_deg(result.positions, truth, tube.triangles), 5.0);
    EXPECT_EQ(flipped_faces(result.positions, truth, tube.triangles), 0);
  }
}

// With a growing weight soft handles approach hard ones, like 1 / weight.
TEST(Deformer, SoftHandlesApproachHardOnes) {
  const Tube tube = bumpy_tube(20, 3, 0.05, 0.2);
  DeformOptions options;
  options.energy = DeformationEnergy::Bend;
  options.detail = DetailPreservation::None;
  const Points targets = rows_of(twisted(tube, 0.5), tube.ends);
  const Points hard = Deformer(tube.positions, tube.triangles, tube.ends, options).deform(targets).positions;
  double previous = 1e9;
  for (const double weight : {1.0, 100.0, 1e4}) {
    options.soft_weight = weight;
    const Points soft =
        Deformer(tube.positions, tube.triangles, tube.ends, options).deform(targets).positions;
    const double difference = (soft - hard).norm();
    EXPECT_LT(difference, previous / 10);
    previous = difference;
  }
  EXPECT_LT(previous, 1e-3 * hard.norm());
}

// The unit of length must not matter: a mesh scaled by s gives the result scaled by s.
TEST(Deformer, ScalesWithTheUnit) {
  const Tube tube = bumpy_tube(20, 3, 0.08, 0.2);
  const Points targets = rows_of(bent(tube, 0.8), tube.ends);
  for (const DeformationEnergy energy : kEnergies) {
    DeformOptions options;
    options.energy = energy;
    options.max_iterations = 20;
    const Points expected =
        Deformer(tube.positions, tube.triangles, tube.ends, options).deform(targets).positions;
    for (const double scale : {1e-3, 1e3}) {
      const Deformer deformer(scale * tube.positions, tube.triangles, tube.ends, options);
      EXPECT_LT((deformer.deform(scale * targets).positions / scale - expected).cwiseAbs().maxCoeff(), 1e-6);
    }
  }
}

TEST(Deformer, RefusesWhatHasNoAnswer) {
  const Tube tube = bumpy_tube(12, 2, 0, 0.2);
  const auto build = [&](std::vector<int> constrained, const DeformOptions& options = {}) {
    return Deformer(tube.positions, tube.triangles, std::move(constrained), options);
  };
  EXPECT_THROW(build({}), InvalidInput);         // nothing holds the shape
  EXPECT_THROW(build({0, 0}), InvalidInput);     // twice the same
  EXPECT_THROW(build({-1}), InvalidInput);       // no such vertex
  EXPECT_THROW(build({1 << 20}), InvalidInput);  // no such vertex
  DeformOptions options;
  options.tolerance = 0;
  EXPECT_THROW(build(tube.ends, options), InvalidInput);
  options = {};
  options.soft_weight = -1;
  EXPECT_THROW(build(tube.ends, options), InvalidInput);
  const Deformer deformer = build(tube.ends);
  EXPECT_THROW(deformer.deform(Points::Zero(1, 3)), InvalidInput);
  Points targets = rows_of(tube.positions, tube.ends);
  targets(0, 1) = std::nan("");
  EXPECT_THROW(deformer.deform(targets), InvalidInput);
  // Two parts of which one is held by nothing.
  Points two(2 * tube.positions.rows(), 3);
  two << tube.positions, tube.positions.rowwise() + Eigen::RowVector3d(9, 0, 0);
  Triangles both(2 * tube.triangles.rows(), 3);
  both << tube.triangles, tube.triangles.array() + static_cast<int>(tube.positions.rows());
  EXPECT_THROW(Deformer(two, both, tube.ends), InvalidInput);
}

TEST(Deformer, CanBeCancelled) {
  const Tube tube = bumpy_tube(16, 3, 0.05, 0.2);
  const Deformer deformer(tube.positions, tube.triangles, tube.ends);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(deformer.deform(rows_of(bent(tube, 1), tube.ends), nullptr, stop), Cancelled);
}

}  // namespace
}  // namespace batten
