// The surface of FIRES V1 from nothing on models of growing size, and the division of one face by both
// searches.
#include "sketch/models.hpp"
#include "subdivision/cages.hpp"

#include <cmath>

#include <benchmark/benchmark.h>

#include "batten/core/random.hpp"
#include "batten/modelling/coons_surface.hpp"

namespace batten {
namespace {

/// A wavy sheet of n curves, half along x and half along y; every edge is a polyline of 8 segments.
PolylineMesh sheet_of(int n_curves) {
  const int n = n_curves / 2;
  const ControlCage cage = cages::grid(
      n, n, [&](int i, int j) { return Eigen::RowVector3d(i, j, 0) / static_cast<double>(n - 1); });
  return models::model_of_cage(cage.mesh, [&](int from, int to) {
    Points points(9, 3);
    for (int i = 0; i <= 8; ++i) {
      points.row(i) = cage.mesh.positions.row(from) +
                      (cage.mesh.positions.row(to) - cage.mesh.positions.row(from)) * i / 8.0;
      points(i, 2) = 0.1 * std::sin(5 * points(i, 0)) * std::cos(4 * points(i, 1));
    }
    return points;
  });
}

void BM_CoonsSurface(benchmark::State& state) {
  const PolylineMesh mesh = sheet_of(static_cast<int>(state.range(0)));
  CoonsSurface surface;
  for (auto _ : state) surface = coons_surface(mesh, {.steps = 1, .levels = 0});
  for (const auto& [stage, seconds] : surface.times.stages()) state.counters[stage + "_ms"] = 1e3 * seconds;
  state.counters["quads"] = static_cast<double>(surface.refined.mesh.n_faces());
}

void BM_SplitFace(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(0));
  Random random(3);
  std::vector<SharedPolyline> sides;
  Points corners(n, 3);
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n, radius = random.uniform(0.5, 1);
    corners.row(k) << radius * std::cos(angle), radius * std::sin(angle), 0;
  }
  for (int k = 0; k < n; ++k) {
    Points side(2, 3);
    side << corners.row(k), corners.row((k + 1) % n);
    sides.push_back(std::make_shared<Polyline>(side));
  }
  const SplitSearch search = state.range(1) == 0 ? SplitSearch::Optimal : SplitSearch::Greedy;
  for (auto _ : state) benchmark::DoNotOptimize(split_face(sides, search));
}

BENCHMARK(BM_CoonsSurface)->Arg(50)->Arg(150)->Arg(500)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_SplitFace)->ArgsProduct({{6, 12, 24, 40}, {0, 1}})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
