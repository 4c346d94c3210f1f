#include "batten/capture/pen_identification.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/camera/triangulation.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr std::size_t kMostBlobs = 16;
constexpr double kPairGate = 4;         // standard deviations between a blob and its reprojection
constexpr double kDistanceGate = 6;     // of the distance of two LEDs
constexpr double kCountGate = 8;        // of a blob from the image of an LED, before adjustment
constexpr double kAdjustedGate = 5;     // the same after it
constexpr std::size_t kAdjusted = 8;    // poses
constexpr double kPerFoundBlob = 9;     // of the score
constexpr double kMargin = 6;           // of the score, between a pose and another one
constexpr double kElsewhere = 0.02;     // metres: another pose
constexpr double kDirectionGate = 0.5;  // cosine of 60°

struct Candidate {
  std::size_t left, right;
  Eigen::Vector3d point;
  Eigen::Matrix3d covariance;
};

struct Hypothesis {
  PenPose pose;
  LedBlobs left, right;
  int count = 0;
  double cost = 0;
};

int count_of(const LedBlobs& blobs) {
  return static_cast<int>(std::count_if(blobs.begin(), blobs.end(), [](int blob) { return blob >= 0; }));
}

/// Everything a search needs that does not change.
class Search {
 public:
  Search(const StereoRig& rig, const Pen& pen, std::span<const Blob> left, std::span<const Blob> right,
         const IdentificationOptions& options)
      : rig_(rig), pen_(pen), left_(best(left)), right_(best(right)), options_(options) {}

  Identification run() {
    Identification result;
    if (left_.size() < 2 || right_.size() < 2) {
      result.reason = concat("the left camera sees ", left_.size(), " blobs, the right one ", right_.size(),
                             "; a pose takes two in each");
      return result;
    }
    find_candidates();
    find_hypotheses();
    if (hypotheses_.empty()) {
      result.reason = "no two points in space are as far apart as two LEDs of the pen";
      return result;
    }
    adjust();
    if (found_.empty()) {
      result.reason = "no pose of the pen explains two blobs in each camera";
      return result;
    }
    return judged();
  }

 private:
  struct Indexed {
    Blob blob;
    int index;
  };

  static std::vector<Indexed> best(std::span<const Blob> blobs) {
    std::vector<Indexed> result;
    for (std::size_t i = 0; i < blobs.size(); ++i) result.push_back({blobs[i], static_cast<int>(i)});
    if (result.size() > kMostBlobs) {
      std::stable_sort(result.begin(), result.end(), [](const Indexed& a, const Indexed& b) {
        return a.blob.covariance.trace() < b.blob.covariance.trace();
      });
      result.resize(kMostBlobs);
    }
    return result;
  }

  /// By how much a blob at this depth may be off, pixels.
  double spread(double depth) const {
    return std::hypot(options_.rig_error, options_.motion * rig_.left.fx / depth);
  }

  double sigma(const Blob& blob, double depth) const {
    const double s = spread(depth);
    return std::sqrt(blob.covariance.trace() / 2 + s * s);
  }

  void find_candidates() {
    for (std::size_t i = 0; i < left_.size(); ++i)
      for (std::size_t j = 0; j < right_.size(); ++j) {
        const Blob& a = left_[i].blob;
        const Blob& b = right_[j].blob;
        const auto point = triangulate(rig_, a.pixel, b.pixel, Triangulation::Reprojection);
        if (!point) continue;
        const double depth = point->position.z();
        if (depth < options_.nearest || depth > options_.farthest) continue;
        const double s = std::max(sigma(a, depth), sigma(b, depth));
        if (point->reprojection > kPairGate * s) continue;
        candidates_.push_back({i, j, point->position, s * s * point->covariance});
      }
  }

