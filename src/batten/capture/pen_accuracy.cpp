#include "batten/capture/pen_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kBands[] = {0.3, 0.6, 1.0, 1.5};
constexpr double kSameTime = 1e-6;            // seconds
constexpr double kInterpolated = 0.05;        // seconds between frames, at most
constexpr double kIdentityGate = 6;           // standard deviations
constexpr double kIdentityShare = 1.0 / 400;  // of the image's width: what a rig may be off by

class Truth {
 public:
  explicit Truth(std::span<const TimedPose> poses) : poses_(poses) {}
  bool covers(double time) const { return time >= poses_.front().time && time <= poses_.back().time; }
  PenPose at(double time) const {
    const auto next = std::upper_bound(poses_.begin() + 1, poses_.end() - 1, time,
                                       [](double t, const TimedPose& pose) { return t < pose.time; });
    const TimedPose& a = *(next - 1);
    const TimedPose& b = *next;
    const double w = b.time > a.time ? (time - a.time) / (b.time - a.time) : 0;
    return {(1 - w) * a.pose.tip + w * b.pose.tip,
            ((1 - w) * a.pose.direction + w * b.pose.direction).normalized()};
  }

 private:
  std::span<const TimedPose> poses_;
};

struct Collected {
  std::vector<double> tips, turns;

  void add(const PenPose& pose, const PenPose& truth) {
    tips.push_back((pose.tip - truth.tip).norm());
    turns.push_back(
        std::atan2(pose.direction.cross(truth.direction).norm(), pose.direction.dot(truth.direction)));
  }
  PenErrors errors() {
    PenErrors result;
    result.frames = static_cast<long>(tips.size());
    if (tips.empty()) return result;
    for (const double tip : tips) {
      result.mean += tip / static_cast<double>(tips.size());
      result.rms += tip * tip / static_cast<double>(tips.size());
      if (tip < 2e-3) result.below_2mm += 1.0 / static_cast<double>(tips.size());
    }
    result.rms = std::sqrt(result.rms);
    result.p95 = percentile(tips, 0.95);
    result.direction_p95 = percentile(turns, 0.95);
    return result;
  }
};

/// Blobs of the right camera at the time of a left frame: by the cubic through the four frames around it, two
/// before and two after, else by the line between two. Lines miss the tremor of a hand by more than the
/// blobs' errors at 60 frames a second.
struct RightFrames {
  struct Entry {
    const BlobFrame* frame;
    const LedBlobs* blobs;
  };
  std::vector<Entry> entries;

  void append(double time, std::vector<LedImage>& images) const {
    const auto next = std::lower_bound(entries.begin(), entries.end(), time - kSameTime,
                                       [](const Entry& entry, double t) { return entry.frame->time < t; });
    if (next == entries.end()) return;
    if (std::abs(next->frame->time - time) <= kSameTime) {
      append_images(CameraSide::Right, next->frame->blobs, *next->blobs, images);
      return;
    }
    if (next == entries.begin() || next->frame->time - (next - 1)->frame->time > kInterpolated) return;
    const std::span<const Entry> line(&*(next - 1), 2);
    std::span<const Entry> cubic;
    if (next - entries.begin() >= 2 && entries.end() - next >= 2 &&
        (next + 1)->frame->time - (next - 2)->frame->time < 3 * kInterpolated)
      cubic = {&*(next - 2), 4};
    for (int led = 0; led < kPenLeds; ++led) {
      std::optional<Blob> blob;
      if (!cubic.empty()) blob = interpolated(cubic, led, time);
      if (!blob) blob = interpolated(line, led, time);
      if (blob) images.push_back({CameraSide::Right, led, *blob});
    }
  }

 private:
  /// Lagrange's polynomial through an LED of all the frames; nothing where one of them does not see it.
  static std::optional<Blob> interpolated(std::span<const Entry> frames, int led, double time) {
    Blob result{Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero()};
    for (const Entry& entry : frames) {
      const int blob = (*entry.blobs)[static_cast<std::size_t>(led)];
      if (blob < 0) return {};
      double weight = 1;
      for (const Entry& other : frames)
        if (&other != &entry) weight *= (time - other.frame->time) / (entry.frame->time - other.frame->time);
      const Blob& seen = entry.frame->blobs[static_cast<std::size_t>(blob)];
      result.pixel += weight * seen.pixel;
      result.covariance += weight * weight * seen.covariance;
    }
    return result;
  }
};

int true_leds(const BlobFrame& frame, const StereoRig& rig, const Pen& pen, const PenPose& truth,
              double slack) {
  const LedBlobs found = nearest_blobs(rig, frame.camera, pen, truth, frame.blobs, kIdentityGate, slack);
  return static_cast<int>(std::count_if(found.begin(), found.end(), [](int blob) { return blob >= 0; }));
}

