#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/capture/morphorider.hpp"
#include "batten/core/random.hpp"
#include "batten/scan/sensor_log.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten {

/// How a simulated hand moves a device.
struct MotionOptions {
  double scale = 1;   ///< metres per unit of the log's distances
  double pace = 10;   ///< times the speed of `simulate --raw`, a fiftieth of the diameter per second; above 0
  double rest_s = 1;  ///< at every node, where its number is typed; above 0
  bool tumble = false;  ///< a minute of turning over before the first curve, for the calibration

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A motion of a device along curves, as a function of time, with the keys that a person presses meanwhile.
class DeviceMotion {
 public:
  /// The device at one moment.
  struct State {
    Eigen::Matrix3d orientation;  ///< device → world
    Eigen::Vector3d rate;         ///< rad/s, device axes
    double distance = 0;          ///< that the wheel has rolled in all, metres
  };

  /// @param log accelerometer, magnetometer and distances on every row of curves, as simulate_log() makes it.
  /// @throws InvalidInput when it has none, or an option is out of range.
  explicit DeviceMotion(const SensorLog& log, const MotionOptions& options = {});

  double duration() const { return times_.back(); }  ///< seconds
  /// The device at a time; before the start and behind the end it rests there.
  State at(double seconds) const;
  /// (seconds, key), in order.
  const std::vector<std::pair<double, std::string>>& keys() const { return keys_; }
  const DeviceAxes& axes() const { return axes_; }

 private:
  void add(double seconds, const Eigen::Matrix3d& orientation, double distance);
  void add_tumble();
  void find_speeds();
  void add_keys(const SensorLog& log, const std::vector<double>& row_times);

  DeviceAxes axes_;
  std::vector<double> times_;
  std::vector<Eigen::Matrix3d> orientations_;
  std::vector<double> distances_, speeds_;
  std::vector<std::size_t> lifts_;  // spans in which the device is carried to the next curve, increasing
  std::vector<std::pair<double, std::string>> keys_;
};

/// A stretch of time, seconds since the first contact.
struct FaultSpan {
  double start = 0, duration = 0;
  bool contains(double seconds) const { return seconds >= start && seconds < start + duration; }
};

/// What a simulated device is, and what goes wrong with it.
struct SimulatedDeviceOptions {
  enum class Kind { Morphorider, Line };

  Kind kind = Kind::Morphorider;
  PacketForm form = PacketForm::BigSignMagnitude;
  double rate_hz = 100;     ///< of the line protocol; (0, 1000]
  bool fused = false;       ///< line protocol: Q lines beside S lines
  double wheel_m = 0.0628;  ///< circumference, above 0
  double noise = 1;         ///< factor on the noise of the sensors, at least 0
  bool distortion = false;  ///< zero errors, scales and soft iron that need a calibration
  double flip = 0;          ///< share of bytes with one bit turned, [0, 1]
  double lose = 0;          ///< share of bytes that are lost
  double late = 0;          ///< share of answers that come 80 ms late
  double duplicate = 0;     ///< share of answers that come twice
  double burst_s = 0;       ///< line protocol: delivered in bursts so far apart, as Bluetooth does
  double clock_ppm = 0;     ///< by which the device's clock is fast
  FaultSpan unplug;         ///< the port is gone
  FaultSpan silence;        ///< the port is there, but nothing comes
  FaultSpan slip;           ///< the wheel slips
  double slip_share = 0.5;  ///< of the way that it does not count meanwhile
  double restart_s = -1;    ///< the index begins anew; negative: never
  double reboot_s = -1;     ///< index, ticks and clock begin anew
  std::uint64_t seed = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A device as the computer sees it: bytes in, bytes out, each at its time. Time begins with the first byte
/// that it gets. The same requests at the same times give the same answers.
class SimulatedDevice {
 public:
  /// @throws InvalidInput when an option is out of range.
  SimulatedDevice(DeviceMotion motion, const SimulatedDeviceOptions& options);

  /// Takes bytes that the computer sends.
  void receive(std::string_view bytes, std::int64_t now_us);
  /// What has arrived at the computer by now and was not fetched before.
  std::string transmit(std::int64_t now_us);
  /// When transmit() has something next, or far in the future where that depends on requests.
  std::int64_t next_transmission_us(std::int64_t now_us);

  /// Whether the cable is in: not within a fault that pulls it.
  bool plugged(std::int64_t now_us) const;
  bool finished(std::int64_t now_us) const;  ///< the motion is over
  /// Keys pressed by now and not fetched before, with their times.
  std::vector<std::pair<std::int64_t, std::string>> keys(std::int64_t now_us);
  const DeviceMotion& motion() const { return motion_; }
  const SimulatedDeviceOptions& options() const { return options_; }
  const DeviceModel& model() const { return model_; }

 private:
  double seconds(std::int64_t now_us) const { return static_cast<double>(now_us - start_us_) * 1e-6; }
  double wheel_distance(double seconds) const;
  void measure(double seconds, Eigen::Vector3d& acc, Eigen::Vector3d& mag, Eigen::Vector3d& gyr);
  void answer_request(std::int64_t now_us);
  void emit_lines(std::int64_t now_us);
  void send(std::string bytes, std::int64_t due_us);

  DeviceMotion motion_;
  SimulatedDeviceOptions options_;
  DeviceModel model_;
  Random noise_, faults_;
  bool started_ = false;
  std::int64_t start_us_ = 0, counting_since_us_ = 0;
  long next_sample_ = 0;
  double ticks_zero_m_ = 0;
  std::uint32_t index_ = 0, seq_ = 0;
  bool restarted_ = false, rebooted_ = false;
  std::size_t next_key_ = 0;
  std::string request_;  // a command of the host that is not complete yet
  std::multimap<std::int64_t, std::string> outgoing_;
};

}  // namespace batten
