#include "batten/scan/orientation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/orientation_filter.hpp"
#include "batten/scan/orientation_smoother_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
/// A device that turns faster than this, rad/s, or whose force differs more from gravity, m/s², moves.
constexpr double kMovingRate = 0.05, kMovingForce = 0.3;

bool measured(const Points& readings) {
  return !readings.array().isNaN().all();
}

void check_recording(const SensorLog& log, const OrientationOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const Index n = log.n_readings();
  if (log.accelerometer.rows() != n || log.magnetometer.rows() != n || log.gyroscope.rows() != n)
    throw InvalidInput("the columns of the sensor log differ in length");
  if (!measured(log.gyroscope))
    throw InvalidInput(
        "the sensor log has no gyroscope readings; a scan without them is read by `batten network`, which "
        "takes each orientation from accelerometer and magnetometer alone");
  if (!measured(log.accelerometer))
    throw InvalidInput(
        "the sensor log has no accelerometer readings; without them nothing tells up from down");
  for (Index i = 0; i + 1 < n; ++i)
    if (!(log.time[i + 1] >= log.time[i]))
      throw InvalidInput(concat("the time falls from ", log.time[i], " to ", log.time[i + 1], " at reading ",
                                i + 2, "; sort the rows by time"));
  if (n < 2 || !(log.time[n - 1] > log.time[0]))
    throw InvalidInput("the sensor log has one time only; orientations over time need two readings at least");
}

/// How long a sensor may be silent so that what lies between counts as known: sensors of one device are often
/// read at rates of their own.
double longest_silence(const Eigen::VectorXd& time, const Points& readings) {
  std::vector<double> intervals;
  double last = kMissing;
  for (Index i = 0; i < time.size(); ++i) {
    if (!readings.row(i).allFinite()) continue;
    if (time[i] > last) intervals.push_back(time[i] - last);
    last = time[i];
  }
  if (intervals.empty()) return kLongestGap;
  return std::max(kLongestGap, kLongestGapIntervals * upper_median(intervals));
}

Points calibrated(const Points& raw, const SensorCalibration& calibration) {
  Points values(raw.rows(), 3);
  for (Index i = 0; i < raw.rows(); ++i)
    values.row(i) = calibration.apply(raw.row(i).transpose()).transpose();
  return values;
}

InertialRecording recording_of(const SensorLog& log, const OrientationOptions& options) {
  InertialRecording recording;
  recording.time = log.time;
  recording.longest_gap = longest_silence(log.time, log.gyroscope);
  const Points rates = log.gyroscope.rowwise() - options.calibration.gyroscope_bias.transpose();
  recording.rate = filled_stream(rates, log.time, recording.longest_gap);
  recording.force = filled_stream(calibrated(log.accelerometer, options.calibration.accelerometer), log.time,
                                  longest_silence(log.time, log.accelerometer));
  recording.field = options.magnetometer ? calibrated(log.magnetometer, options.calibration.magnetometer)
                                         : Points::Constant(log.n_readings(), 3, kMissing);
  return recording;
}

double longest_gap(const SensorLog& log) {
  double longest = 0, last = log.time[0];
  for (Index i = 0; i < log.n_readings(); ++i) {
    if (!log.gyroscope.row(i).allFinite()) continue;
    longest = std::max(longest, log.time[i] - last);
    last = log.time[i];
  }
  return std::max(longest, log.time[log.n_readings() - 1] - last);
}

/// Share of the time in which the device moves.
double moving_share(const InertialRecording& recording, const Vector3d& bias) {
  double moving = 0, all = 0;
  for (Index i = 0; i + 1 < recording.time.size(); ++i) {
    const auto row = static_cast<size_t>(i);
    if (recording.rate.known[row] == 0 || recording.force.known[row] == 0) continue;
    const double dt = recording.time[i + 1] - recording.time[i];
    const double rate = (recording.rate.values.row(i).transpose() - bias).norm();
    const double force = std::abs(recording.force.values.row(i).norm() - kUsualGravity);
    all += dt;
    if (rate > kMovingRate || force > kMovingForce) moving += dt;
  }
  return all > 0 ? moving / all : 0;
}

void set_row(OrientationEstimate& estimate, Index row, const Eigen::Quaterniond& orientation) {
  const Eigen::Quaterniond q = orientation.normalized();
  const double sign = q.w() < 0 ? -1 : 1;
  estimate.quaternions.row(row) << sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z();
}

