#include "batten/pipeline/image_blobs.hpp"

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kWhiteShare = 0.2;   // of the pixels: the image is overexposed
constexpr double kSomeWhite = 0.02;   // worth a warning
constexpr double kBlackLevel = 0.5;   // grey levels of background and
constexpr double kBlackNoise = 0.45;  // of noise, at which nothing reaches the sensor

void add_image(const BlobExtraction& found, ImagedSide& side) {
  ++side.images;
  side.blobs += static_cast<long>(found.blobs.size());
  side.refused.cut += found.refused.cut;
  side.refused.size += found.refused.size;
  side.refused.shape += found.refused.shape;
  side.refused.bright += found.refused.bright;
  side.background += found.background;
  side.noise += found.noise;
  side.clipped += found.clipped;
}

/// Turns sums into means and tells what is wrong with the exposure.
void judge_side(const char* camera, ImagedSide& side, std::vector<std::string>& warnings) {
  if (side.images == 0) return;
  const auto n = static_cast<double>(side.images);
  side.background /= n;
  side.noise /= n;
  side.clipped /= n;
  if (side.blobs == 0) {
    if (side.clipped > kWhiteShare)
      throw InvalidInput(concat("the images of the ", camera, " camera are overexposed: ", 100 * side.clipped,
                                " % of their pixels are white; shorten the exposure"));
    if (side.background < kBlackLevel && side.noise < kBlackNoise && side.refused.total() == 0)
      throw InvalidInput(concat("the images of the ", camera,
                                " camera are black; is the lens covered, or the exposure too short?"));
    throw InvalidInput(concat("no image of the ", camera, " camera shows an LED (", side.refused.total(),
                              " bright spots were of the wrong size, shape or brightness)"));
  }
  if (side.clipped > kSomeWhite)
    warnings.push_back(concat(100 * side.clipped, " % of the pixels of the ", camera,
                              " camera are white; shorten its exposure"));
}

}  // namespace

ImageBlobs blobs_of_images(BlobRecording recording, const StereoRig& rig,
                           const std::function<GreyImage(const std::string& name)>& read,
                           const Progress& progress) {
  ImageBlobs result;
  std::vector<BlobExtraction> found(recording.frames.size());
  const BlobExtractionOptions options[2] = {blob_extraction_for(rig.left), blob_extraction_for(rig.right)};
  const auto extract = [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const BlobFrame& frame = recording.frames[static_cast<std::size_t>(i)];
      if (frame.image.empty()) continue;
      const bool right = frame.camera == CameraSide::Right;
      const Camera& camera = right ? rig.right : rig.left;
      const GreyImage image = read(frame.image);
      if (image.width != camera.width || image.height != camera.height)
        throw InvalidInput(concat(frame.image, " has ", image.width, " x ", image.height, " pixels, the ",
                                  right ? "right" : "left", " camera of the rig ", camera.width, " x ",
                                  camera.height, "; is it the rig of these cameras?"));
      found[static_cast<std::size_t>(i)] = extract_blobs(image, options[right ? 1 : 0]);
    }
  };
  parallel_for(static_cast<Eigen::Index>(found.size()), 1, extract, progress);
  for (std::size_t i = 0; i < found.size(); ++i) {
    BlobFrame& frame = recording.frames[i];
    if (frame.image.empty()) continue;
    add_image(found[i], result.sides[frame.camera == CameraSide::Right ? 1 : 0]);
    frame.blobs = std::move(found[i].blobs);
    frame.image.clear();
  }
  judge_side("left", result.sides[0], result.warnings);
  judge_side("right", result.sides[1], result.warnings);
  result.recording = std::move(recording);
  return result;
}

}  // namespace batten
