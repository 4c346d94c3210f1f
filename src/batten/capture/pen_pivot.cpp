#include "batten/capture/pen_pivot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/capture/pen_tracker.hpp"
#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

constexpr int kShared = 3 + kPenLeds;  // tip, T, l_2 … l_4
constexpr std::size_t kLeastLeds = 3;  // in a frame
constexpr std::size_t kMostFrames = 4000;
constexpr int kSteps = 20;
constexpr double kConverged = 1e-9;  // metres and radians
constexpr double kAtRest =
    5e-3;  // metres, by which single frames may miss the dimple, far from coarse cameras more:
constexpr double kOffLeds = 1.0;  // pixels, that blobs may then be off

using Shared = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

struct PivotFrame {
  std::vector<LedImage> images;
  Eigen::Vector3d direction;
  double misfit = 0;  // per number
};

struct Normal {
  SharedMatrix information = SharedMatrix::Zero();
  Shared gradient = Shared::Zero();
};

/// What one frame says of the tip, the offsets and its direction.
struct FrameNormal {
  SharedMatrix shared = SharedMatrix::Zero();
  Eigen::Matrix<double, kShared, 2> mixed = Eigen::Matrix<double, kShared, 2>::Zero();
  Eigen::Matrix2d own = Eigen::Matrix2d::Zero();
  Shared shared_gradient = Shared::Zero();
  Eigen::Vector2d own_gradient = Eigen::Vector2d::Zero();
  double misfit = 0;
};

class PivotProblem {
 public:
  PivotProblem(const StereoRig& rig, Pen pen, const Eigen::Vector3d& tip, std::vector<PivotFrame> frames)
      : rig_(rig), pen_(pen), tip_(tip), frames_(std::move(frames)) {}

  void solve() {
    for (int step = 0; step < kSteps; ++step) {
      Normal reduced;
      std::vector<FrameNormal> normals;
      for (const PivotFrame& frame : frames_) {
        normals.push_back(assemble(frame));
        const FrameNormal& n = normals.back();
        const Eigen::Matrix2d inverse = n.own.inverse();
        reduced.information += n.shared - n.mixed * inverse * n.mixed.transpose();
        reduced.gradient += n.shared_gradient - n.mixed * inverse * n.own_gradient;
      }
      const Eigen::LDLT<SharedMatrix> factor(reduced.information);
      if (factor.info() != Eigen::Success || !factor.isPositive())
        throw SolverFailure("pivot calibration", kShared);
      const Shared change = factor.solve(reduced.gradient);
      double largest = change.cwiseAbs().maxCoeff();
      for (std::size_t k = 0; k < frames_.size(); ++k) {
        const FrameNormal& n = normals[k];
        const Eigen::Vector2d turn = n.own.inverse() * (n.own_gradient - n.mixed.transpose() * change);
        Eigen::Vector3d& direction = frames_[k].direction;
        direction = (direction + tangent_basis(direction) * turn).normalized();
        largest = std::max(largest, turn.cwiseAbs().maxCoeff());
      }
      tip_ += change.head<3>();
      pen_.tip_offset += change[3];
      for (std::size_t led = 1; led < kPenLeds; ++led)
        pen_.leds[led] += change[static_cast<Eigen::Index>(led) + 3];
      if (!std::isfinite(largest)) throw SolverFailure("pivot calibration", kShared);
      if (largest < kConverged) break;
    }
    covariance_ = SharedMatrix::Zero();
    for (PivotFrame& frame : frames_) {
      const FrameNormal n = assemble(frame);
      covariance_ += n.shared - n.mixed * n.own.inverse() * n.mixed.transpose();
      frame.misfit = n.misfit / static_cast<double>(2 * frame.images.size());
    }
    covariance_ = covariance_.inverse().eval();
  }

  /// Leaves out frames that fit worse than this many times the median. @return how many.
  int leave_out(double times) {
    std::vector<double> misfits;
    for (const PivotFrame& frame : frames_) misfits.push_back(std::sqrt(frame.misfit));
    const double limit = times * median(misfits);
    const auto last = std::remove_if(frames_.begin(), frames_.end(), [&](const PivotFrame& frame) {
      return std::sqrt(frame.misfit) > limit;
    });
    const auto left_out = static_cast<int>(frames_.end() - last);
    frames_.erase(last, frames_.end());
    return left_out;
  }

