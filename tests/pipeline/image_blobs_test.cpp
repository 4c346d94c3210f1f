#include "batten/pipeline/image_blobs.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/simulation/pen.hpp"

namespace batten {
namespace {

BlobRecording two_frames() {
  BlobRecording recording;
  recording.frames = {{0.0, CameraSide::Left, {}, "a"}, {0.0, CameraSide::Right, {}, "b"}};
  return recording;
}

TEST(BlobsOfImages, PutsTheBlobsOfEachImageIntoItsFrame) {
  const StereoRig rig = nominal_rig(PenRig::Wiimote);
  const auto read = [&](const std::string& name) {
    const double u = name == "a" ? 30 : 70;
    return pen_image(rig.left, {{SeenLight::Kind::Led, {{u, 40}}, 0.7, 150}}, 1, 0);
  };
  BlobRecording recording = two_frames();
  recording.frames.push_back({0.1, CameraSide::Left, {{{1, 2}, Eigen::Matrix2d::Identity()}}});
  const ImageBlobs found = blobs_of_images(recording, rig, read);
  ASSERT_EQ(found.recording.frames.size(), 3u);
  ASSERT_EQ(found.recording.frames[0].blobs.size(), 1u);
  ASSERT_EQ(found.recording.frames[1].blobs.size(), 1u);
  EXPECT_NEAR(found.recording.frames[0].blobs[0].pixel.x(), 30, 0.1);
  EXPECT_NEAR(found.recording.frames[1].blobs[0].pixel.x(), 70, 0.1);
  EXPECT_TRUE(found.recording.frames[0].image.empty());
  EXPECT_EQ(found.recording.frames[2].blobs[0].pixel.x(), 1) << "blobs that were there stay";
  EXPECT_EQ(found.sides[0].images, 1);
}

TEST(BlobsOfImages, SaysWhatIsWrongWithTheImages) {
  const StereoRig rig = nominal_rig(PenRig::Wiimote);
  const auto sentence = [&](int width, std::uint8_t level) -> std::string {
    const auto read = [&](const std::string&) {
      return GreyImage{width, 96, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * 96, level)};
    };
    try {
      blobs_of_images(two_frames(), rig, read);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(sentence(64, 9).find("128 x 96"), std::string::npos);
  EXPECT_NE(sentence(128, 255).find("overexposed"), std::string::npos);
  EXPECT_NE(sentence(128, 0).find("black"), std::string::npos);
  EXPECT_NE(sentence(128, 90).find("no image of the left camera shows an LED"), std::string::npos);
}

}  // namespace
}  // namespace batten
