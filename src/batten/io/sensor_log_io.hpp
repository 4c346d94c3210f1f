#pragma once
#include <string>
#include <vector>

#include "batten/scan/calibration.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

/// Reads a sensor log: comma-separated values whose first line names the columns (docs/files.md, "Sensor
/// logs"). Columns may stand in any order and be missing; unknown ones are ignored; empty cells and `nan` are
/// missing values. `# axes: forward=+x normal=+z` and `# curve 1: boundary closed name=rim` are understood,
/// other comments skipped.
/// Logs of other programs have columns, separators (`,` `;` tab) and units of their own: `columns` describes
/// them (parse_log_columns()), or is "auto" (guess_log_columns()); without curves all of such a log is one.
/// @param notes takes how columns were guessed, and what is odd about the numbers (log_oddities()).
/// @throws FileError with file and line: cells that are no numbers, rows of the wrong length, decreasing
/// times or distances within a curve, a curve that is taken up again, node numbers with gaps, no rows,
/// columns that are not there; InvalidInput as parse_log_columns().
SensorLog read_sensor_log(const std::string& path, const std::string& columns = {},
                          std::vector<std::string>* notes = nullptr);
/// The same from memory; `name` stands for the path in errors.
SensorLog parse_sensor_log(std::string text, const std::string& name, const std::string& columns = {},
                           std::vector<std::string>* notes = nullptr);

/// Writes a log that read_sensor_log() reads back as exactly the same. @throws FileError.
void write_sensor_log(const SensorLog& log, const std::string& path);

/// Reads a calibration as `batten calibrate` writes it (docs/files.md, "Calibrations").
/// @throws FileError naming the entry that is missing or wrong.
Calibration read_calibration(const std::string& path);
/// The same from memory.
Calibration parse_calibration(const std::string& text, const std::string& name);

/// Writes a calibration with the figures of its fits, as JSON. @throws FileError.
void write_calibration(const DeviceCalibration& device, const std::string& path);

}  // namespace batten
