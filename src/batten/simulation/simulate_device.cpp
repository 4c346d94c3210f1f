#include "batten/simulation/simulate_device.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Streams of random numbers, apart from those of simulate_scan().
enum DeviceStream : std::uint64_t {
  kDistortion = 101,
  kLogNoise,
  kTumbleNoise,
  kKnocks,
  kGyroscope,
  kGyroscopeNoise,
  kGyroscopeWalk
};

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
  log.gyroscope.row(row) = device.gyroscope_distortion * (device.axes.matrix() * rate) +
                           device.gyroscope_bias + device.gyroscope_noise * random.normal3();
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

/// How the device comes to a reading from the one before.
struct Approach {
  bool resting = false;
  double start = 0, duration = 0;  ///< of its leg, seconds
  double from = 0, gap = 0;        ///< where the leg starts, and its length
};

/// The log of a device whose gyroscope is read more often than its other sensors.
class GyroscopeRows {
 public:
  GyroscopeRows(const TracedNetwork& traced, const SimulatedScan& simulated, const DeviceModel& device,
                std::uint64_t seed)
      : traced_(traced),
        simulated_(simulated),
        device_(device),
        noise_(seed, kGyroscopeNoise),
        walk_(seed, kGyroscopeWalk) {}

  /// @param readings the log of the other sensors, curve after curve. @param approaches per row of it.
  SensorLog between(const SensorLog& readings, const std::vector<Approach>& approaches) {
    out_.axes = readings.axes;
    out_.curves = readings.curves;
    Eigen::Index within = 0;  // of the curve
    for (Eigen::Index i = 0; i < readings.n_readings(); ++i) {
      const auto row = static_cast<size_t>(i);
      const int c = readings.curve[row];
      within = i > 0 && c == readings.curve[row - 1] ? within + 1 : 0;
      if (i > 0) add_rows(readings, i, approaches[row], within == 0);
      const Eigen::Index own = add(readings.time[i], c, readings.node[row], readings.distance[i]);
      out_.accelerometer.row(own) = readings.accelerometer.row(i);
      out_.magnetometer.row(own) = readings.magnetometer.row(i);
      out_.gyroscope.row(own) = readings.gyroscope.row(i) + wandering(readings.time[i]).transpose();
    }
    out_.resize(n_);
    return std::move(out_);
  }

 private:
  Eigen::Index add(double time, int curve, int node, double distance) {
    if (n_ == out_.n_readings()) out_.resize(std::max<Eigen::Index>(1024, 2 * n_));
    out_.time[n_] = time;
    out_.curve[static_cast<size_t>(n_)] = curve;
    out_.node[static_cast<size_t>(n_)] = node;
    out_.distance[n_] = distance;
    return n_++;
  }

  /// What the bias has become at a time; times must not fall.
  Vector3d wandering(double time) {
    const double dt = std::max(0.0, time - time_);
    time_ = time;
    if (device_.gyroscope_walk > 0) walked_ += device_.gyroscope_walk * std::sqrt(dt) * walk_.normal3();
    return walked_ - device_.gyroscope_warming * std::expm1(-time / device_.warming_time);
  }

  void add_rows(const SensorLog& readings, Eigen::Index i, const Approach& approach, bool carried) {
    const double begin = readings.time[i - 1], end = readings.time[i];
    const auto c = static_cast<size_t>(readings.curve[static_cast<size_t>(i)]);
    const double interval = 1 / device_.gyroscope_rate;
    Vector3d lift = Vector3d::Zero();
    if (carried)
      lift = so3_log(simulated_.true_frames[c - 1].back().transpose() * simulated_.true_frames[c].front());
    for (double k = std::floor(begin / interval) + 1; k * interval < end - 1e-6; ++k) {
      const double time = k * interval;
      if (time <= begin + 1e-6) continue;
      Vector3d rate = Vector3d::Zero();
      Eigen::Index row = 0;
      if (carried) {
        rate = lift / (end - begin) * (1 - std::cos(2 * kPi * (time - begin) / (end - begin)));
        row = add(time, SensorLog::kNone, SensorLog::kNone, std::numeric_limits<double>::quiet_NaN());
      } else if (approach.resting) {
        row = add(time, static_cast<int>(c), readings.node[static_cast<size_t>(i)], readings.distance[i]);
      } else {
        const double tau = std::clamp((time - approach.start) / approach.duration, 0.0, 1.0);
        const double s = approach.from + approach.gap * (tau - std::sin(2 * kPi * tau) / (2 * kPi));
        const double speed = approach.gap / approach.duration * (1 - std::cos(2 * kPi * tau));
        rate = speed * turn_per_length(*traced_.curves[c].path, s, traced_.curves[c].closed);
        row = add(time, static_cast<int>(c), SensorLog::kNone, simulated_.report.distance_factors[c] * s);
      }
      out_.gyroscope.row(row) = device_.gyroscope_distortion * (device_.axes.matrix() * rate) +
                                device_.gyroscope_bias + wandering(time) +
                                device_.gyroscope_noise * noise_.normal3();
    }
  }

  const TracedNetwork& traced_;
  const SimulatedScan& simulated_;
  const DeviceModel& device_;
  Random noise_, walk_;
  SensorLog out_;
  Eigen::Index n_ = 0;
  Vector3d walked_ = Vector3d::Zero();
  double time_ = 0;
};

}  // namespace

std::optional<std::string> GyroscopeOptions::problem() const {
  std::optional<std::string> problem;
  const auto within = [&](const char* name, double value, double most) {
    if (!problem && !(value >= 0 && value <= most))
      problem = concat("the gyroscope's ", name, " must lie in [0, ", most, "], got ", value);
  };
  if (!(rate > 0 && rate <= 10000))
    problem = concat("the gyroscope's rate must lie in (0, 10000] Hz, got ", rate);
  within("bias", bias, 10);
  within("walk", walk, 1);
  within("scale", scale, 0.5);
  within("misalignment", misalignment, 0.5);
  within("temperature", temperature, 1);
  within("warming", warming, 100);
  within("noise", noise, 10);
  return problem;
}

void add_gyroscope(DeviceModel& device, const GyroscopeOptions& options, std::uint64_t seed) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  Random random(seed, kGyroscope);
  device.gyroscope_rate = options.rate;
  device.gyroscope_bias = options.bias * random.normal3();
  device.gyroscope_walk = options.walk;
  device.gyroscope_warming = options.temperature * options.warming * random.normal3();
  device.gyroscope_distortion = Matrix3d::Identity();
  device.gyroscope_distortion.diagonal() += options.scale * random.normal3();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j) device.gyroscope_distortion(i, j) = options.misalignment * random.normal();
  device.gyroscope_noise = options.noise;
}

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
  std::vector<Approach> approaches;
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
      approaches.push_back({resting, leg_start, duration, stops[leg], gap});
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
  if (!(device.gyroscope_rate > 0)) return log;
  return GyroscopeRows(traced, simulated, device, seed).between(log, approaches);
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
