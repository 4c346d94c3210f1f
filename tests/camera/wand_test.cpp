#include "batten/camera/wand.hpp"

#include "camera/boards.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

/// A wand waved before a rig. Blobs come in a random order; some frames have one too many.
std::vector<WandFrame> waved(const StereoRig& rig, const std::vector<double>& lights, int n, double noise,
                             std::uint64_t seed, double extra = 0) {
  Random random(seed);
  std::vector<WandFrame> frames;
  while (static_cast<int>(frames.size()) < n) {
    WandFrame frame;
    frame.time = 0.01 * static_cast<double>(frames.size());
    const double z = random.uniform(0.4, 0.9);
    const Eigen::Vector3d place(random.uniform(-0.3, 0.45) * z, random.uniform(-0.35, 0.35) * z, z);
    const Eigen::Vector3d direction = random.direction();
    const std::uint64_t first = random.below(lights.size());
    for (std::size_t k = 0; k < lights.size(); ++k) {
      const Eigen::Vector3d left = place + lights[(k + first) % lights.size()] * direction;
      const Eigen::Vector2d u = project(rig.left, left),
                            v = project(rig.right, rig.rotation * left + rig.translation);
      frame.left.insert(frame.left.begin() + static_cast<std::ptrdiff_t>(random.below(k + 1)),
                        u + noise * Eigen::Vector2d(random.normal(), random.normal()));
      frame.right.insert(frame.right.begin() + static_cast<std::ptrdiff_t>(random.below(k + 1)),
                         v + noise * Eigen::Vector2d(random.normal(), random.normal()));
    }
    bool is_visible = true;
    for (const auto* blobs : {&frame.left, &frame.right})
      for (const Eigen::Vector2d& p : *blobs)
        is_visible = is_visible && p.x() > 5 && p.y() > 5 && p.x() < 635 && p.y() < 475;
    if (!is_visible) continue;
    if (random.uniform() < extra) frame.left.emplace_back(100, 100);
    frames.push_back(frame);
  }
  return frames;
}

StereoRig knocked(const StereoRig& rig, double angle) {
  StereoRig result = rig;
  result.rotation = so3_exp(angle * Eigen::Vector3d(0.6, -0.5, 0.62)) * rig.rotation;
  result.translation *= 1.03;
  return result;
}

const std::vector<double> kPen = WandOptions{}.lights;

// Pen of four lights and bar of two: the rig that was knocked by 2 degrees and whose scale is off by 3 % is
// found.
TEST(CalibrateWand, FindsTheRigOfExactBlobs) {
  const StereoRig truth = usual_rig();
  for (const std::vector<double>& lights : {kPen, std::vector<double>{0, 0.2}}) {
    const WandCalibration found =
        calibrate_wand(knocked(truth, radians(2.0)), waved(truth, lights, 60, 0, 3), {.lights = lights});
    EXPECT_LT((found.rig.rotation - truth.rotation).norm(), 1e-6);
    EXPECT_LT((found.rig.translation - truth.translation).norm(), 1e-6);
    EXPECT_GT(found.before.epipolar, 3);
    EXPECT_LT(found.after.epipolar, 1e-4);
    EXPECT_NEAR(found.after.length, lights.back(), 1e-6);
  }
}

// Twenty seeds with six numbers each.
TEST(CalibrateWand, KnowsHowWellItKnows) {
  const StereoRig truth = usual_rig();
  int within = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const WandCalibration found = calibrate_wand(knocked(truth, 0.01), waved(truth, kPen, 60, 0.1, seed));
    const Eigen::Vector3d turn = so3_log(found.rig.rotation * truth.rotation.transpose());
    const Eigen::Vector3d shift = found.rig.translation - truth.translation;
    for (int k = 0; k < 3; ++k) {
      within += std::abs(turn[k]) < 2 * found.rotation_deviation[k] ? 1 : 0;
      within += std::abs(shift[k]) < 2 * found.translation_deviation[k] ? 1 : 0;
    }
    EXPECT_NEAR(found.rms, 0.1 * std::sqrt(2.0 * 11 / 16), 0.01);  // 5 of 16 numbers per frame fit the place
  }
  EXPECT_NEAR(within / 120.0, 0.954, 0.07);  // of a normal distribution within 2 σ
}

TEST(CalibrateWand, LeavesOutFramesWithOtherLightsAndOutliers) {
  const StereoRig truth = usual_rig();
  std::vector<WandFrame> frames = waved(truth, kPen, 100, 0.1, 5, 0.2);
  const int extra = static_cast<int>(std::count_if(
      frames.begin(), frames.end(), [](const WandFrame& frame) { return frame.left.size() > 4; }));
  ASSERT_GT(extra, 5);
  int moved = 0;
  for (std::size_t k = 0; k < frames.size(); k += 10) {
    if (frames[k].left.size() > 4) continue;
    frames[k].left[0] += Eigen::Vector2d(9, -12);
    ++moved;
  }
  const WandCalibration found = calibrate_wand(knocked(truth, 0.01), frames);
  EXPECT_EQ(found.before.unused, extra);
  EXPECT_NEAR(found.left_out, moved, 2);
  EXPECT_LT(so3_log(found.rig.rotation * truth.rotation.transpose()).norm(), 0.001);
}

TEST(CheckWand, MeasuresLengthAndItsTrend) {
  const StereoRig truth = usual_rig();
  StereoRig rig = truth;
  rig.translation *= 1.01;
  const WandCheck check = check_wand(rig, waved(truth, kPen, 50, 0, 7));
  EXPECT_NEAR(check.length, 1.01 * 0.16, 1e-8);
  EXPECT_LT(check.epipolar, 1e-6);
  EXPECT_NEAR(check.trend, 0, 1e-8);
  // A wand that grows by a tenth during the recording: each frame is one of a longer wand.
  std::vector<WandFrame> growing;
  for (int k = 0; k < 50; ++k) {
    std::vector<double> lights = kPen;
    for (double& light : lights) light *= 1 + 0.1 * k / 49;
    WandFrame frame = waved(truth, lights, 1, 0, static_cast<std::uint64_t>(k))[0];
    frame.time = k;
    growing.push_back(frame);
  }
  EXPECT_NEAR(check_wand(truth, growing).trend, 0.016, 1e-4);
}

TEST(CalibrateWand, RefusesInWords) {
  const StereoRig rig = usual_rig();
  const auto said = [&](const std::vector<WandFrame>& frames, const WandOptions& options = {}) {
    return refusal([&] { calibrate_wand(rig, frames, options); });
  };
  EXPECT_NE(said({}).find("no frame shows all 4 lights"), std::string::npos);
  EXPECT_NE(said(waved(rig, kPen, 19, 0, 1)).find("at least 20"), std::string::npos);
  const std::vector<WandFrame> one = waved(rig, kPen, 1, 0, 1);
  EXPECT_NE(said(std::vector<WandFrame>(30, one[0])).find("stayed nearly in one place"), std::string::npos);
  EXPECT_NE(said(one, {.lights = {0.1, 0.2}}).find("lights"), std::string::npos);
  EXPECT_NE(said(one, {.lights = {0, 0.2, 0.1}}).find("increase"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
