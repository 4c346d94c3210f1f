// One regression with given weights at three sizes, with its stages, and Ceres on the same energy beside it.
// Then the stages before it, check and pre-filter, and the joint estimate. See docs/performance.md.
#include "memory.hpp"
#include "scan_networks.hpp"

#include <algorithm>
#include <array>
#include <ctime>

#include <benchmark/benchmark.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/scan/convention.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/scan/regression.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

#ifdef BATTEN_BENCH_CERES
#include <ceres/ceres.h>
#endif

namespace batten {
namespace {

using samples::Growth;

/// Processor time of some work, of all its threads.
template <typename Work>
double seconds_of(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Weights that smooth as much at every resolution: half power at wavelengths of 0.06 and 0.3, of 2.
RegressionOptions given_weights(const SampledScan& scan) {
  RegressionOptions options;
  options.energy = RegressionEnergy::Thesis;
  const double h = scan.length() / static_cast<double>(scan.n_samples());
  options.lambda = 1e-4 / h;
  options.mu = 5.2e-6 / h;
  return options;
}

void report(benchmark::State& state, const SampledScan& scan) {
  state.counters["samples"] = scan.n_samples();
  state.counters["peak_MB"] = peak_megabytes();
}

void regression(benchmark::State& state, Growth growth) {
  const SampledScan scan = samples::grid_of(state.range(0), growth);
  const RegressionOptions options = given_weights(scan);
  RegressionReport result;
  for (auto _ : state) benchmark::DoNotOptimize(regress_frames(scan, options, &result));
  report(state, scan);
  state.counters["iterations"] = result.iterations;
  state.counters["energy"] = result.energy;
  for (const auto& [stage, seconds] : result.times.stages()) state.counters[stage + "_s"] = seconds;
}

#ifdef BATTEN_BENCH_CERES
using Vector4 = Eigen::Vector4d;
using Derivative = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
Eigen::Map<const Vector4> quaternion(const double* x) {
  return Eigen::Map<const Vector4>(x);
}
Eigen::Map<Eigen::Vector3d> residual(double* r) {
  return Eigen::Map<Eigen::Vector3d>(r);
}
Eigen::Map<Derivative> derivative(double* J) {
  return Eigen::Map<Derivative>(J);
}

/// The vector and scalar part of conj(a) b, quaternions as x, y, z, w, and their derivatives: both are
/// bilinear.
struct Relative {
  Eigen::Vector3d v;
  double w;
  Derivative v_by_a, v_by_b;
  Relative(const Eigen::Map<const Vector4>& a, const Eigen::Map<const Vector4>& b) {
    const Eigen::Vector3d av = a.head<3>(), bv = b.head<3>();
    v = a[3] * bv - b[3] * av - av.cross(bv);
    w = a.dot(b);
    v_by_a << hat(bv) - b[3] * Eigen::Matrix3d::Identity(), bv;
    v_by_b << a[3] * Eigen::Matrix3d::Identity() - hat(av), -av;
  }
};

/// √weight (X − A) as the three numbers √8 v of the regression, A given.
class DataCost : public ceres::SizedCostFunction<3, 4> {
 public:
  DataCost(const Vector4& A, double weight) : A_(A), factor_(std::sqrt(8 * weight)) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Relative p(quaternion(x[0]), quaternion(A_.data()));
    const double f = p.w < 0 ? -factor_ : factor_;
    residual(r) = f * p.v;
    if (J != nullptr && J[0] != nullptr) derivative(J[0]) = f * p.v_by_a;
    return true;
  }

 private:
  Vector4 A_;
  double factor_;
};

class StretchCost : public ceres::SizedCostFunction<3, 4, 4> {
 public:
  explicit StretchCost(double weight) : factor_(std::sqrt(8 * weight)) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Relative p(quaternion(x[0]), quaternion(x[1]));
    const double f = p.w < 0 ? -factor_ : factor_;
    residual(r) = f * p.v;
    if (J == nullptr) return true;
    if (J[0] != nullptr) derivative(J[0]) = f * p.v_by_a;
    if (J[1] != nullptr) derivative(J[1]) = f * p.v_by_b;
    return true;
  }