void resize(OrientationEstimate& estimate, Index n) {
  estimate.quaternions.setConstant(n, 4, kMissing);
  estimate.tilt_deviation.setConstant(n, kMissing);
  estimate.heading_deviation.setConstant(n, kMissing);
}

InertialReading reading_of(const SensorLog& log, Index i) {
  return {log.time[i], log.accelerometer.row(i), log.gyroscope.row(i), log.magnetometer.row(i)};
}

/// Between two knots: the turns of the gyroscope, and of what they miss in the end a share.
void fill_rows(const InertialRecording& recording, const OrientationSmoother& smoother,
               OrientationEstimate& estimate) {
  const auto& knots = smoother.knots();
  const auto deviations = [&](size_t k) {
    const Matrix3d world = knots[k].X * smoother.covariances()[k] * knots[k].X.transpose();
    return Eigen::Vector2d(std::sqrt(0.5 * (world(0, 0) + world(1, 1))), std::sqrt(world(2, 2)));
  };
  for (size_t k = 0; k < knots.size(); ++k) {
    const Eigen::Vector2d here = deviations(k);
    const bool last = k + 1 == knots.size();
    const Eigen::Vector2d next = last ? here : deviations(k + 1);
    const Vector3d missed = last ? Vector3d::Zero() : smoother.turn_misfit(static_cast<int>(k));
    const Index end = last ? recording.time.size() : knots[k + 1].row;
    const double T = last ? 1 : smoother.motions()[k].time;
    Motion motion;
    for (Index i = knots[k].row; i < end; ++i) {
      const double s = (recording.time[i] - recording.time[knots[k].row]) / T;
      set_row(estimate, i, Eigen::Quaterniond(Matrix3d(knots[k].X * motion.R * so3_exp(s * missed))));
      estimate.tilt_deviation[i] = (1 - s) * here[0] + s * next[0];
      estimate.heading_deviation[i] = (1 - s) * here[1] + s * next[1];
      if (i + 1 < end) recording.append(i, smoother.errors(), motion);
    }
  }
}

void fill_figures(const OrientationSmoother& smoother, OrientationEstimate& estimate) {
  const auto& knots = smoother.knots();
  double turn = 0, velocity = 0, speed = 0, heading = 0, weight = 0, fields = 0, rejected = 0;
  int n_turns = 0;
  for (int k = 0; k < static_cast<int>(knots.size()); ++k) {
    speed += knots[k].v.squaredNorm();
    if (knots[k].has_field) {
      fields += 1;
      if (knots[k].weight < 0.5) rejected += 1;
      const double z = knots[k].heading / smoother.heading_deviation();
      heading += knots[k].weight * z * z;
      weight += knots[k].weight;
    }
    if (k + 1 == static_cast<int>(knots.size()) || !smoother.motions()[k].turn_known) continue;
    turn += smoother.turn_residual(k).squaredNorm();
    velocity += smoother.velocity_residual(k).squaredNorm();
    ++n_turns;
  }
  const double axes = 3.0 * std::max(n_turns, 1);
  estimate.rms_turn = std::sqrt(turn / axes);
  estimate.rms_velocity = std::sqrt(velocity / axes);
  estimate.rms_speed = std::sqrt(speed / static_cast<double>(knots.size()));
  estimate.rms_heading = weight > 0 ? std::sqrt(heading / weight) : 0;
  estimate.magnetometer_rejected = fields > 0 ? rejected / fields : 0;
  estimate.gyroscope_bias = smoother.errors().gyroscope_bias;
  estimate.gyroscope_bias_deviation = smoother.bias_deviation();
  estimate.accelerometer_bias = smoother.errors().accelerometer_bias;
  estimate.gyroscope_matrix = smoother.errors().gyroscope_matrix;
  estimate.magnetometer_used = smoother.has_field();
  estimate.magnetometer_offset = smoother.field_offset();
  if (smoother.has_field()) {
    estimate.field_strength = smoother.reference().strength;
    estimate.inclination = smoother.reference().dip;
    estimate.magnetometer_deviation = smoother.heading_deviation();
  }
  estimate.iterations = smoother.iterations();
  estimate.converged = smoother.converged();
}

