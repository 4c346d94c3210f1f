#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "batten/capture/pen_association_detail.hpp"

namespace batten::detail {

namespace {

constexpr double kGate = 4;          // standard deviations
constexpr double kPerBlob = 16;      // of the score: the gate squared
constexpr double kWidest = 0.01;     // of the image's width: beyond it a prediction is no evidence
constexpr std::size_t kNearest = 3;  // blobs tried for each LED

using Square = Eigen::Matrix<double, 2 * kPenLeds, 2 * kPenLeds>;

struct Option {
  double distance;
  int blob;
  Eigen::Vector2d off;
  Eigen::Matrix2d noise;
};

/// All assignments in turn.
class Assignments {
 public:
  Assignments(const std::array<std::vector<Option>, kPenLeds>& options, const Square& spread)
      : options_(options), spread_(spread) {}

  LedBlobs best() {
    descend(0);
    return best_;
  }

 private:
  void descend(std::size_t led) {
    if (led == kPenLeds) {
      judge();
      return;
    }
    for (const Option& option : options_[led]) {
      const bool taken =
          std::any_of(chosen_.begin(), chosen_.begin() + static_cast<std::ptrdiff_t>(led),
                      [&](const Option* other) { return other && other->blob == option.blob; });
      if (taken) continue;
      chosen_[led] = &option;
      descend(led + 1);
    }
    chosen_[led] = nullptr;
    descend(led + 1);
  }

  void judge() {
    Eigen::Index n = 0;
    std::array<Eigen::Index, kPenLeds> leds{};
    for (std::size_t i = 0; i < kPenLeds; ++i)
      if (chosen_[i]) leds[static_cast<std::size_t>(n++)] = static_cast<Eigen::Index>(i);
    const double most = kPerBlob * static_cast<double>(n);
    if (most <= score_) return;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kPenLeds, 2 * kPenLeds> S(2 * n, 2 * n);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * kPenLeds, 1> off(2 * n);
    for (Eigen::Index a = 0; a < n; ++a) {
      const Eigen::Index i = leds[static_cast<std::size_t>(a)];
      const Option& option = *chosen_[static_cast<std::size_t>(i)];
      for (Eigen::Index b = 0; b < n; ++b)
        S.block<2, 2>(2 * a, 2 * b) = spread_.block<2, 2>(2 * i, 2 * leds[static_cast<std::size_t>(b)]);
      S.block<2, 2>(2 * a, 2 * a) += option.noise;
      off.segment<2>(2 * a) = option.off;
    }
    const double score = most - off.dot(S.llt().solve(off));
    if (!(score > score_)) return;
    score_ = score;
    for (std::size_t i = 0; i < kPenLeds; ++i) best_[i] = chosen_[i] ? chosen_[i]->blob : -1;
  }

  const std::array<std::vector<Option>, kPenLeds>& options_;
  const Square& spread_;
  std::array<const Option*, kPenLeds> chosen_{};
  LedBlobs best_ = {-1, -1, -1, -1};
  double score_ = 0;
};

}  // namespace

LedBlobs associate(const StereoRig& rig, const Pen& pen, const BlobFrame& frame, const Belief& predicted,
                   double blob_floor) {
  std::array<std::vector<Option>, kPenLeds> options;
  Eigen::Matrix<double, 2 * kPenLeds, kStates> jacobian =
      Eigen::Matrix<double, 2 * kPenLeds, kStates>::Zero();
  std::array<Eigen::Vector2d, kPenLeds> pixels;
  std::array<bool, kPenLeds> in_front{};
  for (int led = 0; led < kPenLeds; ++led) {
    const auto image = predict_led(rig, frame.camera, pen, predicted.mean, led);
    if (!image) continue;
    const auto i = static_cast<std::size_t>(led);
    in_front[i] = true;
    pixels[i] = image->pixel;
    jacobian.middleRows<2>(2 * led) = image->jacobian;
  }
  const Square spread = jacobian * predicted.covariance * jacobian.transpose();
  const double widest = kWidest * (frame.camera == CameraSide::Left ? rig.left : rig.right).width;
  for (std::size_t i = 0; i < kPenLeds; ++i) {
    if (!in_front[i]) continue;
    const auto row = static_cast<Eigen::Index>(2 * i);
    if (spread.block<2, 2>(row, row).trace() > 2 * widest * widest) continue;
    for (std::size_t b = 0; b < frame.blobs.size(); ++b) {
      const Eigen::Vector2d off = frame.blobs[b].pixel - pixels[i];
      const Eigen::Matrix2d noise =
          frame.blobs[b].covariance + blob_floor * blob_floor * Eigen::Matrix2d::Identity();
      const Eigen::Matrix2d S = spread.block<2, 2>(row, row) + noise;
      const double distance = off.dot(S.inverse() * off);
      if (distance < kGate * kGate) options[i].push_back({distance, static_cast<int>(b), off, noise});
    }
    std::stable_sort(options[i].begin(), options[i].end(),
                     [](const Option& a, const Option& b) { return a.distance < b.distance; });
    if (options[i].size() > kNearest) options[i].resize(kNearest);
  }
  return Assignments(options, spread).best();
}

}  // namespace batten::detail
