#include "batten/camera/calibration.hpp"

#include "camera/boards.hpp"

#include <filesystem>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/io/rig_io.hpp"

namespace batten::test {
namespace {

/// The 24 numbers of a rig relative to those of another: how covariance matrices count them.
Eigen::VectorXd difference(const StereoRig& rig, const StereoRig& truth) {
  Eigen::VectorXd d(kRigParameters);
  const auto camera = [](const Camera& a, const Camera& b) {
    Eigen::VectorXd c(9);
    c << a.fx - b.fx, a.fy - b.fy, a.cx - b.cx, a.cy - b.cy, a.k1 - b.k1, a.k2 - b.k2, a.k3 - b.k3,
        a.p1 - b.p1, a.p2 - b.p2;
    return c;
  };
  d << camera(rig.left, truth.left), camera(rig.right, truth.right),
      so3_log(rig.rotation * truth.rotation.transpose()), rig.translation - truth.translation;
  return d;
}

TEST(CalibrateRig, FindsTheRigOfExactCorners) {
  for (const LensModel lens : {LensModel::Usual, LensModel::Full}) {
    const StereoRig truth = lens == LensModel::Full ? webcam_rig() : usual_rig();
    const RigCalibration found = calibrate_rig(shown_boards(truth, {}), {.lens = lens});
    const Eigen::VectorXd d = difference(found.calibrated.rig, truth);
    EXPECT_LT(d.cwiseAbs().maxCoeff(), 1e-5) << d.transpose();
    EXPECT_LT(found.calibrated.figures.rms, 1e-6);
    EXPECT_LT(found.calibrated.figures.epipolar, 1e-6);
    EXPECT_EQ(found.calibrated.figures.left_out, 0);
    EXPECT_TRUE(found.warnings.empty());
  }
}

// The squared error in units of its covariance is distributed as χ² with one degree of freedom per number:
// here 22, so that its mean over 30 draws is 22 with a standard deviation of √(2 · 22 / 30) = 1.2. A missing
// factor of 2 in the covariance, or σ for σ², is far outside.
TEST(CalibrateRig, KnowsHowWellItKnows) {
  constexpr int kSeeds = 30;
  const StereoRig truth = usual_rig();
  double sum = 0;
  int within = 0, numbers = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const BoardPairs pairs = shown_boards(
        truth,
        {.pairs = 16, .noise = 0.2, .missing = 0.1, .far = 0.5, .seed = static_cast<std::uint64_t>(seed)});
    const RigCalibration found = calibrate_rig(pairs, {.lens = LensModel::Usual});
    const Eigen::VectorXd d = difference(found.calibrated.rig, truth);
    std::vector<int> estimated;
    for (int i = 0; i < kRigParameters; ++i) {
      const double variance = found.covariance(i, i);
      if (variance == 0) continue;
      estimated.push_back(i);
      within += std::abs(d[i]) < 2 * std::sqrt(variance) ? 1 : 0;
      ++numbers;
    }
    ASSERT_EQ(estimated.size(), 22U);
    const Eigen::MatrixXd C = found.covariance(estimated, estimated);
    const Eigen::VectorXd e = d(estimated);
    sum += e.dot(C.ldlt().solve(e));
  }
  EXPECT_NEAR(sum / kSeeds, 22, 4);
  EXPECT_NEAR(within / static_cast<double>(numbers), 0.954, 0.04);  // of a normal distribution within 2 σ
}

TEST(CalibrateRig, LeavesOutOutliers) {
  const StereoRig truth = usual_rig();
  const BoardPairs clean = shown_boards(truth, {.noise = 0.1, .seed = 5});
  const BoardPairs dirty = shown_boards(truth, {.noise = 0.1, .outliers = 0.05, .seed = 5});
  int n_wrong = 0;
  for (std::size_t k = 0; k < clean.pairs.size(); ++k)
    for (int i = 0; i < 54; ++i) {
      n_wrong += clean.pairs[k].left.row(i) != dirty.pairs[k].left.row(i) ? 1 : 0;
      n_wrong += clean.pairs[k].right.row(i) != dirty.pairs[k].right.row(i) ? 1 : 0;
    }
  ASSERT_GT(n_wrong, 30);
  const RigCalibration found = calibrate_rig(dirty, {.lens = LensModel::Usual});
  EXPECT_GE(found.calibrated.figures.left_out, n_wrong);
  EXPECT_LE(found.calibrated.figures.left_out,
            n_wrong + 3);  // of 1300 normal residuals hardly one is beyond 4 × median
  const Eigen::VectorXd d = difference(found.calibrated.rig, truth);
  const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < kRigParameters; ++i) EXPECT_LE(std::abs(d[i]), 4 * sigma[i]) << i;
}

// A lens with a strong sixth power seen up to its corners is described better by k3, a plain one is not.
TEST(CalibrateRig, ChoosesTheLensByPairsHeldBack) {
  StereoRig wide = usual_rig();
  wide.left.k1 = wide.right.k1 = -0.3;
  wide.left.k3 = wide.right.k3 = 0.3;
  const RigCalibration full = calibrate_rig(shown_boards(wide, {.pairs = 16, .noise = 0.05}));
  EXPECT_EQ(full.calibrated.figures.lens, LensModel::Full);
  const RigCalibration usual = calibrate_rig(shown_boards(usual_rig(), {.pairs = 12, .noise = 0.2}));
  EXPECT_EQ(usual.calibrated.figures.lens, LensModel::Usual);
  ASSERT_EQ(usual.trials.size(), 3U);
  EXPECT_GT(usual.calibrated.figures.held_back, usual.calibrated.figures.epipolar);
  EXPECT_EQ(usual.calibrated.rig.left.k3, 0);
}

