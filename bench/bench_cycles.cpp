// Patches of networks whose normals are not known, at three sizes: circles around a torus with waves on it.
// Build with -DBATTEN_BUILD_BENCH=ON; see docs/performance.md.
#include "network/torus_grid.hpp"

#include <cmath>

#include <benchmark/benchmark.h>

#include "batten/strokes/estimated_cycles.hpp"
#include "batten/strokes/stroke_cleaning.hpp"

namespace batten {
namespace {

/// Nodes n × 2n, so 4 n² curves between nodes, of 12 edges each; 2 n² patches.
CurveNetwork grid_of(long segments) {
  const auto n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(segments) / 4)));
  return fixtures::torus_grid(n, 2 * n, 12, 0.1);
}

void BM_EstimateCycles(benchmark::State& state) {
  const CurveNetwork network = grid_of(state.range(0));
  EstimatedCycles estimate;
  for (auto _ : state) estimate = estimate_cycles(network);
  state.counters["segments"] = static_cast<double>(network_topology(network).segments.size());
  state.counters["cycles"] = static_cast<double>(estimate.cycles.size());
  state.counters["doubtful"] = static_cast<double>(estimate.warnings.size());
}

/// The same from normals, for comparison.
void BM_CyclesFromNormals(benchmark::State& state) {
  CurveNetwork network = grid_of(state.range(0));
  network.normals = estimate_cycles(network).normals;
  for (auto _ : state) benchmark::DoNotOptimize(find_cycles(network));
}

/// Strokes that cross without sharing a vertex made into the same network.
void BM_CleanSketch(benchmark::State& state) {
  const CurveNetwork sketch = fixtures::unwelded(grid_of(state.range(0)));
  CleanedStrokes cleaned;
  for (auto _ : state) cleaned = clean_strokes(sketch, {.weld_tolerance = 0.001, .reach = 0.002});
  state.counters["segments"] = static_cast<double>(network_topology(cleaned.network).segments.size());
}

#define SIZES ->Arg(100)->Arg(400)->Arg(1600)->Arg(6400)->Unit(benchmark::kMillisecond)
BENCHMARK(BM_EstimateCycles) SIZES;
BENCHMARK(BM_CyclesFromNormals) SIZES;
BENCHMARK(BM_CleanSketch) SIZES;

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
