#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/capture/decode.hpp"

// Private to the room: the two halves of decode_recording().
namespace batten::detail {

constexpr double kMissingValue = std::numeric_limits<double>::quiet_NaN();

/// What a device measured at one time, whatever it speaks.
struct Reading {
  std::int64_t time_us = 0;           ///< host time at which it was taken
  double distance = kMissingValue;    ///< that the wheel has turned in all, metres
  bool distance_lost_before = false;  ///< the wheel may have turned uncounted since the reading before
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Constant(kMissingValue);
  Eigen::Vector3d magnetometer = Eigen::Vector3d::Constant(kMissingValue);
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Constant(kMissingValue);
  Eigen::Vector4d orientation = Eigen::Vector4d::Constant(kMissingValue);  ///< w x y z, device → world
};

/// All readings of a device in the order of time, and keys that were pressed: (host time, key).
struct Readings {
  std::vector<Reading> readings;
  std::vector<std::pair<std::int64_t, std::string>> keys;
  DeviceAxes axes;
};

/// The readings of packets. Adds to the report and the warnings of `decoded`.
void add_packet_readings(const Recording& recording, const DecodeOptions& options, Readings& readings,
                         DecodedRecording& decoded);
/// The readings of lines, in the same way.
void add_line_readings(const Recording& recording, Readings& readings, DecodedRecording& decoded);
/// Curves and nodes from the keys: fills the log and the orientations of `decoded`.
void lay_out_curves(const Recording& recording, const Readings& readings, DecodedRecording& decoded);

}  // namespace batten::detail