bool has_wrong_identity(const BlobFrame& frame, const LedBlobs& assigned, const StereoRig& rig,
                        const Pen& pen, const PenPose& truth, double slack) {
  for (int led = 0; led < kPenLeds; ++led) {
    const int blob = assigned[static_cast<std::size_t>(led)];
    if (blob < 0) continue;
    const Blob& seen = frame.blobs[static_cast<std::size_t>(blob)];
    const auto pixel = image_in(rig, frame.camera, led_position(pen, truth, led));
    const double gate = kIdentityGate * std::sqrt(seen.covariance.trace() / 2) + slack;
    if (!pixel || (seen.pixel - *pixel).norm() > gate) return true;
  }
  return false;
}

/// Poses of single left frames against their bound.
void judge_single_frames(const std::vector<RightFrames::Entry>& left, const RightFrames& right,
                         const StereoRig& rig, const Pen& pen, const Truth& truth, PenAccuracy& result) {
  double squares = 0, bounds = 0;
  for (const RightFrames::Entry& entry : left) {
    const double time = entry.frame->time;
    std::vector<LedImage> images;
    append_images(CameraSide::Left, entry.frame->blobs, *entry.blobs, images);
    const std::size_t n_left = images.size();
    right.append(time, images);
    if (n_left < 2 || images.size() < n_left + 2) continue;
    const PenPose pose = truth.at(time);
    // From a start that is off by more than any estimate is.
    PenPose start{pose.tip + Eigen::Vector3d::Constant(0.005),
                  (pose.direction + Eigen::Vector3d(0.02, 0, 0.02)).normalized()};
    const auto fitted = fit_pose(rig, pen, images, start);
    if (!fitted) continue;
    const PenInformation bound = pose_information(rig, pen, pose, images).inverse();
    squares += (fitted->pose.tip - pose.tip).squaredNorm();
    bounds += bound.topLeftCorner<3, 3>().trace();
    ++result.single_frames;
  }
  if (result.single_frames == 0) return;
  result.single_rms = std::sqrt(squares / static_cast<double>(result.single_frames));
  result.bound_rms = std::sqrt(bounds / static_cast<double>(result.single_frames));
}

}  // namespace

PenAccuracy pen_accuracy(const BlobRecording& recording, const PenTrack& track, const Pen& pen,
                         std::span<const TimedPose> poses) {
  if (poses.size() < 2) throw InvalidInput("the truth holds fewer than two poses");
  const Truth truth(poses);
  PenAccuracy result;
  Collected current, lagged, smoothed;
  std::array<Collected, std::size(kBands) - 1> bands;
  std::vector<RightFrames::Entry> left;
  RightFrames right;
  std::array<int, 2> seen = {0, 0};
  long judged = 0;
  const Eigen::Vector3d middle = track.rig.right_centre() / 2;
  std::size_t s = 0;
  for (const BlobFrame& frame : recording.frames) {
    while (s < track.samples.size() && (track.samples[s].time < frame.time)) ++s;
    if (s == track.samples.size()) break;
    const PenSample& sample = track.samples[s];
    if (sample.time != frame.time || sample.camera != frame.camera) continue;
    ++s;
    if (!truth.covers(frame.time)) continue;
    ++judged;
    const PenPose pose = truth.at(frame.time);
    const Camera& camera = frame.camera == CameraSide::Left ? track.rig.left : track.rig.right;
    const double slack = kIdentityShare * camera.width;
    seen[static_cast<std::size_t>(frame.camera)] =
        true_leds(frame, track.rig, pen, pose, slack / kIdentityGate);
    const bool answered = sample.state != PenState::Lost;
    if (seen[0] >= 3 && seen[1] >= 3) {
      ++result.answerable;
      if (answered) ++result.answered;
    }
    if (!answered) continue;
    if (has_wrong_identity(frame, sample.blobs, track.rig, pen, pose, slack)) ++result.wrong_identities;
    (frame.camera == CameraSide::Left ? left : right.entries).push_back({&frame, &sample.blobs});
    current.add(sample.current, pose);
    lagged.add(sample.pose, pose);
    smoothed.add(sample.smoothed, pose);
    const double distance = (pose.tip - middle).norm();
    for (std::size_t band = 0; band < bands.size(); ++band)
      if (distance >= kBands[band] && distance < kBands[band + 1]) bands[band].add(sample.pose, pose);
    const Eigen::Vector3d off = sample.pose.tip - pose.tip;
    const Eigen::Matrix3d covariance = sample.covariance.topLeftCorner<3, 3>();
    if (covariance.trace() > 0) result.mean_chi_square += off.dot(covariance.ldlt().solve(off)) / 3;
  }
  if (judged == 0) throw InvalidInput("the truth and the recording have no time in common");
  result.current = current.errors();
  result.lagged = lagged.errors();
  result.smoothed = smoothed.errors();
  if (result.lagged.frames > 0) result.mean_chi_square /= static_cast<double>(result.lagged.frames);
  for (std::size_t band = 0; band < bands.size(); ++band)
    if (!bands[band].tips.empty())
      result.bands.push_back({kBands[band], kBands[band + 1], bands[band].errors()});
  judge_single_frames(left, right, track.rig, pen, truth, result);
  return result;
}

}  // namespace batten
