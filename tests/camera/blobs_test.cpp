#include "batten/camera/blobs.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

// A recording that nothing was put into is empty, of images whose size is not known.
TEST(BlobRecording, IsEmptyAtFirst) {
  const BlobRecording recording;
  EXPECT_TRUE(recording.frames.empty() && recording.inertial.empty() && recording.buttons.empty());
  EXPECT_EQ(recording.width, 0);
  EXPECT_FALSE(TimedPose().drawing);
  EXPECT_NEAR(TimedPose().pose.direction.norm(), 1, 1e-15);
}

}  // namespace
}  // namespace batten
