#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/scan/sensor_log.hpp"

namespace batten {

// The line protocol that anyone can build (docs/capture.md#the-line-protocol): UTF-8 lines of at most 200
// characters, whose first byte tells the kind, over a serial line, WebSocket, UDP or in a file.

/// `#batten 1 device=NAME axes=+x,+z ticks_per_m=20000 rate_hz=100 quat=wxyz`.
struct DeviceHeader {
  std::string device;
  std::optional<DeviceAxes> axes;
  double ticks_per_m = 0;     ///< 0: the device has no wheel, or does not know
  double rate_hz = 0;         ///< 0: not told
  double wheel_offset_m = 0;  ///< the wheel touches this far ahead of the sensor; negative: behind
  bool checked = true;        ///< lines end in *HH; `check=none` says that they need not
};

/// `S,<seq>,<t_us>,<ticks>,<ax>,<ay>,<az>,<gx>,<gy>,<gz>,<mx>,<my>,<mz>*HH`. What is not measured is NaN.
struct RawSample {
  std::uint32_t seq = 0, t_us = 0;  ///< both wrap
  std::optional<std::int32_t> ticks;
  Eigen::Vector3d accelerometer;  ///< m/s²
  Eigen::Vector3d gyroscope;      ///< rad/s
  Eigen::Vector3d magnetometer;   ///< µT
};

/// `Q,<seq>,<t_us>,<ticks>,<w>,<x>,<y>,<z>,<accuracy_rad>*HH`.
struct FusedSample {
  std::uint32_t seq = 0, t_us = 0;
  std::optional<std::int32_t> ticks;
  Eigen::Quaterniond orientation;  ///< device → world with z up; unit
  double accuracy_rad = 0;         ///< NaN where not told
};

/// `K,<seq>,<t_us>,<key>*HH`. Keys: new, node, node=N, end, undo, mode, discard, pause.
struct ButtonPress {
  std::uint32_t seq = 0, t_us = 0;
  std::string key;
};

/// `E,<text>*HH`: what is wrong, in the device's words.
struct DeviceComplaint {
  std::string text;
};

using LineMessage = std::variant<DeviceHeader, RawSample, FusedSample, ButtonPress, DeviceComplaint>;

constexpr std::size_t kLongestLine = 200;

/// Exclusive or of all bytes, as in NMEA 0183.
unsigned line_check(std::string_view body);

/// Reads one line without its end; blanks at either end do not count.
/// @param checked whether *HH is demanded (DeviceHeader::checked). Where it stands it must be right in any
/// case. Headers have none.
/// @throws InvalidInput in words: too long, wrong check, unknown kind, fields missing or no numbers, numbers
/// that no sensor has (above 1e6 in size), a quaternion far from unit length, a header of a newer version.
LineMessage parse_line(std::string_view line, bool checked = true);

/// A line without its end, which parse_line() reads back: times and ticks exactly, other numbers to six
/// significant digits.
std::string format_line(const LineMessage& message);

/// Cuts a stream of bytes into lines. Lines too long are given out in pieces of kLongestLine, so that babble
/// without line ends needs no memory.
class LineSplitter {
 public:
  /// The lines that are complete now, without their ends; empty ones are left out.
  std::vector<std::string> push(std::string_view bytes);

 private:
  std::string rest_;
};

}  // namespace batten
