#pragma once
#include "commands/json.hpp"

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten::commands {

/// Median, 95th percentile and largest of standard deviations per vertex, and where the last is.
/// @pre there is one deviation at least.
Json uncertainty_json(const Points& positions, const Eigen::VectorXd& deviations);

}  // namespace batten::commands
