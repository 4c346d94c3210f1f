#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/capture/pen_identification.hpp"
#include "batten/core/choices.hpp"

namespace batten {

/// How a pen is followed through the frames of two cameras.
struct TrackOptions {
  /// A pose is answered when frames this much younger are in, seconds, 0 to 1. Of what any future can give
  /// 30 ms bring all but a tenth.
  double lag = 0.03;
  /// Density of the jerk of the hand to begin with, m/s³/√Hz, above 0; then by the innovations' χ².
  double jerk = 10;
  /// How long a pose is carried on while neither camera sees two LEDs, seconds, at least 0; then the pen is
  /// lost.
  double bridge = 0.2;
  /// Standard deviation of the tip, metres, above 0, beyond which there is no answer but "lost".
  double largest_sigma = 5e-3;
  /// Standard deviations of the rig as it was calibrated: the turn of the right camera, radians, and its
  /// relative focal length. The known distances of the LEDs and the frames' epipolar residuals correct both
  /// while tracking; 0: the rig is exact.
  double rotation_sigma = 5e-4;
  double focal_sigma = 1.5e-3;
  double blob_floor = 0.01;  ///< standard deviation added to every blob, pixels, at least 0
  double nearest = 0.1;      ///< least depth of an LED, metres, above 0
  double farthest = 3.0;     ///< greatest one

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

enum class PenState {
  Tracked,
  Bridged,  ///< carried on over frames without an LED
  Lost,     ///< there is no pose; the reason says why
};

constexpr auto choices_of(PenState) {
  return choices<PenState>(
      "state", {{PenState::Tracked, "tracked"}, {PenState::Bridged, "bridged"}, {PenState::Lost, "lost"}});
}

/// What is known of the pen at the time of one frame.
struct PenSample {
  double time = 0;
  CameraSide camera = CameraSide::Left;
  PenState state = PenState::Lost;
  PenPose current;            ///< without lag, from frames until this one
  PenPose pose;               ///< with the lag of the options
  PenInformation covariance;  ///< of `pose`, as in PoseEstimate
  PenPose smoothed;           ///< from all frames, once the pen is up or lost
  PenInformation smoothed_covariance;
  LedBlobs blobs = {-1, -1, -1, -1};  ///< of this frame
  std::string reason;                 ///< where lost
};

/// What a tracker has done and found.
struct TrackReport {
  long frames = 0, tracked = 0, bridged = 0, lost = 0;
  long searches = 0;                                   ///< exhaustive ones
  long restarts = 0;                                   ///< times that the pen was found and confirmed
  std::map<std::string, long> lost_because;            ///< frames
  Eigen::Vector3d rig_turn = Eigen::Vector3d::Zero();  ///< of the right camera against the rig given, radians
  Eigen::Vector3d rig_turn_sigma = Eigen::Vector3d::Zero();
  double rig_focal = 0;  ///< relative, of the right camera
  double rig_focal_sigma = 0;
  double jerk = 0;        ///< at the end, m/s³/√Hz
  double blob_floor = 0;  ///< at the end, pixels
};

/// Follows a pen frame by frame. Every frame is a measurement of its own at its own time: cameras need not be
/// synchronised. State: tip and direction with two derivatives each, and what the rig is off. LEDs are
/// looked for where they are predicted (4 σ), and by identify() at the start, when the pen was lost, when few
/// LEDs are found, and now and then as a check. Well under 1 ms a frame.
class PenTracker {
 public:
  /// @throws InvalidInput on a bad rig, pen or option.
  PenTracker(const StereoRig& rig, const Pen& pen, const TrackOptions& options = {});
  ~PenTracker();
  PenTracker(PenTracker&&) noexcept;
  PenTracker& operator=(PenTracker&&) noexcept;

  /// Takes in a frame, no older than the one before. @throws InvalidInput otherwise.
  void push(const BlobFrame& frame);
  /// A stroke has ended: what is known of its past is smoothed.
  void pen_up();
  /// No more frames will come.
  void finish();

  /// One for every frame. Of those younger than the lag only `current` and `blobs` are final.
  const std::vector<PenSample>& samples() const;
  TrackReport report() const;
  /// The rig as the tracker has corrected it.
  StereoRig rig() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// A whole recording followed.
struct PenTrack {
  std::vector<PenSample> samples;
  TrackReport report;
  StereoRig rig;  ///< as corrected
};

/// All frames of a recording through a PenTracker; strokes end where its button goes up.
/// @throws InvalidInput on a bad rig, pen or option, and on a recording without frames of both cameras.
PenTrack track_pen(const BlobRecording& recording, const StereoRig& rig, const Pen& pen,
                   const TrackOptions& options = {});

}  // namespace batten
