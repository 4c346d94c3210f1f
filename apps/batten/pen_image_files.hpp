#pragma once
#include "command.hpp"

#include <cstdint>
#include <string>

#include "batten/camera/rig.hpp"
#include "batten/simulation/pen.hpp"

namespace batten::cli {

/// Name of the list of images in their folder.
constexpr const char* kImageList = "frames.jsonl";

/// Draws the frames of a simulated pen into a folder, which is made where it is missing: left-00000.pgm and
/// so on, and the list of them. @throws FileError.
void write_pen_images(const SimulatedPen& simulated, std::uint64_t seed, const std::string& folder,
                      const Progress& progress);

/// A recording of blobs (.jsonl), or the images of a folder with its list, with blobs found in them; what was
/// found is told in the outcome. @throws FileError naming the image that is in colour, of 16 bits, compressed
/// with losses, damaged, missing or of another size than its camera's.
BlobRecording read_pen_recording(const std::string& input, const StereoRig& rig, Outcome& outcome,
                                 const Progress& progress);

}  // namespace batten::cli
