#include "uncertainty_figures.hpp"

#include "commands/uncertainty.hpp"

#include "batten/core/text.hpp"

namespace batten::cli {

void report_uncertainty(const Points& positions, const Eigen::VectorXd& deviations, Outcome& outcome) {
  const Json figures = commands::uncertainty_json(positions, deviations);
  const Json& place = figures["at"];
  outcome.figures["uncertainty"] = figures;
  const auto number = [&](const char* key) { return figures[key].get<double>(); };
  outcome.lines.push_back(concat("standard deviation: median ", number("median"), ", 95 % below ",
                                 number("p95"), ", most ", number("max"), " at (", place[0].get<double>(),
                                 ", ", place[1].get<double>(), ", ", place[2].get<double>(), ")"));
}

}  // namespace batten::cli