 private:
  double factor_;
};

/// √weight (skew(XᵀX₊)/h₊ + skew(XᵀX₋)/h₋), frames in the order before, at, after.
class BendCost : public ceres::SizedCostFunction<3, 4, 4, 4> {
 public:
  BendCost(double weight, double before, double after)
      : before_(2 * std::sqrt(weight) / before), after_(2 * std::sqrt(weight) / after) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const auto last = quaternion(x[0]), here = quaternion(x[1]), next = quaternion(x[2]);
    const Relative b(here, last), a(here, next);
    residual(r) = before_ * b.w * b.v + after_ * a.w * a.v;
    if (J == nullptr) return true;
    if (J[0] != nullptr) derivative(J[0]) = before_ * (b.w * b.v_by_b + b.v * here.transpose());
    if (J[1] != nullptr)
      derivative(J[1]) = before_ * (b.w * b.v_by_a + b.v * last.transpose()) +
                         after_ * (a.w * a.v_by_a + a.v * next.transpose());
    if (J[2] != nullptr) derivative(J[2]) = after_ * (a.w * a.v_by_b + a.v * here.transpose());
    return true;
  }

 private:
  double before_, after_;
};

/// √weight (X e₂ − Y e₂).
class NormalCost : public ceres::SizedCostFunction<3, 4, 4> {
 public:
  explicit NormalCost(double weight) : factor_(std::sqrt(weight)) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    residual(r) = factor_ * (normal(x[0]) - normal(x[1]));
    if (J == nullptr) return true;
    if (J[0] != nullptr) derivative(J[0]) = factor_ * normal_derivative(x[0]);
    if (J[1] != nullptr) derivative(J[1]) = -factor_ * normal_derivative(x[1]);
    return true;
  }

 private:
  static Eigen::Vector3d normal(const double* q) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return {2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)};
  }
  static Derivative normal_derivative(const double* q) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    Derivative D;
    D << y, x, -w, -z, -x, y, -z, w, w, z, y, x;
    return 2 * D;
  }
  double factor_;
};

/// The energy S (3.30) of open curves over the quaternions `q`, for Ceres.
void add_energy(const SampledScan& scan, const RegressionOptions& options, std::vector<Vector4>& q,
                ceres::Problem& problem) {
  const FrameNumbering numbering = number_frames(scan);
  q.resize(numbering.n_frames);
  auto* manifold = new ceres::EigenQuaternionManifold;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const auto frame = [&](int k) { return q[numbering.frames[c][k]].data(); };
    for (int k = 0; k < curve.n_samples(); ++k) {
      const Vector4 A = Eigen::Quaterniond(curve.frames[k]).coeffs();
      q[numbering.frames[c][k]] = A;
      problem.AddParameterBlock(frame(k), 4, manifold);
      problem.AddResidualBlock(new DataCost(A, 1), nullptr, frame(k));
    }
    for (int k = 0; k + 1 < curve.n_samples(); ++k)
      problem.AddResidualBlock(new StretchCost(options.lambda / curve.step(k)), nullptr, frame(k),
                               frame(k + 1));
    for (int k = 1; k + 1 < curve.n_samples(); ++k) {
      const double before = curve.step(k - 1), after = curve.step(k);
      // ‖a^‖²_F = 2‖a‖², and the factor 2/(h₋ + h₊) of the trapezoidal rule
      problem.AddResidualBlock(new BendCost(4 * options.mu / (before + after), before, after), nullptr,
                               frame(k - 1), frame(k), frame(k + 1));
    }
  }
  for (const auto& [a, b] : numbering.node_pairs)
    problem.AddResidualBlock(new NormalCost(options.xi), nullptr, q[a].data(), q[b].data());
}