// Corners counted from the other end give the board of this pair another turn in one image.
TEST(CalibrateRig, LeavesOutPairsCountedFromAnotherEnd) {
  BoardPairs pairs = shown_boards(usual_rig(), {.noise = 0.1});
  pairs.pairs[3].right = pairs.pairs[3].right.colwise().reverse().eval();
  const RigCalibration found = calibrate_rig(pairs);
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_NE(found.warnings[0].find("pair 4 is left out"), std::string::npos);
  EXPECT_EQ(found.calibrated.figures.pairs, 11);
  EXPECT_LT(found.calibrated.figures.rms, 0.2);
}

TEST(CalibrateRig, RefusesInWords) {
  const StereoRig rig = usual_rig();
  const auto said = [](const BoardPairs& pairs, const RigCalibrationOptions& options = {}) {
    return refusal([&] { calibrate_rig(pairs, options); });
  };
  EXPECT_NE(said(shown_boards(rig, {.noise = 0.1, .tilt = 0})).find("never tilted"), std::string::npos);
  EXPECT_NE(said(shown_boards(rig, {.pairs = 3})).find("at least 4 pairs"), std::string::npos);
  EXPECT_NE(said(shown_boards(rig, {.pairs = 4, .near = 1.6, .far = 1.8})).find("% of the left image"),
            std::string::npos);
  EXPECT_NE(said(BoardPairs{}).find("sizes"), std::string::npos);

  BoardPairs pairs = shown_boards(rig, {.pairs = 4});
  for (int i = 0; i < 43; ++i) pairs.pairs[2].right(i, 0) = std::numeric_limits<double>::quiet_NaN();
  const std::string few = said(pairs);
  EXPECT_NE(few.find("3 of 4 can be used"), std::string::npos) << few;
  EXPECT_NE(few.find("pair 3 is left out: both cameras see 11 corners"), std::string::npos) << few;

  pairs = shown_boards(rig, {});
  pairs.board.columns = 8;  // even and even: ambiguous
  for (BoardPair& pair : pairs.pairs) {
    pair.left.conservativeResize(48, 2);
    pair.right.conservativeResize(48, 2);
  }
  EXPECT_NE(said(pairs).find("half a turn"), std::string::npos);
  EXPECT_NE(said(shown_boards(rig, {}), {.huber = 0}).find("huber"), std::string::npos);
  EXPECT_NE(said(shown_boards(rig, {}), {.outliers = 1}).find("outliers"), std::string::npos);
}

TEST(CheckRig, SeesNothingWrongInExactCorners) {
  const StereoRig rig = webcam_rig();
  const RigCheck check = check_rig(rig, shown_boards(rig, {.missing = 0.1}));
  EXPECT_EQ(check.pairs, 12);
  EXPECT_LT(check.epipolar_rms, 1e-8);
  EXPECT_NEAR(check.neighbour_mean, 1, 1e-9);
  EXPECT_LT(check.neighbour_std, 1e-8);
  EXPECT_LT(check.rigid_rms, 1e-8);
  EXPECT_EQ(check.lost, 0);
  EXPECT_LT(check.corners, 12 * 54);
}

// Lengths grow with the baseline. A camera that is turned about the baseline moves all its points across the
// epipolar lines, by the angle times the focal length near the axis.
TEST(CheckRig, MeasuresWhatIsWrong) {
  const StereoRig truth = webcam_rig();
  const BoardPairs pairs = shown_boards(truth, {});
  StereoRig rig = truth;
  rig.translation *= 1.02;
  EXPECT_NEAR(check_rig(rig, pairs).neighbour_mean, 1.02, 1e-9);
  rig = truth;
  rig.rotation = so3_exp(0.002 * truth.translation.normalized()) * truth.rotation;
  const RigCheck turned = check_rig(rig, pairs);
  EXPECT_NEAR(turned.epipolar, 0.002 * 537, 0.15 * 0.002 * 537);
  EXPECT_GE(turned.epipolar_rms, turned.epipolar);
}

TEST(CheckRig, RefusesWhatHoldsNoCommonCorner) {
  BoardPairs pairs = shown_boards(webcam_rig(), {.pairs = 1});
  pairs.pairs[0].right.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(check_rig(webcam_rig(), pairs), InvalidInput);
  EXPECT_THROW(check_rig(StereoRig{}, pairs), InvalidInput);
}

// Against stereo/reference_opencv.json, which another program made of the same corners: 0.162 px on the pairs
// used.
TEST(CalibrateRig, FitsTheSharedPairsBetterThanTheReference) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/stereo/corners.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const BoardPairs pairs = read_corners(path, {.board = {}, .size = ImageSize{640, 480}});
  const RigCalibration found = calibrate_rig(pairs);
  const CalibratedRig& rig = found.calibrated;
  EXPECT_LT(rig.figures.epipolar, 0.15);
  EXPECT_LT(rig.figures.held_back, 0.16);
  EXPECT_NEAR(rig.rig.left.fx, 535.08, 3);
  EXPECT_NEAR(rig.rig.right.fy, 538.16, 3);
  EXPECT_NEAR(rig.rig.baseline(), 3.3418 * 0.025, 0.01 * 3.34 * 0.025);
  // The other program counts the middle of the first pixel as (0, 0), and so its principal point.
  EXPECT_NEAR(rig.rig.left.cx, 340.24 + 0.5, 2.5);
  EXPECT_NEAR(check_rig(rig.rig, pairs).neighbour_mean, 1, 0.0125);
}

}  // namespace
}  // namespace batten::test
