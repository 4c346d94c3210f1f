// Whole surfacing against one factorisation and solve of the same system, and a re-solve against a
// back-substitution, at three sizes. Build with -DBATTEN_BUILD_BENCH=ON; see docs/performance.md.
#include "memory.hpp"
#include "network/sample_networks.hpp"
#include "network/torus_grid.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <memory>

#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {
namespace {

/// Three great circles sampled so that the surface has about `vertices` vertices (14 n², counted).
CurveNetwork sphere_of(long vertices) {
  return samples::octahedral_sphere(
      static_cast<int>(std::lround(std::sqrt(static_cast<double>(vertices) / 14))));
}

/// The surface of each size, built once and shared by the benchmarks below.
SurfaceSolver& solver_of(long vertices) {
  static std::map<long, std::unique_ptr<SurfaceSolver>> solvers;
  auto& solver = solvers[vertices];
  if (!solver) {
    solvers.clear();  // one at a time: the largest fills memory
    return *(solvers[vertices] = std::make_unique<SurfaceSolver>(sphere_of(vertices)));
  }
  return *solver;
}

void report(benchmark::State& state, const SurfaceResult& surface) {
  state.counters["vertices"] = static_cast<double>(surface.mesh.n_vertices());
  state.counters["peak_MB"] = peak_megabytes();
}

void BM_WholeSurface(benchmark::State& state) {
  const CurveNetwork network = sphere_of(state.range(0));
  SurfaceResult surface;
  for (auto _ : state) surface = surface_network(network);
  report(state, surface);
  state.counters["rebuilds"] = surface.rebuilds;
  for (const auto& [stage, seconds] : surface.times.stages()) state.counters[stage + "_s"] = seconds;
}

/// K M⁻¹ K over the free vertices of the finished mesh, and three right-hand sides.
struct System {
  SparseMatrix lower;
  Eigen::MatrixXd right;
};
System system_of(const SurfaceResult& surface, int columns) {
  const SparseMatrix K = cotangent_stiffness(surface.mesh.positions, surface.mesh.triangles);
  const Eigen::VectorXd inverse = lumped_mass(surface.mesh.positions, surface.mesh.triangles).cwiseInverse();
  std::vector<int> unknown(surface.on_network.size(), -1), known(surface.on_network.size(), -1);
  int u = 0, k = 0;
  for (std::size_t v = 0; v < unknown.size(); ++v)
    (surface.on_network[v] ? known[v] : unknown[v]) = surface.on_network[v] ? k++ : u++;
  return {squared_stiffness(K, inverse, unknown, known).lower, Eigen::MatrixXd::Ones(u, columns)};
}

void BM_FactoriseAndSolve(benchmark::State& state) {
  const SurfaceResult& surface = solver_of(state.range(0)).result();
  const System system = system_of(surface, 3);
  for (auto _ : state) {
    SparseCholesky factor("benchmark");
    factor.factorize(system.lower);
    benchmark::DoNotOptimize(factor.solve(system.right));
  }
  report(state, surface);
}

/// A re-solve after moving the curves needs six columns: three for the base, then three that follow from it.
/// Here in one go, which no re-solve can do, and below one after the other, both with one factor over all.
void BM_BackSubstitution(benchmark::State& state) {
  const SurfaceResult& surface = solver_of(state.range(0)).result();
  const System system = system_of(surface, 6);
  SparseCholesky factor("benchmark");
  factor.factorize(system.lower);
  for (auto _ : state) benchmark::DoNotOptimize(factor.solve(system.right));
  report(state, surface);
}

void BM_BackSubstitutionInTurn(benchmark::State& state) {
  const SurfaceResult& surface = solver_of(state.range(0)).result();
  const System system = system_of(surface, 3);
  SparseCholesky factor("benchmark");
  factor.factorize(system.lower);
  for (auto _ : state) {
    benchmark::DoNotOptimize(factor.solve(system.right));
    benchmark::DoNotOptimize(factor.solve(system.right));
  }
  report(state, surface);
}

void BM_Resolve(benchmark::State& state) {
  SurfaceSolver& solver = solver_of(state.range(0));
  const CurveNetwork network = sphere_of(state.range(0));
  Points positions = network.positions;
  for (auto _ : state) {
    positions.col(2).array() += 1e-4;
    benchmark::DoNotOptimize(solver.move(positions, network.normals));
  }
  report(state, solver.result());
}

/// A torus of 7 × 8 patches with `edges` edges on every side of a patch.
CurveNetwork torus_of(int edges) {
  CurveNetwork network = fixtures::torus_grid(8, 7, edges, 0);
  network.normals = network.positions;
  for (Eigen::Index v = 0; v < network.normals.rows(); ++v) {
    const Eigen::RowVector3d p = network.positions.row(v);
    const Eigen::RowVector3d middle = 2 * Eigen::RowVector3d(p.x(), p.y(), 0).normalized();
    network.normals.row(v) = (p - middle).normalized();
  }
  return network;
}

/// Processor time of a call in ms, all threads together.
template <typename Call>
double milliseconds(const Call& call) {
  const std::clock_t begin = std::clock();
  call();
  return 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// Moves of a surface of 56 patches, one after the other in every round so that all see the same machine; the
/// least of all rounds counts. A node and the sides that meet there belong to four patches.
void BM_Moves(benchmark::State& state) {
  const CurveNetwork network = torus_of(static_cast<int>(state.range(0)));
  const int per_node = 2 * static_cast<int>(state.range(0)) - 1;
  double fresh = std::numeric_limits<double>::infinity(), whole = fresh, four = fresh, dragged = fresh;
  SurfaceMove last;
  Eigen::Index triangles = 0;
  for (auto _ : state) {
    std::unique_ptr<SurfaceSolver> solver;
    fresh = std::min(fresh, milliseconds([&] { solver = std::make_unique<SurfaceSolver>(network); }));
    triangles = solver->result().mesh.triangles.rows();
    Points all = network.positions, one = network.positions;
    for (int round = 0; round < 7; ++round) {
      all.col(2).array() += 1e-3;
      one.middleRows(10 * per_node, 1).array() += 1e-3;
      const auto move = [&](const Points& positions, const SurfaceMoveOptions& options) {
        return milliseconds([&] { last = solver->move(positions, network.normals, options); });
      };
      const double all_now = move(all, {});
      move(one, {});  // takes all others back
      one.middleRows(10 * per_node, 1).array() += 1e-3;
      const double four_now = move(one, {}), dragged_now = move(one, {.positions_only = true});
      // The first round makes the factors.
      if (round == 0) continue;
      whole = std::min(whole, all_now);
      four = std::min(four, four_now);
      dragged = std::min(dragged, dragged_now);
    }
  }
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["patches"] = last.patches_solved;
  state.counters["fresh_ms"] = fresh;
  state.counters["whole_ms"] = whole;
  state.counters["four_ms"] = four;
  state.counters["dragged_ms"] = dragged;
  state.counters["whole/fresh"] = whole / fresh;
  state.counters["four/whole"] = four / whole;
  state.counters["dragged/whole"] = dragged / whole;
}

/// From a slider for μ to the surface: twenty positions, each followed by a kept regression of the scan of a
/// torus and a kept surface of its network. Medians.
void BM_SliderToSurface(benchmark::State& state) {
  SimulateOptions device;
  device.seed = 1;
  device.orientation_noise = radians(2);
  device.drift = radians(1);
  device.step = 0.002;
  const double step = 1e-4 * static_cast<double>(state.range(0));
  ReconstructionSolver scan(simulate_scan(trace_shape(AnalyticShape::Torus), device).scan);
  ScanOptions options;
  options.weights = WeightChoice::Given;
  options.mu = 1e-6;
  options.step = Length{step, Length::Kind::Relative};
  std::vector<double> followed, moved;
  for (auto _ : state) {
    ScanNetwork network = scan.solve(options);
    SurfaceSolver surface(network.network);
    state.counters["samples"] = network.samples.n_samples();
    state.counters["triangles"] = static_cast<double>(surface.result().mesh.triangles.rows());
    for (int i = 0; i < 21; ++i) {
      options.mu *= 1.1;
      const double follow = milliseconds([&] { network = scan.follow(options); });
      const double move =
          milliseconds([&] { surface.move(network.network.positions, network.network.normals); });
      if (i == 0) continue;  // makes the factors
      followed.push_back(follow);
      moved.push_back(move);
    }
  }
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
  };
  state.counters["follow_ms"] = median(followed);
  state.counters["move_ms"] = median(moved);
  state.counters["step_ms"] = median(followed) + median(moved);
}

#define SIZES ->Arg(10000)->Arg(100000)->Arg(1000000)->Unit(benchmark::kMillisecond)
BENCHMARK(BM_WholeSurface) SIZES;
BENCHMARK(BM_FactoriseAndSolve) SIZES;
BENCHMARK(BM_BackSubstitution) SIZES;
BENCHMARK(BM_BackSubstitutionInTurn) SIZES;
BENCHMARK(BM_Resolve) SIZES;
// Edges per side that give some 15,000, 50,000 and 60,000 triangles.
// Steps in parts of 10,000 of the size.
BENCHMARK(BM_SliderToSurface)->Arg(155)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Moves)->Arg(8)->Arg(15)->Arg(16)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
