#include "batten/simulation/simulate_device.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Streams of random numbers, apart from those of simulate_scan().
enum DeviceStream : std::uint64_t { kDistortion = 101, kLogNoise, kTumbleNoise, kKnocks };

// The hand moves a fiftieth of the object per second, and rests this long between the readings of a dwell.
constexpr double kSpeed = 0.02;
constexpr double kRestInterval = 0.1;
constexpr double kPauseBetweenCurves = 2.0;

constexpr double kTumbleRate = 25;
constexpr double kTumbleRest = 2;
constexpr double kTumbleTurning = 60;

Matrix3d random_symmetric(Random& random, double scale_spread, double skew) {
  Matrix3d m = Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    m(i, i) += scale_spread * random.uniform(-1, 1);
    for (int j = 0; j < i; ++j) m(i, j) = m(j, i) = skew * random.uniform(-1, 1);
  }
  return m;
}

/// Fills the sensor columns of one row.
void sense(SensorLog& log, Eigen::Index row, const DeviceModel& device, const Matrix3d& X,
           const Vector3d& rate, Random& random) {
  const Matrix3d to_device = device.axes.matrix() * X.transpose();  // world to device
  const Vector3d up(0, 0, device.gravity);
  const Vector3d field =
      device.field_strength * Vector3d(std::cos(device.inclination), 0, -std::sin(device.inclination));
  const Vector3d acceleration = device.accelerometer_distortion * (to_device * up) +
                                device.accelerometer_offset + device.accelerometer_noise * random.normal3();
  const Vector3d magnetic = device.magnetometer_distortion * (to_device * field) +
                            device.magnetometer_offset + device.magnetometer_noise * random.normal3();
  log.accelerometer.row(row) = acceleration;
  log.magnetometer.row(row) = magnetic;
  log.gyroscope.row(row) =
      device.axes.matrix() * rate + device.gyroscope_bias + device.gyroscope_noise * random.normal3();
}

/// A motion from 0 to 1 that starts and stops at rest: x(τ) = τ − sin(2πτ)/2π. Its inverse, by bisection and
/// Newton's method.
double time_of(double x) {
  double low = 0;
  double high = 1;
  double t = x;
  for (int iteration = 0; iteration < 80; ++iteration) {
    const double error = t - std::sin(2 * kPi * t) / (2 * kPi) - x;
    (error > 0 ? high : low) = t;
    const double slope = 1 - std::cos(2 * kPi * t);
    double next = slope > 1e-9 ? t - error / slope : (low + high) / 2;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (std::abs(next - t) < 1e-15) break;
    t = next;
  }
  return t;
}

/// X⁻¹ dX/ds: how the true frame turns per length, in the axes of the frame.
Vector3d turn_per_length(const ArcLengthCurve& path, double s, bool closed) {
  const double length = path.length();
  const double e = 1e-4 * length;
  const auto frame = [&](double at) {
    const CurvePoint p = path.at(closed ? at - length * std::floor(at / length) : at);
    return darboux_frame(p.tangent, p.normal);
  };
  const double low = closed ? s - e : std::max(0.0, s - e);
  const double high = closed ? s + e : std::min(length, s + e);
  return so3_log(frame(low).transpose() * frame(high)) / (high - low);
}

}  // namespace

DeviceModel make_device(std::uint64_t seed, double noise) {
  if (!(noise >= 0)) throw InvalidInput("the noise of a device must be at least 0");
  Random random(seed, kDistortion);
  DeviceModel device;
  device.accelerometer_distortion = random_symmetric(random, 0.03, 0.01);
  device.accelerometer_offset = 0.3 * random.normal3();
  device.magnetometer_distortion = random_symmetric(random, 0.1, 0.05);
  device.magnetometer_offset = 25 * random.direction();
  device.gyroscope_bias = 0.01 * random.normal3();
  device.accelerometer_noise = 0.02 * noise;
  device.magnetometer_noise = 0.3 * noise;
  device.gyroscope_noise = 0.002 * noise;
  device.knocks = noise > 0 ? 0.01 : 0;
  return device;
}

