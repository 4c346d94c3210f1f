#include "batten/core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace batten {

double order_statistic(std::span<double> values, std::size_t rank) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double upper_median(std::span<double> values) {
  return values.empty() ? 0 : order_statistic(values, values.size() / 2);
}

double median(std::span<double> values) {
  if (values.empty()) return 0;
  const double upper = order_statistic(values, values.size() / 2);
  if (values.size() % 2 == 1) return upper;
  // What lies before the middle is now no larger than it.
  return 0.5 * (upper + *std::max_element(values.begin(),
                                          values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)));
}

double percentile(std::span<double> values, double share) {
  if (values.empty()) return 0;
  return order_statistic(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

double deviation_by_median(std::span<double> values, double centre) {
  for (double& value : values) value = std::abs(value - centre);
  return kMadToDeviation * upper_median(values);
}

}  // namespace batten
