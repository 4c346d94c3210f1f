#pragma once
#include "command.hpp"

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten::cli {

/// Adds median, 95th percentile and largest of standard deviations per vertex, and where that is.
void report_uncertainty(const Points& positions, const Eigen::VectorXd& deviations, Outcome& outcome);

}  // namespace batten::cli
