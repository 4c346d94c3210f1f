#pragma once
#include <string>

#include <Eigen/Core>

#include "batten/scan/orientation.hpp"

namespace batten {

/// Writes orientations as comma-separated values, a row per reading (docs/files.md, "Orientations"):
/// time_s,w,x,y,z,tilt_sd_deg,heading_sd_deg; cells of readings without an orientation are empty.
/// @param time as many seconds as the estimate has rows. @throws FileError.
void write_orientations(const OrientationEstimate& estimate, const Eigen::VectorXd& time,
                        const std::string& path);

}  // namespace batten
