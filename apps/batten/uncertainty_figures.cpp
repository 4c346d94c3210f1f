#include "uncertainty_figures.hpp"

#include <vector>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"

namespace batten::cli {

void report_uncertainty(const Points& positions, const Eigen::VectorXd& deviations, Outcome& outcome) {
  std::vector<double> values(deviations.begin(), deviations.end());
  Eigen::Index worst = 0;
  const double most = deviations.maxCoeff(&worst), middle = median(values), high = percentile(values, 0.95);
  const Eigen::RowVector3d place = positions.row(worst);
  outcome.figures["uncertainty"] = {
      {"median", middle}, {"p95", high}, {"max", most}, {"at", {place[0], place[1], place[2]}}};
  outcome.lines.push_back(concat("standard deviation: median ", middle, ", 95 % below ", high, ", most ",
                                 most, " at (", place[0], ", ", place[1], ", ", place[2], ")"));
}

}  // namespace batten::cli