/// Ceres::Solve alone; what sets the problem up is not counted.
void ceres_regression(benchmark::State& state) {
  const SampledScan scan = samples::grid_of(state.range(0), Growth::Network);
  const RegressionOptions options = given_weights(scan);
  std::vector<Vector4> q;
  ceres::Problem problem;
  add_energy(scan, options, q, problem);
  const std::vector<Vector4> start = q;
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.num_threads = 1;
  solver.max_num_iterations = 100;
  // Our solver stops at turns of 1e-10 radians; this stops Ceres no later.
  solver.function_tolerance = 1e-10;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  for (auto _ : state) {
    state.PauseTiming();
    std::copy(start.begin(), start.end(), q.begin());
    state.ResumeTiming();
    ceres::Solve(solver, &problem, &summary);
  }
  report(state, scan);
  state.counters["iterations"] = static_cast<double>(summary.iterations.size()) - 1;
  state.counters["energy"] = 2 * summary.final_cost;  // Ceres halves the squares
}
BENCHMARK(ceres_regression)->Arg(1500)->Arg(15000)->Unit(benchmark::kMillisecond);
#endif

#define SIZES ->Arg(1500)->Arg(15000)->Arg(150000)->Unit(benchmark::kMillisecond)
BENCHMARK_CAPTURE(regression, larger_network, Growth::Network) SIZES;
BENCHMARK_CAPTURE(regression, denser_samples, Growth::Sampling) SIZES;

/// The samples as the readings of a scan.
Scan readings_of(const SampledScan& samples) {
  Scan scan;
  scan.tangents = TangentConvention::AtSample;
  for (const SampledCurve& curve : samples.curves) {
    ScanCurve out;
    out.node_readings = curve.node_samples;
    out.node_ids = curve.node_ids;
    out.distances = curve.parameters;
    out.tangents.resize(curve.n_samples(), 3);
    out.normals.resize(curve.n_samples(), 3);
    for (int k = 0; k < curve.n_samples(); ++k) {
      out.tangents.row(k) = curve.frames[k].col(0).transpose();
      out.normals.row(k) = curve.frames[k].col(1).transpose();
    }
    scan.curves.push_back(std::move(out));
  }
  return scan;
}

void check(benchmark::State& state, Growth growth) {
  const SampledScan samples = samples::grid_of(state.range(0), growth);
  const Scan scan = readings_of(samples);
  for (auto _ : state) check_scan(scan);
  report(state, samples);
}

/// Cleaning, noise, and samples at three readings each.
void prefilter(benchmark::State& state, Growth growth) {
  const SampledScan samples = samples::grid_of(state.range(0), growth);
  const Scan scan = readings_of(samples);
  PrefilterOptions options;
  options.step = 3 * samples.length() / samples.n_samples();
  std::vector<std::string> warnings;
  for (auto _ : state) {
    const std::vector<CleanCurve> clean = clean_readings(scan, {}, warnings);
    benchmark::DoNotOptimize(reading_noise(clean));
    benchmark::DoNotOptimize(resample(scan, clean, options));
  }
  report(state, samples);
}

#define READINGS ->Arg(10000)->Arg(100000)->Arg(1000000)->Unit(benchmark::kMillisecond)
BENCHMARK_CAPTURE(check, larger_network, Growth::Network) READINGS;
BENCHMARK_CAPTURE(check, denser_samples, Growth::Sampling) READINGS;
BENCHMARK_CAPTURE(prefilter, larger_network, Growth::Network) READINGS;
BENCHMARK_CAPTURE(prefilter, denser_samples, Growth::Sampling) READINGS;

/// The joint estimate with a known noise model: what every model that the search tries costs, and its memory.
void joint(benchmark::State& state) {
  const SampledScan scan = samples::grid_of(state.range(0), Growth::Sampling);
  JointOptions options;
  options.size = 2.8;
  options.reading_noise = 0.02;
  options.noise = NoiseModel{0.02, 0.01, 0.2, 0.003, 100, 10, 1e4};
  JointEstimate estimate;
  for (auto _ : state) estimate = estimate_jointly(scan, options);
  report(state, scan);
  state.counters["evaluations"] = estimate.evaluations;
}
BENCHMARK(joint)->Arg(1500)->Arg(15000)->Arg(150000)->Iterations(1)->Unit(benchmark::kMillisecond);

