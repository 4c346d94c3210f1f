#include "batten/capture/pen_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/capture/pen_association_detail.hpp"
#include "batten/capture/pen_filter_detail.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

using namespace detail;

namespace {

constexpr int kConfirmations = 4;       // frames with two LEDs in both cameras before a new track is answered
constexpr int kCheckEvery = 50;         // frames
constexpr int kCheckFewEvery = 5;       // frames, while fewer than six of eight LEDs are found
constexpr int kEnoughLeds = 6;          // in a pair of frames
constexpr double kPairing = 0.02;       // seconds, the most between two frames of a search
constexpr double kHandSpeed = 0.2;      // m/s, of a pen between two frames of a search
constexpr double kRemembered = 1.0;     // seconds, for which the direction of a lost pen helps
constexpr double kHopeless = 4;         // times the largest deviation that is answered: the pen is lost
constexpr int kStartingLeds = 5;        // in both images, of a pose that is begun with
constexpr int kMoreLeds = 2;            // that another pose must explain to take over
constexpr std::size_t kHistory = 2000;  // nodes
constexpr double kOverlap = 0.25;       // seconds of the past that are kept when the rest is smoothed
constexpr double kMemory = 0.99;        // per frame, of what innovations say
constexpr double kQuiet = 0.8,
                 kRestless = 1.2;  // of innovations per number, between which nothing is changed
constexpr double kLeastJerk = 5, kMostJerk = 200;
constexpr double kMostHaste = 64;   // of the jerk, for a frame that does not fit
constexpr double kMostFloor = 0.5;  // pixels

int count(const LedBlobs& blobs) {
  return static_cast<int>(std::count_if(blobs.begin(), blobs.end(), [](int blob) { return blob >= 0; }));
}

/// LEDs that were found in the last frames of both cameras.
int in_both(const std::array<LedBlobs, 2>& blobs) {
  int n = 0;
  for (std::size_t led = 0; led < kPenLeds; ++led) n += blobs[0][led] >= 0 && blobs[1][led] >= 0 ? 1 : 0;
  return n;
}

struct Node {
  double time;
  std::size_t sample;
  FilterNode filter;
  bool answered = false;
};

}  // namespace

struct PenTracker::Implementation {
  StereoRig rig;
  Pen pen;
  TrackOptions options;
  FilterNoise noise;

  std::vector<PenSample> samples;
  TrackReport totals;

  std::array<BlobFrame, 2> last_frames;
  std::array<bool, 2> seen = {false, false};
  std::array<int, 2> last_counts = {0, 0};
  std::array<LedBlobs, 2> last_blobs = {LedBlobs{-1, -1, -1, -1}, LedBlobs{-1, -1, -1, -1}};

  bool active = false;
  Belief belief;
  double belief_time = 0, last_led = 0;
  /// When both cameras saw the same two LEDs: epipolar lines and distance then say that it is the pen.
  double last_pair = 0;
  int confirmations = 0, misses = 0, since_check = 0;
  bool confirmed = false;
  std::deque<Node> history;
  std::string why = "no frame of both cameras yet";

  Belief rig_belief;  // of which only the rig is used
  std::optional<Eigen::Vector3d> last_direction;
  double last_direction_time = 0;
  double innovation = 1, residual = 0, expected = 0;

  void push(const BlobFrame& frame);
  void search(const BlobFrame& frame, std::size_t sample);
  void follow(const BlobFrame& frame, std::size_t sample);
  void check(const BlobFrame& frame);
  Identification identified() const;
  void start(const Identification& found, const BlobFrame& frame, std::size_t sample);
  void append(std::size_t sample, const Belief& predicted, const StateMatrix& gain);
  void adapt(const UpdateReport& report);
  void answer(double until);
  void smooth(double keep_from);
  void lose(const std::string& reason);
  void set_lost(PenSample& sample, const std::string& reason);
};

std::optional<std::string> TrackOptions::problem() const {
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (!(lag >= 0 && lag <= 1)) return range("lag", lag, "0 to 1 s");
  if (!(jerk > 0 && jerk < 1e6)) return range("jerk", jerk, "a density above 0");
  if (!(bridge >= 0 && bridge <= 10)) return range("bridge", bridge, "0 to 10 s");
  if (!(rotation_sigma >= 0 && rotation_sigma <= 0.1))
    return range("rotation_sigma", rotation_sigma, "0 to 0.1 rad");
  if (!(focal_sigma >= 0 && focal_sigma <= 0.1)) return range("focal_sigma", focal_sigma, "0 to 0.1");
  if (!(largest_sigma > 0)) return range("largest_sigma", largest_sigma, "metres above 0");
  if (!(blob_floor >= 0 && blob_floor <= 10)) return range("blob_floor", blob_floor, "0 to 10 pixels");
  if (!(nearest > 0)) return range("nearest", nearest, "metres above 0");
  if (!(farthest > nearest)) return range("farthest", farthest, "more than nearest");
  return {};
}

