#pragma once
#include <optional>
#include <string>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/scan/orientation.hpp"

namespace batten {

/// Options of device_orientation(). The defaults are those of `batten orient`.
struct DeviceOrientationOptions {
  OrientationOptions estimate;
  /// Each orientation from the readings up to it alone, as a live view shows it: errors are larger.
  bool causal = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How a device was held all along a recording.
struct DeviceOrientation {
  OrientationEstimate estimate;
  StageTimes times;
};

/// Orientations of every row of a log: estimate_orientation(), or filter_orientation() where causal.
/// @throws InvalidInput with the sensor or reading that is missing and the remedy; SolverFailure; Cancelled.
DeviceOrientation device_orientation(const SensorLog& log, const DeviceOrientationOptions& options = {},
                                     const Progress& progress = {});

}  // namespace batten