/// A network with automatic weights beside one with the weights given that they come to, from reading
/// cleaning to positions, in one run; one torus, read ever more densely.
void automatic(benchmark::State& state) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Torus);
  SimulateOptions device;
  device.seed = 1;
  device.orientation_noise = radians(2);
  device.drift = radians(1);
  device.odometer_error = 0.003;
  // 1,182 samples at 1.6 %, and some two readings for each.
  const double step = 0.016 * 1182 / static_cast<double>(state.range(0));
  device.step = step / 2.7;
  const Scan scan = simulate_scan(traced, device).scan;
  ScanOptions options;
  options.step = Length{step, Length::Kind::Relative};
  ScanOptions given = options;
  given.weights = WeightChoice::Given;
  ScanNetwork network;
  double automatic_seconds = 0, given_seconds = 0;
  for (auto _ : state) {
    automatic_seconds += seconds_of([&] { network = network_from_scan(scan, options); });
    given.lambda = network.report.lambda;
    given.mu = network.report.mu;
    given_seconds += seconds_of([&] { benchmark::DoNotOptimize(network_from_scan(scan, given)); });
  }
  report(state, network.samples);
  state.counters["automatic_s"] = automatic_seconds / static_cast<double>(state.iterations());
  state.counters["of_given"] = automatic_seconds / given_seconds;
  state.counters["steps"] = network.report.iterations;
}
BENCHMARK(automatic)->Arg(1500)->Arg(16000)->Arg(160000)->Iterations(1)->Unit(benchmark::kMillisecond);

/// The same on a sheet of crossing curves, whose factors fill; at its own samples.
void automatic_on_sheet(benchmark::State& state) {
  const SampledScan samples = samples::grid_of(state.range(0), Growth::Network);
  const Scan scan = readings_of(samples);
  ScanOptions options;
  options.step.reset();
  ScanOptions given = options;
  given.weights = WeightChoice::Given;
  double automatic_seconds = 0, given_seconds = 0;
  for (auto _ : state) {
    ScanNetwork network;
    automatic_seconds += seconds_of([&] { network = network_from_scan(scan, options); });
    given.lambda = network.report.lambda;
    given.mu = network.report.mu;
    given_seconds += seconds_of([&] { benchmark::DoNotOptimize(network_from_scan(scan, given)); });
  }
  report(state, samples);
  state.counters["automatic_s"] = automatic_seconds / static_cast<double>(state.iterations());
  state.counters["of_given"] = automatic_seconds / given_seconds;
}
BENCHMARK(automatic_on_sheet)->Arg(1500)->Arg(15000)->Iterations(1)->Unit(benchmark::kMillisecond);

/// A regression with the weights of the thesis (λ = 1, μ = 100 in the unit of the scan, energy as printed) at
/// the sizes of S table 3.9, with the robust loss and without, beside the time that is printed there, of a
/// quad-core processor of 2017. Table: 0 lilium, as exported; 1 a cone, simulated.
void thesis_table(benchmark::State& state) {
  const bool cone = state.range(0) == 1;
  Scan scan;
  if (cone) {
    SimulateOptions device;
    device.seed = 1;
    device.orientation_noise = radians(2);
    device.drift = radians(1);
    scan = simulate_scan(trace_shape(AnalyticShape::Cone), device).scan;
  } else {
    try {
      scan = frames_at_samples(read_rawnet(BATTEN_SHARED_DATA "/curves/lilium.rawnet"));
    } catch (const Error&) {
      return state.SkipWithError("no public data");
    }
  }
  std::vector<std::string> warnings;
  const std::vector<CleanCurve> clean = clean_readings(scan, {}, warnings);
  PrefilterOptions prefilter;
  prefilter.step = resample(scan, clean, {}).length() / static_cast<double>(state.range(1));
  const SampledScan samples = resample(scan, clean, prefilter);
  RegressionOptions options;
  options.energy = RegressionEnergy::Thesis;
  options.lambda = 1;
  options.mu = 100;
  RegressionReport result;
  std::array<double, 2> least{1e300, 1e300};
  for (auto _ : state)
    for (int round = 0; round < 5; ++round)
      for (const bool robust : {false, true}) {
        options.robust = robust;
        least[robust ? 1 : 0] = std::min(
            least[robust ? 1 : 0],
            seconds_of([&] { benchmark::DoNotOptimize(regress_frames(samples, options, &result)); }));
        state.counters[robust ? "robust_steps" : "steps"] = result.iterations;
      }
  report(state, samples);
  state.counters["ms"] = 1e3 * least[0];
  state.counters["robust_ms"] = 1e3 * least[1];
  state.counters["of_printed"] = 1e3 * least[0] / static_cast<double>(state.range(2));
  state.counters["robust_of_printed"] = 1e3 * least[1] / static_cast<double>(state.range(2));
}
BENCHMARK(thesis_table)
    ->Args({0, 96, 51})
    ->Args({0, 196, 113})
    ->Args({0, 382, 234})
    ->Args({0, 742, 439})
    ->Args({0, 1416, 788})
    ->Args({1, 205, 176})
    ->Args({1, 398, 328})
    ->Args({1, 783, 618})
    ->Args({1, 1553, 1169})
    ->Args({1, 3094, 2779})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

