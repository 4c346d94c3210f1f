#include "commands/uncertainty.hpp"

#include <vector>

#include "batten/core/statistics.hpp"

namespace batten::commands {

Json uncertainty_json(const Points& positions, const Eigen::VectorXd& deviations) {
  std::vector<double> values(deviations.begin(), deviations.end());
  Eigen::Index worst = 0;
  const double most = deviations.maxCoeff(&worst), middle = median(values), high = percentile(values, 0.95);
  const Eigen::RowVector3d place = positions.row(worst);
  return {{"median", middle}, {"p95", high}, {"max", most}, {"at", {place[0], place[1], place[2]}}};
}

}  // namespace batten::commands
