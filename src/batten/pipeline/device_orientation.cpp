#include "batten/pipeline/device_orientation.hpp"

#include "batten/core/error.hpp"

namespace batten {

std::optional<std::string> DeviceOrientationOptions::problem() const {
  return estimate.problem();
}

DeviceOrientation device_orientation(const SensorLog& log, const DeviceOrientationOptions& options,
                                     const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  DeviceOrientation result;
  const ScopedStage stage(result.times, options.causal ? "filter" : "smooth");
  result.estimate = options.causal ? filter_orientation(log, options.estimate, progress)
                                   : estimate_orientation(log, options.estimate, progress);
  return result;
}

}  // namespace batten