  PivotCalibration result() const {
    PivotCalibration calibration;
    calibration.pen = pen_;
    calibration.tip = tip_;
    calibration.frames = static_cast<int>(frames_.size());
    double squares = 0, chi_square = 0, numbers = 0, misses = 0, n_misses = 0;
    for (const PivotFrame& frame : frames_) {
      for (const LedImage& image : frame.images) {
        const auto pixel =
            image_in(rig_, image.camera, led_position(pen_, {tip_, frame.direction}, image.led));
        if (!pixel) continue;
        squares += (image.blob.pixel - *pixel).squaredNorm();
        numbers += 1;
      }
      chi_square += frame.misfit * static_cast<double>(2 * frame.images.size());
      if (const auto alone = fit_pose(rig_, pen_, frame.images, {tip_, frame.direction})) {
        // Across the ray: along it a single camera hardly sees.
        const Eigen::Vector3d ray = tip_.normalized();
        const Eigen::Vector3d miss = alone->pose.tip - tip_;
        misses += (miss - miss.dot(ray) * ray).squaredNorm();
        n_misses += 1;
      }
    }
    const double freedom = 2 * numbers - 2 * static_cast<double>(frames_.size()) - kShared;
    const double scale = std::sqrt(std::max(1.0, chi_square / std::max(1.0, freedom)));
    calibration.rms = std::sqrt(squares / std::max(1.0, numbers));
    calibration.residual = std::sqrt(misses / std::max(1.0, n_misses));
    calibration.tip_sigma = scale * covariance_.diagonal().head<3>().cwiseSqrt();
    calibration.tip_offset_sigma = scale * std::sqrt(covariance_(3, 3));
    for (std::size_t led = 1; led < kPenLeds; ++led) {
      const auto i = static_cast<Eigen::Index>(led) + 3;
      calibration.led_sigma[led] = scale * std::sqrt(covariance_(i, i));
    }
    return calibration;
  }

 private:
  FrameNormal assemble(const PivotFrame& frame) const {
    FrameNormal normal;
    const Eigen::Matrix<double, 3, 2> basis = tangent_basis(frame.direction);
    for (const LedImage& image : frame.images) {
      Eigen::Matrix<double, 2, 3> by_point;
      const double distance = pen_.led_distance(image.led);
      const auto pixel = image_in(rig_, image.camera, tip_ + distance * frame.direction, &by_point);
      if (!pixel) continue;
      Eigen::Matrix<double, 2, kShared> J = Eigen::Matrix<double, 2, kShared>::Zero();
      J.leftCols<3>() = by_point;
      J.col(3) = by_point * frame.direction;
      if (image.led > 0) J.col(3 + image.led) = by_point * frame.direction;
      const Eigen::Matrix2d own = distance * by_point * basis;
      const Eigen::Matrix2d weight = image.blob.covariance.inverse();
      const Eigen::Vector2d off = image.blob.pixel - *pixel;
      normal.shared += J.transpose() * weight * J;
      normal.mixed += J.transpose() * weight * own;
      normal.own += own.transpose() * weight * own;
      normal.shared_gradient += J.transpose() * weight * off;
      normal.own_gradient += own.transpose() * weight * off;
      normal.misfit += off.dot(weight * off);
    }
    return normal;
  }

  const StereoRig& rig_;
  Pen pen_;
  Eigen::Vector3d tip_;
  std::vector<PivotFrame> frames_;
  SharedMatrix covariance_;
};

