#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/camera/grey_image.hpp"
#include "batten/camera/rig.hpp"
#include "batten/capture/blob_extraction.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// What the images of one camera were like.
struct ImagedSide {
  long images = 0, blobs = 0;
  RefusedBlobs refused;
  double background = 0, noise = 0;  ///< mean over the images, grey levels
  double clipped = 0;                ///< mean share of white pixels
};

/// A recording whose images have become blobs.
struct ImageBlobs {
  BlobRecording recording;
  std::array<ImagedSide, 2> sides;  ///< left, right
  std::vector<std::string> warnings;
};

/// Finds the blobs in the images that frames of a recording name (extract_blobs(), for LEDs of 2.5 mm radius
/// no nearer than 0.2 m), on all threads. Frames that have blobs already stay as they are.
/// @param read  gives the image of a name; called by several threads at once; what it throws is thrown on
/// @throws InvalidInput naming the image that has not the size of its camera, and where no image of a
/// camera shows a blob, with what its exposure was like.
ImageBlobs blobs_of_images(BlobRecording recording, const StereoRig& rig,
                           const std::function<GreyImage(const std::string& name)>& read,
                           const Progress& progress = {});

}  // namespace batten
