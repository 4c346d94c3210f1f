#include "batten/capture/pen_identification.hpp"

#include "capture/pens.hpp"

#include <algorithm>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

struct Outcome {
  int right = 0, wrong = 0, ambiguous = 0, none = 0;
};

/// Identifies `n` random poses of which some LEDs are seen, with blobs that are none; blobs are turned round.
Outcome identify_many(int n, const std::vector<int>& leds, int false_blobs, bool with_direction,
                      std::uint64_t seed) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  const Pen pen;
  Random random(seed);
  Outcome outcome;
  for (int trial = 0; trial < n; ++trial) {
    const PenPose truth = random_pose(random);
    std::array<std::vector<Blob>, 2> blobs;
    for (const CameraSide side : {CameraSide::Left, CameraSide::Right}) {
      auto& list = blobs[static_cast<std::size_t>(side)];
      list = blobs_of(rig, side, pen, truth, 0.02, random, leds);
      for (int k = 0; k < false_blobs; ++k)
        list.push_back(
            {{random.uniform(0, 1280), random.uniform(0, 1024)}, 4e-4 * Eigen::Matrix2d::Identity()});
      std::reverse(list.begin(), list.end());
    }
    IdentificationOptions options;
    if (with_direction) options.direction = truth.direction;
    const Identification found = identify(rig, pen, blobs[0], blobs[1], options);
    if (found.state == IdentificationState::Ambiguous) ++outcome.ambiguous;
    if (found.state == IdentificationState::None) ++outcome.none;
    if (found.state != IdentificationState::Found) {
      EXPECT_FALSE(found.reason.empty());
      continue;
    }
    const bool right = (found.estimate.pose.tip - truth.tip).norm() < 2e-3;
    ++(right ? outcome.right : outcome.wrong);
    if (!right) continue;
    for (std::size_t k = 0; k < leds.size(); ++k) {  // the blobs were turned round, false ones first
      const int blob = found.left[static_cast<std::size_t>(leds[k])];
      const int expected = false_blobs + static_cast<int>(leds.size() - 1 - k);
      EXPECT_TRUE(blob == expected || blob == -1) << "LED " << leds[k] << " is blob " << blob;
    }
  }
  return outcome;
}

TEST(Identify, FindsAllLedsAmongFalseBlobs) {
  const Outcome outcome = identify_many(200, {0, 1, 2, 3}, 2, false, 4);
  EXPECT_EQ(outcome.right, 200);
}

TEST(Identify, FindsAPenWithoutItsTipLed) {
  const Outcome outcome = identify_many(200, {1, 2, 3}, 2, false, 5);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GE(outcome.right, 190);
}

// All six distances differ, but a distance has no sense.
TEST(Identify, TwoLedsAreAmbiguousUntilTheDirectionIsKnown) {
  const Outcome blind = identify_many(100, {0, 2}, 0, false, 6);
  EXPECT_EQ(blind.right + blind.wrong, 0);
  EXPECT_EQ(blind.ambiguous, 100);
  const Outcome known = identify_many(100, {0, 2}, 0, true, 6);
  EXPECT_EQ(known.right, 100);
}

TEST(Identify, SaysWhatIsMissing) {
  const StereoRig rig = nominal_rig(PenRig::Global);
  const Pen pen;
  Random random(7);
  const PenPose truth = random_pose(random);
  const auto left = blobs_of(rig, CameraSide::Left, pen, truth, 0.02, random);
  const auto right = blobs_of(rig, CameraSide::Right, pen, truth, 0.02, random, {1});
  const Identification found = identify(rig, pen, left, right);
  EXPECT_EQ(found.state, IdentificationState::None);
  EXPECT_EQ(found.reason, "the left camera sees 4 blobs, the right one 1; a pose takes two in each");
  EXPECT_EQ(identify(rig, pen, {}, {}).state, IdentificationState::None);
  IdentificationOptions inside_out;
  inside_out.nearest = 0;
  EXPECT_THROW(identify(rig, pen, left, right, inside_out), InvalidInput);
}

}  // namespace
}  // namespace batten::test
