#pragma once
#include <vector>

#include "batten/scan/sensor_log.hpp"

namespace batten {

/// Gives the curves of a scan the turns of the gyroscope from reading to reading and from curve to curve
/// (ScanCurve::turns), where the log has a gyroscope that was read often enough.
/// @param rows per curve, the rows of the log behind its readings.
void add_gyroscope_turns(const SensorLog& log, const Calibration& calibration,
                         const std::vector<std::vector<Eigen::Index>>& rows, LogScan& scan);

}  // namespace batten
