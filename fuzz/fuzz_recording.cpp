#include <cstdint>
#include <cstdlib>
#include <string>

#include "batten/capture/decode.hpp"
#include "batten/capture/preview.hpp"
#include "batten/capture/recording.hpp"
#include "batten/io/file.hpp"

/// Any bytes as a recording: events that come back as they were, a decoded log or a sentence, a preview.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  batten::Recording recording;
  try {
    recording = batten::parse_recording(text, "input.blog");
  } catch (const batten::FileError&) {
    return 0;
  }
  for (const batten::CaptureEvent& event : recording.events) {
    std::string line = batten::format_event(event);
    line.pop_back();
    if (batten::parse_event(line) != event) std::abort();
  }
  try {
    const batten::DecodedRecording decoded = batten::decode_recording(recording);
    batten::scan_from_recording(decoded);
  } catch (const batten::InvalidInput&) {
    // No readings, no curves, no usable calibration.
  }
  try {
    batten::LivePreview preview(recording.header);
    for (const batten::CaptureEvent& event : recording.events) preview.push(event);
  } catch (const batten::InvalidInput&) {
    // A calibration or form in the header that cannot be read.
  }
  return 0;
}
