#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/scan/sensor_log.hpp"

namespace batten {

/// What a field of a sensor log may hold.
enum class LogQuantity { Time, Curve, Node, Distance, Accelerometer, Magnetometer, Gyroscope };

/// The fields that hold one quantity, and what their numbers are times to become those of SensorLog.
struct LogFields {
  std::vector<std::string> names;  ///< one, or three for x, y and z; as the file spells them
  std::string unit;                ///< as written; empty where the numbers must tell (guessed columns alone)
  double factor = 1;               ///< to s, m, m/s², µT, rad/s
};

/// Which fields of a log hold what: those of one's own program, told by the person who knows them.
struct LogColumns {
  std::array<std::optional<LogFields>, 7> fields;  ///< by LogQuantity

  /// The fields of a quantity; nothing where the log has none.
  const std::optional<LogFields>& operator[](LogQuantity quantity) const {
    return fields[static_cast<std::size_t>(quantity)];
  }
  /// The same, to be set.
  std::optional<LogFields>& operator[](LogQuantity quantity) {
    return fields[static_cast<std::size_t>(quantity)];
  }
};

/// Reads a description as
/// `time=t_ms:ms,acc=ax:ay:az:g,mag=mx:my:mz:uT,gyr=gx:gy:gz:deg/s,distance=ticks:0.026mm,curve=c,node=n`.
/// Units: s ms us ns · m/s2 g mg · uT nT mT T G mG · rad/s deg/s mdeg/s · m cm mm um in ft, or a number with
/// one of these; without unit, those of SensorLog.
/// @throws InvalidInput naming what is wrong and the form.
LogColumns parse_log_columns(std::string_view text);

/// The same as text, which parse_log_columns() reads; guessed fields without a known unit have none.
std::string format_log_columns(const LogColumns& columns);

/// The columns that names as phyphox, Sensor Logger, x-IMU and others write them suggest: `Acceleration x
/// (m/s^2)`, `AccelX`, `acc_x_g`, `Timestamp(ms)`, `seconds_elapsed`, … Units stand in brackets or at the end
/// of a name. Nothing is taken for what it only might be: linear acceleration, without gravity, is no
/// accelerometer.
LogColumns guess_log_columns(const std::vector<std::string>& names);

/// Gives guessed fields without a unit the one that their numbers suggest, and scales the log by it:
/// accelerations of a device at rest have 9.81 m/s² or 1 g, readings come every 1 to 200 ms, the field has 20
/// to 70 µT.
void settle_units(LogColumns& columns, SensorLog& log);

/// What is odd about the numbers of a log, with the remedy: accelerations that are not near 9.8 m/s², times
/// that look like milliseconds, a field that no place of the Earth has.
std::vector<std::string> log_oddities(const SensorLog& log);

}  // namespace batten