void PenTracker::Implementation::push(const BlobFrame& frame) {
  const auto side = static_cast<std::size_t>(frame.camera);
  if (!samples.empty() && frame.time < samples.back().time)
    throw InvalidInput(
        concat("a frame at ", frame.time, " s comes after one at ", samples.back().time, " s"));
  PenSample sample;
  sample.time = frame.time;
  sample.camera = frame.camera;
  sample.covariance = sample.smoothed_covariance = PenInformation::Zero();
  samples.push_back(sample);
  last_frames[side] = frame;
  seen[side] = true;
  const std::size_t index = samples.size() - 1;
  if (active)
    follow(frame, index);
  else
    search(frame, index);
}

void PenTracker::Implementation::set_lost(PenSample& sample, const std::string& reason) {
  sample.state = PenState::Lost;
  sample.reason = reason;
}

Identification PenTracker::Implementation::identified() const {
  IdentificationOptions search;
  search.nearest = options.nearest;
  search.farthest = options.farthest;
  search.motion = kHandSpeed * std::abs(last_frames[0].time - last_frames[1].time);
  const double turn =
      std::sqrt(rig_belief.covariance.bottomRightCorner<4, 4>().topLeftCorner<3, 3>().trace() / 3);
  search.rig_error = std::hypot(noise.blob_floor, turn * rig.right.fx);
  if (last_direction &&
      std::max(last_frames[0].time, last_frames[1].time) - last_direction_time < kRemembered)
    search.direction = last_direction;
  return identify(corrected(rig, rig_belief.mean), pen, last_frames[0].blobs, last_frames[1].blobs, search);
}

void PenTracker::Implementation::search(const BlobFrame& frame, std::size_t sample) {
  if (!seen[0] || !seen[1] || std::abs(last_frames[0].time - last_frames[1].time) > kPairing) {
    set_lost(samples[sample],
             seen[0] && seen[1] ? "no frames of both cameras within 20 ms of each other" : why);
    return;
  }
  ++totals.searches;
  const Identification found = identified();
  if (found.state != IdentificationState::Found) {
    why = found.reason;
    set_lost(samples[sample], why);
    return;
  }
  if (count(found.left) + count(found.right) < kStartingLeds) {
    why = "two LEDs in each camera are too few to begin with";
    set_lost(samples[sample], why);
    return;
  }
  start(found, frame, sample);
}

void PenTracker::Implementation::start(const Identification& found, const BlobFrame& frame,
                                       std::size_t sample) {
  active = true;
  confirmed = false;
  confirmations = misses = since_check = 0;
  history.clear();
  belief = belief_at(found.estimate, pen, 0, 0);
  // What is known of the rig stays.
  belief.mean.tail<4>() = rig_belief.mean.tail<4>();
  belief.covariance.bottomRightCorner<4, 4>() = rig_belief.covariance.bottomRightCorner<4, 4>();
  belief_time = last_led = last_pair = frame.time;
  noise.jerk = std::max(noise.jerk, options.jerk);
  const LedBlobs& blobs = frame.camera == CameraSide::Left ? found.left : found.right;
  std::vector<LedImage> images;
  append_images(frame.camera, frame.blobs, blobs, images);
  const Belief predicted = belief;
  update(rig, pen, images, noise, belief);
  samples[sample].blobs = blobs;
  last_counts = {count(found.left), count(found.right)};
  last_blobs = {found.left, found.right};
  append(sample, predicted, StateMatrix::Zero());
}

void PenTracker::Implementation::append(std::size_t sample, const Belief& predicted,
                                        const StateMatrix& gain) {
  PenSample& entry = samples[sample];
  entry.current = pose_of(belief);
  set_lost(entry, "found, but not yet confirmed by more frames");
  history.push_back({entry.time, sample, {predicted, belief, gain}, false});
  rig_belief = belief;
}