void add_warnings(const InertialRecording& recording, OrientationEstimate& estimate) {
  constexpr double kMuchRejected = 0.5;
  if (!estimate.magnetometer_used) {
    estimate.warnings.emplace_back(
        "no magnetometer: the heading starts at 0 and drifts with what is left of the gyroscope's bias");
  } else if (estimate.magnetometer_rejected > kMuchRejected) {
    estimate.warnings.push_back(concat(
        "the magnetic field disagrees with itself on ", std::lround(100 * estimate.magnetometer_rejected),
        " % of the recording: the heading rests on the gyroscope there, and north may be wrong; keep "
        "iron away or leave the magnetometer out"));
  }
  if (estimate.longest_gap > recording.longest_gap)
    estimate.warnings.push_back(concat("the gyroscope is silent for up to ", estimate.longest_gap,
                                       " seconds: across such gaps orientations are guesses"));
}

}  // namespace

std::optional<std::string> OrientationOptions::problem() const {
  std::optional<std::string> problem;
  const auto positive = [&](const char* name, double value) {
    if (!problem && !(value > 0 && std::isfinite(value)))
      problem = concat(name, " must be more than 0, got ", value);
  };
  if (heading_deviation) positive("heading_deviation", *heading_deviation);
  positive("gyroscope_noise", gyroscope_noise);
  positive("accelerometer_noise", accelerometer_noise);
  positive("bias_deviation", bias_deviation);
  positive("speed", speed);
  positive("reach", reach);
  return problem;
}

OrientationEstimate filter_orientation(const SensorLog& log, const OrientationOptions& options,
                                       const Progress& progress) {
  check_recording(log, options);
  OrientationEstimate estimate;
  const Index n = log.n_readings();
  resize(estimate, n);
  OrientationFilter filter(options);
  for (Index i = 0; i < n; ++i) {
    if (i % 4096 == 0) progress.report("filtering", static_cast<double>(i) / static_cast<double>(n));
    const auto orientation = filter.add(reading_of(log, i));
    if (!orientation) continue;
    set_row(estimate, i, *orientation);
    estimate.tilt_deviation[i] = filter.tilt_deviation();
    estimate.heading_deviation[i] = filter.heading_deviation();
  }
  const InertialRecording recording = recording_of(log, options);
  estimate.gyroscope_bias = filter.gyroscope_bias();
  estimate.gyroscope_bias_deviation = filter.gyroscope_bias_deviation();
  estimate.accelerometer_bias = filter.accelerometer_bias();
  estimate.magnetometer_used = filter.has_heading();
  estimate.field_strength = filter.field_strength();
  estimate.inclination = filter.inclination();
  estimate.magnetometer_rejected = filter.magnetometer_rejected();
  estimate.moving = moving_share(recording, estimate.gyroscope_bias);
  estimate.longest_gap = longest_gap(log);
  estimate.converged = true;
  add_warnings(recording, estimate);
  return estimate;
}

OrientationEstimate estimate_orientation(const SensorLog& log, const OrientationOptions& options,
                                         const Progress& progress) {
  check_recording(log, options);
  const Index n = log.n_readings();
  std::vector<Matrix3d> start(static_cast<size_t>(n), Matrix3d::Identity());
  OrientationFilter filter(options);
  Index first = n;
  for (Index i = 0; i < n; ++i) {
    if (i % 4096 == 0) progress.report("filtering", static_cast<double>(i) / static_cast<double>(n));
    const auto orientation = filter.add(reading_of(log, i));
    if (!orientation) continue;
    first = std::min(first, i);
    start[static_cast<size_t>(i)] = orientation->toRotationMatrix();
  }
  for (Index i = 0; i < std::min(first, n - 1); ++i)
    start[static_cast<size_t>(i)] = start[static_cast<size_t>(std::min(first, n - 1))];
  const InertialRecording recording = recording_of(log, options);
  OrientationSmoother smoother(recording, options, start);
  smoother.solve(progress);
  OrientationEstimate estimate;
  resize(estimate, n);
  fill_rows(recording, smoother, estimate);
  fill_figures(smoother, estimate);
  estimate.moving = moving_share(recording, estimate.gyroscope_bias);
  estimate.longest_gap = longest_gap(log);
  add_warnings(recording, estimate);
  progress.report("smoothing", 1);
  return estimate;
}

}  // namespace batten