  void find_hypotheses() {
    for (std::size_t a = 0; a < candidates_.size(); ++a)
      for (std::size_t b = a + 1; b < candidates_.size(); ++b) {
        if (candidates_[a].left == candidates_[b].left || candidates_[a].right == candidates_[b].right)
          continue;
        const Eigen::Vector3d between = candidates_[b].point - candidates_[a].point;
        const double distance = between.norm();
        if (!(distance > 0)) continue;
        const Eigen::Vector3d along = between / distance;
        const double deviation =
            std::sqrt(along.dot((candidates_[a].covariance + candidates_[b].covariance) * along));
        for (int i = 0; i < kPenLeds; ++i)
          for (int j = 0; j < kPenLeds; ++j) {
            if (i == j) continue;
            const double wanted = std::abs(pen_.led_distance(i) - pen_.led_distance(j));
            if (std::abs(distance - wanted) > kDistanceGate * deviation) continue;
            add_hypothesis(candidates_[a].point, i, candidates_[b].point, j);
          }
      }
  }

  void add_hypothesis(const Eigen::Vector3d& first, int i, const Eigen::Vector3d& second, int j) {
    const int leds[2] = {i, j};
    const Eigen::Vector3d points[2] = {first, second};
    Hypothesis hypothesis;
    hypothesis.pose = pose_of_points(pen_, leds, points);
    if (options_.direction && hypothesis.pose.direction.dot(*options_.direction) < kDirectionGate) return;
    associate(hypothesis, kCountGate);
    if (count_of(hypothesis.left) < 2 || count_of(hypothesis.right) < 2) return;
    // The same assignment comes from every two of its points.
    for (Hypothesis& other : hypotheses_)
      if (other.left == hypothesis.left && other.right == hypothesis.right) {
        if (hypothesis.cost < other.cost) other = hypothesis;
        return;
      }
    hypotheses_.push_back(hypothesis);
  }

  static std::vector<Blob> plain(const std::vector<Indexed>& blobs) {
    std::vector<Blob> result;
    for (const Indexed& blob : blobs) result.push_back(blob.blob);
    return result;
  }

  void associate(Hypothesis& hypothesis, double gate) const {
    const double s = spread(std::max(hypothesis.pose.tip.z(), options_.nearest));
    hypothesis.left = nearest_blobs(rig_, CameraSide::Left, pen_, hypothesis.pose, left_blobs_, gate, s);
    hypothesis.right = nearest_blobs(rig_, CameraSide::Right, pen_, hypothesis.pose, right_blobs_, gate, s);
    hypothesis.count = count_of(hypothesis.left) + count_of(hypothesis.right);
    hypothesis.cost = pose_misfit(rig_, pen_, hypothesis.pose, images_of(hypothesis));
  }

  /// The images with covariances that allow for what the rig and the motion may be off.
  std::vector<LedImage> images_of(const Hypothesis& hypothesis) const {
    std::vector<LedImage> images;
    append_images(CameraSide::Left, left_blobs_, hypothesis.left, images);
    append_images(CameraSide::Right, right_blobs_, hypothesis.right, images);
    const double s = spread(std::max(hypothesis.pose.tip.z(), options_.nearest));
    for (LedImage& image : images) image.blob.covariance += s * s * Eigen::Matrix2d::Identity();
    return images;
  }

  struct Adjusted {
    Hypothesis hypothesis;
    PoseEstimate estimate;
    double score;
  };