SensorLog simulate_log(const TracedNetwork& traced, const SimulatedScan& simulated, const DeviceModel& device,
                       std::uint64_t seed) {
  if (traced.curves.size() != simulated.scan.curves.size())
    throw InvalidInput("the simulated scan belongs to another object");
  Random random(seed, kLogNoise);
  SensorLog log;
  log.axes = device.axes;
  Eigen::Index n = 0;
  for (const ScanCurve& curve : simulated.scan.curves) n += curve.n_readings();
  log.resize(n);
  Eigen::Index row = 0;
  double clock = 0;
  for (size_t c = 0; c < traced.curves.size(); ++c) {
    const ScanCurve& curve = simulated.scan.curves[c];
    const TracedCurve& source = traced.curves[c];
    const Eigen::VectorXd& where = simulated.true_distances[c];
    LogCurve flags;
    flags.number = static_cast<int>(c) + 1;
    flags.boundary = curve.boundary;
    flags.closed = curve.closed;
    flags.name = curve.name;
    log.curves.push_back(flags);
    // The stops: ends and nodes. Between two of them the device starts and stops smoothly.
    std::vector<double> stops = {0};
    for (const double s : source.node_distances)
      if (s > stops.back()) stops.push_back(s);
    if (source.path->length() > stops.back()) stops.push_back(source.path->length());
    size_t leg = 0;
    double leg_start = clock;
    size_t next_node = 0;
    int node = SensorLog::kNone;
    for (Eigen::Index i = 0; i < curve.n_readings(); ++i, ++row) {
      const double s = where[i];
      while (leg + 2 < stops.size() && s > stops[leg + 1]) {
        ++leg;
        leg_start = clock;
      }
      const double gap = stops[leg + 1] - stops[leg];
      const double duration = gap / (kSpeed * traced.diameter);
      const double x = std::clamp((s - stops[leg]) / gap, 0.0, 1.0);
      const double tau = time_of(x);
      const bool resting = i > 0 && s == where[i - 1];
      clock = resting ? clock + kRestInterval : leg_start + duration * tau;
      if (resting && x == 0) leg_start = clock;  // the first leg starts after the dwell
      const double speed = gap / duration * (1 - std::cos(2 * kPi * tau));
      const Vector3d rate = speed * turn_per_length(*source.path, s, source.closed);
      if (next_node < curve.node_readings.size() && i == curve.node_readings[next_node])
        node = curve.node_ids[next_node++];
      else if (!resting)
        node = SensorLog::kNone;
      log.time[row] = clock;
      log.curve[static_cast<size_t>(row)] = static_cast<int>(c);
      log.node[static_cast<size_t>(row)] = node;
      log.distance[row] = curve.distances[i];
      Matrix3d X;
      const Vector3d t = curve.tangents.row(i);
      const Vector3d normal = curve.normals.row(i);
      X << t, normal, t.cross(normal);
      sense(log, row, device, X, rate, random);
    }
    clock += kPauseBetweenCurves;
  }
  return log;
}

SensorLog simulate_tumble(const DeviceModel& device, std::uint64_t seed) {
  Random random(seed, kTumbleNoise);
  Random knocks(seed, kKnocks);
  SensorLog log;
  log.axes = device.axes;
  const double end = 2 * kTumbleRest + kTumbleTurning;
  const auto n = static_cast<Eigen::Index>(std::lround(end * kTumbleRate));
  log.resize(n);
  // The vertical walks down the device in a spiral, pole to pole, while the heading turns several times, so
  // that gravity and field both come from everywhere.
  const auto orientation = [](double time) {
    const double x = std::clamp((time - kTumbleRest) / kTumbleTurning, 0.0, 1.0);
    const double tau = x - std::sin(2 * kPi * x) / (2 * kPi);
    return Matrix3d(so3_exp({0, 0, 2 * kPi * 7 * tau}) * so3_exp({0, kPi * tau, 0}) *
                    so3_exp({0, 0, 2 * kPi * 11 * tau}));
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const double time = static_cast<double>(i) / kTumbleRate;
    constexpr double kStep = 1e-4;
    const Vector3d rate =
        so3_log(orientation(time - kStep).transpose() * orientation(time + kStep)) / (2 * kStep);
    log.time[i] = time;
    sense(log, i, device, orientation(time), rate, random);
    const bool knocked = knocks.uniform() < device.knocks;
    const Vector3d push = 3 * knocks.normal3();
    if (knocked) log.accelerometer.row(i) += push.transpose();
  }
  return log;
}

}  // namespace batten