void PenTracker::Implementation::follow(const BlobFrame& frame, std::size_t sample) {
  const double seconds = frame.time - belief_time;
  const StateMatrix F = transition(seconds);
  const Belief before = belief;
  Belief ahead = predicted(belief, F, seconds, noise.jerk);
  LedBlobs blobs = associate(rig, pen, frame, ahead, noise.blob_floor);
  int leds = count(blobs);
  // A hand that starts or stops leaves the prediction: fewer LEDs than before are found where there are blobs
  // enough. Then the hand is granted more.
  const int wanted =
      std::min(last_counts[static_cast<std::size_t>(frame.camera)], static_cast<int>(frame.blobs.size()));
  for (double factor = 4; factor <= kMostHaste && leds < wanted; factor *= 4) {
    const Belief hasty = predicted(belief, F, seconds, factor * noise.jerk);
    const LedBlobs others = associate(rig, pen, frame, hasty, noise.blob_floor);
    if (count(others) <= leds) continue;
    ahead = hasty;
    blobs = others;
    leds = count(others);
  }
  last_counts[static_cast<std::size_t>(frame.camera)] = leds;
  last_blobs[static_cast<std::size_t>(frame.camera)] = blobs;
  const bool pair = in_both(last_blobs) >= 2;
  belief = ahead;
  belief_time = frame.time;
  std::vector<LedImage> images;
  append_images(frame.camera, frame.blobs, blobs, images);
  const UpdateReport report = update(rig, pen, images, noise, belief);
  if (pair) last_pair = frame.time;
  if (leds > 0) {
    last_led = frame.time;
    adapt(report);
  }
  samples[sample].blobs = blobs;
  append(sample, ahead, smoothing_gain(before, F, ahead));

  const double sigma = std::sqrt(belief.covariance.topLeftCorner<3, 3>().trace());
  const bool too_long = frame.time - last_pair > options.bridge;
  if (!belief.mean.allFinite() || !(sigma < kHopeless * options.largest_sigma) || too_long) {
    lose(concat("the left camera sees ", last_counts[0], " LEDs, the right one ", last_counts[1],
                too_long ? ", for too long" : ": the pose is too uncertain"));
    return;
  }
  if (!confirmed) {
    if (pair)
      ++confirmations;
    else if (++misses > kConfirmations) {
      lose("what looked like the pen was not confirmed by the frames that followed");
      return;
    }
    if (confirmations >= kConfirmations) {
      confirmed = true;
      ++totals.restarts;
    }
  }
  if (confirmed) {
    last_direction = pose_of(belief).direction;
    last_direction_time = frame.time;
    check(frame);
    if (active) answer(frame.time - options.lag);
  }
  if (active && history.size() > kHistory) smooth(frame.time - kOverlap);
}

void PenTracker::Implementation::check(const BlobFrame& frame) {
  ++since_check;
  const int every = last_counts[0] + last_counts[1] < kEnoughLeds ? kCheckFewEvery : kCheckEvery;
  if (since_check < every || std::abs(last_frames[0].time - last_frames[1].time) > kPairing) return;
  since_check = 0;
  ++totals.searches;
  // Without the direction of the track, which may be the wrong one.
  const auto direction = std::exchange(last_direction, std::nullopt);
  const Identification found = identified();
  last_direction = direction;
  if (found.state != IdentificationState::Found) return;
  const int explained = count(found.left) + count(found.right);
  if (explained < kStartingLeds || explained < last_counts[0] + last_counts[1] + kMoreLeds) return;
  lose("another pose explains more of the blobs");
  last_direction.reset();
  start(found, frame, samples.size() - 1);
}

void PenTracker::Implementation::adapt(const UpdateReport& report) {
  const double per_number = report.innovation / report.n_numbers;
  innovation = kMemory * innovation + (1 - kMemory) * std::min(per_number, 10.0);
  residual = kMemory * residual + report.residual;
  expected = kMemory * expected + report.expected_residual;
  // Residuals within a frame, whatever the motion, tell of blobs and rig; then innovations tell of the hand.
  const double misfit = expected > 1 ? residual / expected : 1;
  if (misfit > kRestless)
    noise.blob_floor = std::min(kMostFloor, std::max(noise.blob_floor, 1e-3) * 1.02);
  else if (misfit < 1)
    noise.blob_floor = std::max(options.blob_floor, noise.blob_floor / 1.01);
  if (innovation > kRestless && misfit <= kRestless) noise.jerk = std::min(kMostJerk, noise.jerk * 1.02);
  if (innovation < kQuiet) noise.jerk = std::max(kLeastJerk, noise.jerk / 1.01);
}

void PenTracker::Implementation::answer(double until) {
  std::size_t first = 0;
  while (first < history.size() && history[first].answered) ++first;
  if (first == history.size() || history[first].time > until) return;
  Belief later = history.back().filter.filtered;
  for (std::size_t i = history.size(); i-- > first;) {
    if (i + 1 < history.size()) later = smoothed(history[i].filter, history[i + 1].filter, later);
    if (history[i].time > until) continue;
    Node& node = history[i];
    PenSample& sample = samples[node.sample];
    sample.pose = sample.smoothed = pose_of(later);
    sample.covariance = sample.smoothed_covariance = pose_covariance(later, pen);
    node.answered = true;
    const double sigma = std::sqrt(sample.covariance.topLeftCorner<3, 3>().trace());
    if (!(sigma < options.largest_sigma)) {
      set_lost(sample, "too few LEDs are seen: the pose is too uncertain");
      continue;
    }
    sample.reason.clear();
    const bool seen_now =
        count(sample.blobs) > 0 || (i > 0 && count(samples[history[i - 1].sample].blobs) > 0);
    sample.state = seen_now ? PenState::Tracked : PenState::Bridged;
  }
}

