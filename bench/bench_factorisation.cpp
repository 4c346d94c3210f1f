// Eigen against CHOLMOD on the bi-Laplacian of a wavy sheet with fixed lines: factorise, solve three columns.
#include "operators/sample_meshes.hpp"

#include <benchmark/benchmark.h>

#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

struct Sheet {
  SparseMatrix lower;
};
Sheet sheet(int n) {
  const TriangleMesh mesh = samples::mapped_grid(
      n, n, false, false,
      [](double u, double v) { return Eigen::Vector3d(u, v, 0.1 * std::sin(6 * u) * std::cos(5 * v)); }, 0.4);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const Eigen::VectorXd inverse = lumped_mass(mesh.positions, mesh.triangles).cwiseInverse();
  std::vector<int> unknown(static_cast<std::size_t>(n) * n, -1), known(unknown);
  int u = 0, k = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const bool fixed = i == 0 || j == 0 || i == n - 1 || j == n - 1 || i == n / 2 || j == n / 2;
      (fixed ? known : unknown)[static_cast<std::size_t>(i) * n + j] = fixed ? k++ : u++;
    }
  return {squared_stiffness(K, inverse, unknown, known).lower};
}

void factorise(benchmark::State& state, CholeskyBackend backend) {
  const Sheet system = sheet(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    SparseCholesky factor("benchmark", backend);
    factor.factorize(system.lower);
    benchmark::DoNotOptimize(factor.unknowns());
  }
  state.counters["unknowns"] = static_cast<double>(system.lower.rows());
}
void solve(benchmark::State& state, CholeskyBackend backend) {
  const Sheet system = sheet(static_cast<int>(state.range(0)));
  SparseCholesky factor("benchmark", backend);
  factor.factorize(system.lower);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Ones(system.lower.rows(), 3);
  for (auto _ : state) benchmark::DoNotOptimize(factor.solve(right));
  state.counters["unknowns"] = static_cast<double>(system.lower.rows());
}

BENCHMARK_CAPTURE(factorise, eigen, CholeskyBackend::Eigen)
    ->Arg(100)
    ->Arg(316)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(factorise, cholmod, CholeskyBackend::Cholmod)
    ->Arg(100)
    ->Arg(316)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, eigen, CholeskyBackend::Eigen)->Arg(100)->Arg(316)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, cholmod, CholeskyBackend::Cholmod)
    ->Arg(100)
    ->Arg(316)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
