// Integration at three sizes: steps from frames, then positions in both closure forms; and the regression of
// the same scan, of whose time it may take 5 % at most. See docs/performance.md.
#include "memory.hpp"
#include "scan_networks.hpp"

#include <benchmark/benchmark.h>

#include "batten/scan/integration.hpp"
#include "batten/scan/regression.hpp"

namespace batten {
namespace {

using samples::Growth;

void integration(benchmark::State& state, Growth growth, ClosureForm form, StepRule rule) {
  const SampledScan scan = samples::grid_of(state.range(0), growth);
  IntegrationResult result;
  for (auto _ : state) result = integrate_steps(scan, frame_steps(scan, rule), form);
  state.counters["samples"] = scan.n_samples();
  state.counters["loops"] = result.n_loops;
  state.counters["peak_MB"] = peak_megabytes();
}

/// The regression that comes before it, with weights that smooth as much at every size.
void regression(benchmark::State& state, Growth growth) {
  const SampledScan scan = samples::grid_of(state.range(0), growth);
  RegressionOptions options;
  options.lambda = 1e-4;
  options.mu = 5.2e-6;
  for (auto _ : state) benchmark::DoNotOptimize(regress_frames(scan, options));
  state.counters["samples"] = scan.n_samples();
}

// The processors share the steps, so the time of all of them counts.
#define SIZES ->Arg(10000)->Arg(100000)->Arg(1000000)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond)
BENCHMARK_CAPTURE(integration, first_difference_larger_network, Growth::Network, ClosureForm::FirstDifference,
                  StepRule::ConstantRate)
SIZES;
BENCHMARK_CAPTURE(integration, first_difference_denser_samples, Growth::Sampling,
                  ClosureForm::FirstDifference, StepRule::ConstantRate)
SIZES;
// Not on larger networks: there its system of the nodes is dense (integration.hpp).
BENCHMARK_CAPTURE(integration, second_difference_denser_samples, Growth::Sampling,
                  ClosureForm::SecondDifference, StepRule::Tangent)
SIZES;
BENCHMARK_CAPTURE(regression, larger_network, Growth::Network) SIZES;
BENCHMARK_CAPTURE(regression, denser_samples, Growth::Sampling) SIZES;

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
