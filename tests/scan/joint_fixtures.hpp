#pragma once
#include "scan/scan_fixtures.hpp"

#include <string>
#include <vector>

#include "batten/core/units.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/prefilter.hpp"

namespace batten::test {

/// A scan of a noisy device, sampled every 5 % of the diameter.
/// @param wrap closed curves share the frame of their ends.
inline SampledScan coarse_samples(AnalyticShape shape, int seed, bool wrap = false) {
  const TracedNetwork traced = trace_shape(shape);
  const Scan scan = simulate_scan(traced, noisy_device(seed)).scan;
  std::vector<std::string> warnings;
  PrefilterOptions options;
  options.step = 0.05 * traced.diameter;
  options.wrap = wrap;
  return resample(scan, clean_readings(scan, {}, warnings), options);
}

/// What estimate_jointly() is told of such a scan.
inline JointOptions coarse_options(AnalyticShape shape) {
  JointOptions options;
  options.size = trace_shape(shape).diameter;
  options.reading_noise = radians(2);
  return options;
}

}  // namespace batten::test
