#include "batten/pipeline/tracked_pen.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

constexpr double kManyLost = 0.2;   // share of frames
constexpr double kRigTrust = 4;     // standard deviations that a rig may be off before it is said
constexpr double kRigSaid = 2e-3;   // radians
constexpr double kFloorSaid = 0.2;  // pixels

void add_warnings(const BlobRecording& recording, const StereoRig& rig, TrackedPen& result) {
  const TrackReport& report = result.track.report;
  if (static_cast<double>(report.lost) > kManyLost * static_cast<double>(report.frames)) {
    std::string most;
    long frames = 0;
    for (const auto& [reason, n] : report.lost_because)
      if (n > frames) {
        most = reason;
        frames = n;
      }
    result.warnings.push_back(
        concat("the pen was lost in ", report.lost, " of ", report.frames, " frames, mostly because ", most));
  }
  if (recording.width > 0 && (recording.width != rig.left.width || recording.height != rig.left.height))
    result.warnings.push_back(concat("the images have ", recording.width, " x ", recording.height,
                                     " pixels, those of the rig ", rig.left.width, " x ", rig.left.height,
                                     "; is it the rig of these cameras?"));
  if (report.rig_turn.norm() > kRigSaid && report.rig_turn.norm() > kRigTrust * report.rig_turn_sigma.norm())
    result.warnings.push_back(concat("the right camera is turned by ", degrees(report.rig_turn.norm()),
                                     " degrees against the rig; calibrate it again"));
  if (report.blob_floor > kFloorSaid)
    result.warnings.push_back(
        concat("blobs lie ", report.blob_floor,
               " pixels off what the rig and the pen allow; calibrate the rig again, or "
               "check the places of the LEDs"));
}

}  // namespace

std::optional<std::string> TrackedPenOptions::problem() const {
  if (const std::string found = batten::problem(pen); !found.empty()) return "pen: " + found;
  if (const auto found = track.problem()) return "track: " + *found;
  if (const auto found = triangulated.problem()) return "triangulated: " + *found;
  if (const auto found = strokes.problem()) return "strokes: " + *found;
  return {};
}

TrackedPen tracked_pen(const BlobRecording& recording, const StereoRig& rig,
                       const TrackedPenOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  TrackedPen result;
  {
    const ScopedStage stage(result.times, "track");
    result.track = options.method == PenMethod::Bundle
                       ? track_pen(recording, rig, options.pen, options.track)
                       : track_pen_by_triangulation(recording, rig, options.pen, options.triangulated);
  }
  {
    const ScopedStage stage(result.times, "strokes");
    result.strokes = strokes_of_track(result.track.samples, recording.buttons, options.strokes);
  }
  add_warnings(recording, rig, result);
  return result;
}

}  // namespace batten