/// Lilium, as exported, at 1,453 samples: whole networks with automatic and with given weights.
void lilium(benchmark::State& state) {
  Scan scan;
  try {
    scan = read_rawnet(BATTEN_SHARED_DATA "/curves/lilium.rawnet");
  } catch (const Error&) {
    return state.SkipWithError("no public data");
  }
  ScanOptions options;
  double length = 0;
  for (const ScanCurve& curve : scan.curves) length += curve.distances[curve.n_readings() - 1];
  options.step = Length{length / static_cast<double>(state.range(0)), Length::Kind::Plain};
  ScanOptions given = options;
  given.weights = WeightChoice::Given;
  double automatic_seconds = 1e300, given_seconds = 1e300;
  ScanNetwork network;
  for (auto _ : state)
    for (int round = 0; round < 5; ++round) {
      automatic_seconds =
          std::min(automatic_seconds, seconds_of([&] { network = network_from_scan(scan, options); }));
      given.lambda = network.report.lambda;
      given.mu = network.report.mu;
      given_seconds = std::min(given_seconds,
                               seconds_of([&] { benchmark::DoNotOptimize(network_from_scan(scan, given)); }));
    }
  report(state, network.samples);
  state.counters["automatic_ms"] = 1e3 * automatic_seconds;
  state.counters["given_ms"] = 1e3 * given_seconds;
  state.counters["of_given"] = automatic_seconds / given_seconds;
}
BENCHMARK(lilium)->Arg(1453)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Twenty positions of a slider for μ, followed by a kept solver, beside one cold regression and one network
/// from nothing at its first position, all robust. Medians, so that a disturbed step does not count.
void slider(benchmark::State& state) {
  constexpr int kPositions = 20;
  const SampledScan samples = samples::grid_of(state.range(0), Growth::Network);
  const Scan scan = readings_of(samples);
  ScanOptions options;
  options.step.reset();
  options.weights = WeightChoice::Given;
  options.mu = 1e-6;
  RegressionOptions regression;
  regression.mu = options.mu;
  regression.unit = 2.8;  // about the size
  regression.robust = true;
  const auto median_of = [](std::vector<double> seconds) {
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    return seconds[seconds.size() / 2];
  };
  std::vector<double> steps, regressions, networks;
  for (auto _ : state) {
    ReconstructionSolver solver(scan);
    solver.solve(options);
    ScanOptions moved = options;
    for (int i = 0; i < kPositions; ++i) {
      moved.mu *= 1.1;
      steps.push_back(seconds_of([&] { benchmark::DoNotOptimize(solver.follow(moved)); }));
      if (i % 4 != 0) continue;
      regressions.push_back(
          seconds_of([&] { benchmark::DoNotOptimize(regress_frames(samples, regression)); }));
      networks.push_back(seconds_of([&] { benchmark::DoNotOptimize(network_from_scan(scan, options)); }));
    }
  }
  report(state, samples);
  state.counters["step_ms"] = 1e3 * median_of(steps);
  state.counters["of_a_cold_regression"] = median_of(steps) / median_of(regressions);
  state.counters["of_a_cold_network"] = median_of(steps) / median_of(networks);
}
BENCHMARK(slider)->Arg(1500)->Iterations(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
