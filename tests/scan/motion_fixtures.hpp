#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/orientation.hpp"

namespace batten::fixtures {

/// A device that is waved: what it does and what is wrong with it.
struct WavedDevice {
  double rate = 200;                ///< readings per second
  double duration = 40;             ///< seconds, the first three of them at rest
  double turning = 1;               ///< rms angular rate per axis, rad/s
  double acceleration = 1;          ///< rms per axis, m/s²
  double noise = 1;                 ///< factor on 0.003 rad/s, 0.03 m/s² and 0.4 µT per reading
  Eigen::Vector3d bias{0, 0, 0};    ///< of the gyroscope, rad/s
  Eigen::Vector3d magnet{0, 0, 0};  ///< field of a magnet that goes with the device, µT
  /// Field of a magnet that stands near, in the world, between two times.
  Eigen::Vector3d intruder{0, 0, 0};
  double intrudes_from = 0, intrudes_to = 0;
};

/// What it recorded, and how it was really held (device → world: north, west, up).
struct WavedRecording {
  SensorLog log;
  std::vector<Eigen::Matrix3d> truth;
};

/// Turns and places are sums of five sines per axis of 0.3 to 1.5 Hz, which start smoothly after a rest.
inline WavedRecording waved(const WavedDevice& device, std::uint64_t seed) {
  using Eigen::Matrix3d;
  using Eigen::Vector3d;
  constexpr int kSines = 5;
  struct Sine {
    Vector3d amplitude, frequency, phase;
  };
  Random random(seed);
  const auto draw = [&](double low, double high) {
    const double x = random.uniform(low, high), y = random.uniform(low, high), z = random.uniform(low, high);
    return Vector3d(x, y, z);
  };
  std::vector<Sine> turns, places;
  const double share = std::sqrt(2.0 / kSines);
  for (int k = 0; k < kSines; ++k) {
    turns.push_back({share * device.turning * draw(0.6, 1.4), 2 * kPi * draw(0.3, 1.5), draw(0, 2 * kPi)});
    Sine place{share * device.acceleration * draw(0.6, 1.4), 2 * kPi * draw(0.3, 1.5), draw(0, 2 * kPi)};
    place.amplitude.array() /= place.frequency.array().square();
    places.push_back(place);
  }
  const auto sum = [](const std::vector<Sine>& sines, double t) {
    const double u = std::clamp((t - 3) / 2, 0.0, 1.0);
    Vector3d value = Vector3d::Zero();
    for (const Sine& s : sines)
      value += s.amplitude.cwiseProduct((s.frequency * t + s.phase).array().sin().matrix());
    return Vector3d(u * u * u * (10 - 15 * u + 6 * u * u) * value);
  };
  WavedRecording recording;
  const auto n = static_cast<Eigen::Index>(device.rate * device.duration);
  recording.log.resize(n);
  const double dt = 1 / device.rate, h = 1e-3;
  Matrix3d X = so3_exp(random.normal3());
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * dt;
    // Four steps of the midpoint rule between readings: below 1e-3 degrees in a minute.
    for (int k = 0; i > 0 && k < 4; ++k) X *= so3_exp(sum(turns, t - dt + (k + 0.5) * dt / 4) * dt / 4);
    const Vector3d pull = (sum(places, t + h) - 2 * sum(places, t) + sum(places, t - h)) / (h * h);
    Vector3d field(20, 0, -44);
    if (t >= device.intrudes_from && t < device.intrudes_to) field += device.intruder;
    SensorLog& log = recording.log;
    log.time[i] = t;
    log.gyroscope.row(i) = sum(turns, t) + device.bias + 0.003 * device.noise * random.normal3();
    log.accelerometer.row(i) =
        X.transpose() * (pull + Vector3d(0, 0, 9.81)) + 0.03 * device.noise * random.normal3();
    log.magnetometer.row(i) = X.transpose() * field + device.magnet + 0.4 * device.noise * random.normal3();
    recording.truth.push_back(X);
  }
  return recording;
}

/// Root mean square errors in degrees over the rows from five seconds on, when the device is in motion.
struct OrientationErrors {
  double total = 0, tilt = 0;
};
inline OrientationErrors errors_of(const OrientationEstimate& estimate,
                                   const std::vector<Eigen::Matrix3d>& truth, const SensorLog& log) {
  double total = 0, tilt = 0, n = 0;
  for (Eigen::Index i = 0; i < estimate.quaternions.rows(); ++i) {
    if (log.time[i] < 5) continue;
    const auto q = estimate.quaternions.row(i);
    const Eigen::Matrix3d X = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const double angle = so3_log(truth[static_cast<size_t>(i)].transpose() * X).norm();
    const double cosine = X.row(2).dot(truth[static_cast<size_t>(i)].row(2));
    total += angle * angle;
    tilt += std::pow(std::acos(std::min(1.0, cosine)), 2);
    n += 1;
  }
  return {degrees(std::sqrt(total / n)), degrees(std::sqrt(tilt / n))};
}

}  // namespace batten::fixtures
