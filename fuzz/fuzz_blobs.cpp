#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/capture/pen_strokes.hpp"
#include "batten/capture/pen_tracker.hpp"
#include "batten/core/error.hpp"
#include "batten/io/blobs_io.hpp"
#include "batten/simulation/pen.hpp"

/// Whatever the bytes: a recording that is tracked, or refused in words, or a sentence about the file; and
/// poses of a pen, which are read back as they were.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  try {
    batten::BlobRecording recording = batten::parse_blobs(text, "input.jsonl");
    if (batten::format_blobs(batten::parse_blobs(batten::format_blobs(recording), "again.jsonl")) !=
        batten::format_blobs(recording))
      std::abort();
    if (recording.frames.size() > 40) recording.frames.resize(40);
    const auto track = batten::track_pen(recording, batten::nominal_rig(batten::PenRig::Vga), {});
    batten::strokes_of_track(track.samples, recording.buttons);
  } catch (const batten::InvalidInput&) {
    // No recording, or one that cannot be tracked.
  }
  try {
    const auto poses = batten::parse_pen_poses(text, "input.csv");
    batten::parse_pen_poses(batten::format_pen_poses(poses), "again.csv");
  } catch (const batten::FileError&) {
    // No poses.
  }
  return 0;
}