/// Frames in which three LEDs or more were found, and the greatest angle between their directions.
std::vector<PivotFrame> frames_of(const BlobRecording& recording, const PenTrack& track, double& tilt) {
  std::vector<PivotFrame> frames;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const PenSample& sample = track.samples[i];
    if (sample.state == PenState::Lost) continue;
    PivotFrame frame;
    append_images(sample.camera, recording.frames[i].blobs, sample.blobs, frame.images);
    frame.direction = sample.smoothed.direction;
    if (frame.images.size() < kLeastLeds) continue;
    mean += frame.direction;
    frames.push_back(std::move(frame));
  }
  // The direction farthest from the mean, and the one farthest from that: exact to a factor that does not
  // matter here, and linear in the frames.
  const auto farthest = [&](const Eigen::Vector3d& from) {
    Eigen::Vector3d far = from;
    double least = 1;
    for (const PivotFrame& frame : frames)
      if (frame.direction.dot(from) < least) {
        least = frame.direction.dot(from);
        far = frame.direction;
      }
    return far;
  };
  if (!frames.empty()) {
    const Eigen::Vector3d one = farthest(mean.normalized()), other = farthest(one);
    tilt = std::acos(std::clamp(one.dot(other), -1.0, 1.0));
  }
  const std::size_t every = frames.size() / kMostFrames + 1;
  std::vector<PivotFrame> thinned;
  for (std::size_t i = 0; i < frames.size(); i += every) thinned.push_back(std::move(frames[i]));
  return thinned;
}

/// Tip and T of least squares from where the first LED is: q_k = p + T d_k.
void start_from(const PenTrack& track, Pen& pen, Eigen::Vector3d& tip) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const PenSample& sample : track.samples) {
    if (sample.state == PenState::Lost) continue;
    Eigen::Matrix<double, 3, 4> row;
    row << Eigen::Matrix3d::Identity(), sample.smoothed.direction;
    A += row.transpose() * row;
    b += row.transpose() * led_position(pen, sample.smoothed, 0);
  }
  const Eigen::Vector4d solution = A.ldlt().solve(b);
  tip = solution.head<3>();
  pen.tip_offset = solution[3];
}

}  // namespace

std::optional<std::string> PivotOptions::problem() const {
  if (least_frames < 10) return concat("least_frames is ", least_frames, "; expected at least 10");
  if (!(least_tilt >= 0.05 && least_tilt <= 3))
    return concat("least_tilt is ", least_tilt, "; expected 0.05 to 3 rad");
  if (!(outliers >= 2)) return concat("outliers is ", outliers, "; expected at least 2");
  return {};
}

PivotCalibration calibrate_pivot(const BlobRecording& recording, const StereoRig& rig, const Pen& nominal,
                                 const PivotOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  TrackOptions tracking;
  tracking.blob_floor = 0.1;  // LEDs may be some tenths of a millimetre off
  const PenTrack track = track_pen(recording, rig, nominal, tracking);
  double tilt = 0;
  std::vector<PivotFrame> frames = frames_of(recording, track, tilt);
  if (static_cast<int>(frames.size()) < options.least_frames)
    throw InvalidInput(concat("only ", frames.size(), " frames show three LEDs of the pen, ",
                              options.least_frames,
                              " are needed; keep the pen in view of both cameras for some seconds"));
  if (tilt < options.least_tilt)
    throw InvalidInput(concat("the pen was turned by ", degrees(tilt),
                              " degrees only; keep its tip in a dimple and "
                              "tilt it by 40 degrees to all sides"));
  Pen pen = nominal;
  Eigen::Vector3d tip;
  start_from(track, pen, tip);
  if (!(pen.tip_offset > -0.02 && pen.tip_offset < 1))
    throw InvalidInput("the pen does not turn about a point below its LEDs; keep its tip in a dimple");
  PivotProblem problem(rig, pen, tip, std::move(frames));
  problem.solve();
  const int left_out = problem.leave_out(options.outliers);
  problem.solve();
  PivotCalibration result = problem.result();
  result.tilt = tilt;
  result.left_out = left_out;
  if (const std::string found = batten::problem(result.pen); !found.empty())
    throw InvalidInput("the calibrated pen is none: " + found + "; was its tip at rest?");
  if (result.residual > kAtRest && result.rms > kOffLeds)
    throw InvalidInput(concat("single frames miss the dimple by ", 1e3 * result.residual,
                              " mm; keep the tip of the pen at rest"));
  return result;
}

}  // namespace batten