void PenTracker::Implementation::smooth(double keep_from) {
  if (history.empty()) return;
  Belief later = history.back().filter.filtered;
  for (std::size_t i = history.size(); i-- > 0;) {
    if (i + 1 < history.size()) later = smoothed(history[i].filter, history[i + 1].filter, later);
    PenSample& sample = samples[history[i].sample];
    if (sample.state == PenState::Lost) continue;
    sample.smoothed = pose_of(later);
    sample.smoothed_covariance = pose_covariance(later, pen);
  }
  while (history.size() > 1 && history.front().time < keep_from && history.front().answered)
    history.pop_front();
}

void PenTracker::Implementation::lose(const std::string& reason) {
  if (confirmed) {
    answer(last_pair);  // what lies behind was hardly seen
    smooth(0);
  }
  for (const Node& node : history)
    if (!node.answered) set_lost(samples[node.sample], reason);
  history.clear();
  active = confirmed = false;
  why = reason;
}

PenTracker::PenTracker(const StereoRig& rig, const Pen& pen, const TrackOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  if (const std::string found = problem(rig); !found.empty()) throw InvalidInput("rig: " + found);
  if (const std::string found = problem(pen); !found.empty()) throw InvalidInput("pen: " + found);
  if (const auto found = options.problem()) throw InvalidInput(*found);
  Implementation& self = *implementation_;
  self.rig = rig;
  self.pen = pen;
  self.options = options;
  self.noise.jerk = options.jerk;
  self.noise.blob_floor = options.blob_floor;
  self.rig_belief = belief_at({}, pen, options.rotation_sigma, options.focal_sigma);
}

PenTracker::~PenTracker() = default;
PenTracker::PenTracker(PenTracker&&) noexcept = default;
PenTracker& PenTracker::operator=(PenTracker&&) noexcept = default;

void PenTracker::push(const BlobFrame& frame) {
  implementation_->push(frame);
}

void PenTracker::pen_up() {
  Implementation& self = *implementation_;
  if (self.active && self.confirmed) self.smooth(self.belief_time - kOverlap);
}

void PenTracker::finish() {
  Implementation& self = *implementation_;
  if (!self.active) return;
  if (self.confirmed) self.answer(self.belief_time);
  self.lose("the recording ends");
}

const std::vector<PenSample>& PenTracker::samples() const {
  return implementation_->samples;
}

TrackReport PenTracker::report() const {
  const Implementation& self = *implementation_;
  TrackReport report = self.totals;
  report.frames = static_cast<long>(self.samples.size());
  for (const PenSample& sample : self.samples) {
    if (sample.state == PenState::Tracked) ++report.tracked;
    if (sample.state == PenState::Bridged) ++report.bridged;
    if (sample.state != PenState::Lost) continue;
    ++report.lost;
    ++report.lost_because[sample.reason];
  }
  report.rig_turn = self.rig_belief.mean.tail<4>().head<3>();
  const Eigen::Vector4d variances = self.rig_belief.covariance.diagonal().tail<4>();
  report.rig_turn_sigma = variances.head<3>().cwiseSqrt();
  report.rig_focal = self.rig_belief.mean[kStates - 1];
  report.rig_focal_sigma = std::sqrt(variances[3]);
  report.jerk = self.noise.jerk;
  report.blob_floor = self.noise.blob_floor;
  return report;
}

StereoRig PenTracker::rig() const {
  return corrected(implementation_->rig, implementation_->rig_belief.mean);
}

PenTrack track_pen(const BlobRecording& recording, const StereoRig& rig, const Pen& pen,
                   const TrackOptions& options) {
  bool sides[2] = {false, false};
  for (const BlobFrame& frame : recording.frames) sides[frame.camera == CameraSide::Right] = true;
  if (!sides[0] || !sides[1])
    throw InvalidInput(concat("the recording holds no frame of the ", sides[0] ? "right" : "left",
                              " camera; a pen is tracked by two"));
  PenTracker tracker(rig, pen, options);
  std::size_t button = 0;
  for (const BlobFrame& frame : recording.frames) {
    for (; button < recording.buttons.size() && recording.buttons[button].time + options.lag <= frame.time;
         ++button)
      if (recording.buttons[button].button == "draw" && !recording.buttons[button].down) tracker.pen_up();
    tracker.push(frame);
  }
  tracker.finish();
  return {tracker.samples(), tracker.report(), tracker.rig()};
}

}  // namespace batten
