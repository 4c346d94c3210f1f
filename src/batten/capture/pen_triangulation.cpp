#include "batten/capture/pen_triangulation.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kHandSpeedBetweenFrames = 0.2;  // m/s, for blobs of frames of different times
constexpr double kRigError = 0.3;                // pixels, that a rig may be off by
constexpr double kDirectionRemembered = 1.0;     // seconds, for which the last direction helps

/// The pose of one pair of frames, and which blobs it is made of.
bool pose_of_frames(const BlobFrame& left, const BlobFrame& right, const StereoRig& rig, const Pen& pen,
                    Triangulation method, const std::optional<Eigen::Vector3d>& direction,
                    PenSample& sample) {
  IdentificationOptions search;
  search.motion = kHandSpeedBetweenFrames * std::abs(left.time - right.time);
  search.rig_error = kRigError;
  search.direction = direction;
  const Identification found = identify(rig, pen, left.blobs, right.blobs, search);
  if (found.state != IdentificationState::Found) {
    sample.reason = found.reason;
    return false;
  }
  std::vector<int> leds;
  std::vector<Eigen::Vector3d> points;
  for (int led = 0; led < kPenLeds; ++led) {
    const int a = found.left[static_cast<std::size_t>(led)], b = found.right[static_cast<std::size_t>(led)];
    if (a < 0 || b < 0) continue;
    const auto point = triangulate(rig, left.blobs[static_cast<std::size_t>(a)].pixel,
                                   right.blobs[static_cast<std::size_t>(b)].pixel, method);
    if (!point) continue;
    leds.push_back(led);
    points.push_back(point->position);
  }
  if (leds.size() < 2) {
    sample.reason = "fewer than two LEDs are seen by both cameras";
    return false;
  }
  sample.blobs = found.left;
  sample.current = pose_of_points(pen, leds, points);
  return true;
}

/// Poses near in time, weighted; over a gap in which the pen was lost, too.
void smooth_by_gaussian(std::vector<PenSample>& samples, double sigma) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    PenSample& sample = samples[i];
    sample.pose = sample.current;
    if (sample.state == PenState::Tracked && sigma > 0) {
      PenPose sum{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      double total = 0;
      const auto add = [&](const PenSample& other) {
        const double t = (other.time - sample.time) / sigma;
        if (std::abs(t) > 4) return false;
        if (other.state == PenState::Lost) return true;
        const double weight = std::exp(-t * t / 2);
        sum.tip += weight * other.current.tip;
        sum.direction += weight * other.current.direction;
        total += weight;
        return true;
      };
      for (std::size_t k = i; k < samples.size() && add(samples[k]); ++k) continue;
      for (std::size_t k = i; k-- > 0 && add(samples[k]);) continue;
      sample.pose = {sum.tip / total, sum.direction.normalized()};
    }
    sample.smoothed = sample.pose;
  }
}

}  // namespace

std::optional<std::string> TriangulatedTrackOptions::problem() const {
  if (!(gaussian >= 0 && gaussian <= 10)) return concat("gaussian is ", gaussian, "; expected 0 to 10 s");
  return {};
}

PenTrack track_pen_by_triangulation(const BlobRecording& recording, const StereoRig& rig, const Pen& pen,
                                    const TriangulatedTrackOptions& options) {
  if (const std::string found = problem(rig); !found.empty()) throw InvalidInput("rig: " + found);
  if (const std::string found = problem(pen); !found.empty()) throw InvalidInput("pen: " + found);
  if (const auto found = options.problem()) throw InvalidInput(*found);
  PenTrack track;
  track.rig = rig;
  const BlobFrame* right = nullptr;
  std::optional<Eigen::Vector3d> direction;
  double direction_time = 0;
  const std::vector<BlobFrame>& frames = recording.frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const BlobFrame& frame = frames[i];
    if (frame.camera == CameraSide::Right) {
      right = &frame;
      continue;
    }
    // Of synchronous cameras the right frame of the same time is the newest.
    if (i + 1 < frames.size() && frames[i + 1].camera == CameraSide::Right &&
        frames[i + 1].time <= frame.time)
      right = &frames[i + 1];
    PenSample sample;
    sample.time = frame.time;
    sample.covariance = sample.smoothed_covariance = PenInformation::Zero();
    sample.reason = "no frame of the right camera yet";
    if (frame.time - direction_time > kDirectionRemembered) direction.reset();
    if (right && pose_of_frames(frame, *right, rig, pen, options.triangulation, direction, sample)) {
      sample.state = PenState::Tracked;
      sample.reason.clear();
      direction = sample.current.direction;
      direction_time = frame.time;
    }
    track.samples.push_back(std::move(sample));
  }
  smooth_by_gaussian(track.samples, options.gaussian);
  track.report.frames = static_cast<long>(track.samples.size());
  for (const PenSample& sample : track.samples) {
    if (sample.state == PenState::Tracked)
      ++track.report.tracked;
    else {
      ++track.report.lost;
      ++track.report.lost_because[sample.reason];
    }
  }
  return track;
}

}  // namespace batten