  void adjust() {
    std::stable_sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) {
      return a.count != b.count ? a.count > b.count : a.cost < b.cost;
    });
    if (hypotheses_.size() > kAdjusted) hypotheses_.resize(kAdjusted);
    for (Hypothesis hypothesis : hypotheses_) {
      auto estimate = fit_pose(rig_, pen_, images_of(hypothesis), hypothesis.pose);
      if (!estimate) continue;
      hypothesis.pose = estimate->pose;
      associate(hypothesis, kAdjustedGate);
      if (count_of(hypothesis.left) < 2 || count_of(hypothesis.right) < 2) continue;
      estimate = fit_pose(rig_, pen_, images_of(hypothesis), hypothesis.pose);
      if (!estimate) continue;
      if (options_.direction && estimate->pose.direction.dot(*options_.direction) < kDirectionGate) continue;
      found_.push_back({hypothesis, *estimate, kPerFoundBlob * hypothesis.count - estimate->chi_square});
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Adjusted& a, const Adjusted& b) { return a.score > b.score; });
  }

  Identification judged() const {
    Identification result;
    const Adjusted& best = found_.front();
    result.estimate = best.estimate;
    result.score = best.score;
    for (std::size_t i = 0; i < kPenLeds; ++i) {
      if (best.hypothesis.left[i] >= 0)
        result.left[i] = left_[static_cast<std::size_t>(best.hypothesis.left[i])].index;
      if (best.hypothesis.right[i] >= 0)
        result.right[i] = right_[static_cast<std::size_t>(best.hypothesis.right[i])].index;
    }
    result.state = IdentificationState::Found;
    for (const Adjusted& other : found_)
      if (other.score > best.score - kMargin &&
          (other.estimate.pose.tip - best.estimate.pose.tip).norm() > kElsewhere) {
        result.state = IdentificationState::Ambiguous;
        result.reason = "two different poses of the pen explain the blobs equally well";
      }
    return result;
  }

  const StereoRig& rig_;
  const Pen& pen_;
  const std::vector<Indexed> left_, right_;
  const std::vector<Blob> left_blobs_ = plain(left_), right_blobs_ = plain(right_);
  const IdentificationOptions& options_;
  std::vector<Candidate> candidates_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<Adjusted> found_;
};

}  // namespace

std::optional<std::string> IdentificationOptions::problem() const {
  if (!(nearest > 0)) return concat("nearest is ", nearest, "; expected metres above 0");
  if (!(farthest > nearest))
    return concat("farthest is ", farthest, "; expected more than nearest, ", nearest);
  if (!(motion >= 0)) return concat("motion is ", motion, "; expected metres, at least 0");
  if (!(rig_error >= 0)) return concat("rig_error is ", rig_error, "; expected pixels, at least 0");
  return {};
}

Identification identify(const StereoRig& rig, const Pen& pen, std::span<const Blob> left,
                        std::span<const Blob> right, const IdentificationOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  return Search(rig, pen, left, right, options).run();
}

void append_images(CameraSide camera, std::span<const Blob> blobs, const LedBlobs& assigned,
                   std::vector<LedImage>& images) {
  for (int led = 0; led < kPenLeds; ++led) {
    const int blob = assigned[static_cast<std::size_t>(led)];
    if (blob >= 0) images.push_back({camera, led, blobs[static_cast<std::size_t>(blob)]});
  }
}

LedBlobs nearest_blobs(const StereoRig& rig, CameraSide camera, const Pen& pen, const PenPose& pose,
                       std::span<const Blob> blobs, double gate, double spread) {
  struct Match {
    double distance;
    int led, blob;
  };
  std::vector<Match> matches;
  for (int led = 0; led < kPenLeds; ++led) {
    const auto pixel = image_in(rig, camera, led_position(pen, pose, led));
    if (!pixel) continue;
    for (std::size_t b = 0; b < blobs.size(); ++b) {
      const Eigen::Vector2d off = blobs[b].pixel - *pixel;
      const Eigen::Matrix2d covariance = blobs[b].covariance + spread * spread * Eigen::Matrix2d::Identity();
      const double distance = off.dot(covariance.inverse() * off);
      if (distance < gate * gate) matches.push_back({distance, led, static_cast<int>(b)});
    }
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.distance < b.distance; });
  LedBlobs assigned = {-1, -1, -1, -1};
  std::vector<bool> taken(blobs.size(), false);
  for (const Match& match : matches) {
    const auto led = static_cast<std::size_t>(match.led), blob = static_cast<std::size_t>(match.blob);
    if (assigned[led] >= 0 || taken[blob]) continue;
    assigned[led] = match.blob;
    taken[blob] = true;
  }
  return assigned;
}

}  // namespace batten
