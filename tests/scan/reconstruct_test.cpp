#include "batten/scan/reconstruct.hpp"

#include "sanitizers.hpp"
#include "scan/scan_fixtures.hpp"
#include "threads.hpp"

#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

Length relative(double value) {
  return {value, Length::Kind::Relative};
}

TEST(NetworkFromScan, IsExactOnCirclesWithoutNoise) {
  // A constant rate of turn is integrated exactly; 1e-4 is the acceptance limit of the project.
  SimulateOptions device;
  device.step = 0.004;
  for (const AnalyticShape shape : {AnalyticShape::Sphere, AnalyticShape::Cone}) {
    const TracedNetwork traced = trace_shape(shape);
    EXPECT_LT(test::network_error(traced, network_from_scan(simulate_scan(traced, device).scan)), 1e-4);
  }
}

TEST(NetworkFromScan, ConvergesWithFourthOrderAndTheThesisSchemeWithFirst) {
  SimulateOptions device;
  device.step = 0.002;
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  const Scan scan = simulate_scan(traced, device).scan;
  ScanOptions options;
  const auto order = [&] {
    options.step = relative(0.064);
    const double coarse = test::network_error(traced, network_from_scan(scan, options));
    options.step = relative(0.016);
    return std::log2(coarse / test::network_error(traced, network_from_scan(scan, options))) / 2;
  };
  EXPECT_GT(order(), 3.1);  // third order at the ends of curves
  options.scheme = IntegrationScheme::Thesis;
  const double first = order();
  EXPECT_GT(first, 0.7);
  EXPECT_LT(first, 1.4);
}

TEST(NetworkFromScan, BeatsTheAcceptanceLimitOnNoisyScans) {
  // Required: geometric mean over nine shapes and three seeds 0.130 %; here three shapes of one seed.
  double product = 1;
  for (const AnalyticShape shape : {AnalyticShape::Sphere, AnalyticShape::Dish, AnalyticShape::Waves}) {
    const TracedNetwork traced = trace_shape(shape);
    const ScanNetwork result = network_from_scan(simulate_scan(traced, test::noisy_device(11)).scan);
    product *= test::network_error(traced, result);
    EXPECT_TRUE(result.report.noise.has_value());
  }
  EXPECT_LT(std::cbrt(product), 0.0013);
}

TEST(NetworkFromScan, OutliersHardlyMatter) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Waves);
  SimulateOptions device = test::noisy_device(4);
  const double without = test::network_error(traced, network_from_scan(simulate_scan(traced, device).scan));
  device.outliers = 0.05;
  const double with = test::network_error(traced, network_from_scan(simulate_scan(traced, device).scan));
  EXPECT_LT(with, 1.3 * without);
}

TEST(NetworkFromScan, FindsTheFactorsOfEstimatedLengths) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Sphere);
  SimulateOptions device = test::noisy_device(5);
  device.curve_length_error = 0.15;
  const SimulatedScan scan = simulate_scan(traced, device);
  ScanOptions options;
  options.lengths = LengthChoice::Estimated;
  const ScanNetwork result = network_from_scan(scan.scan, options);
  EXPECT_LT(test::network_error(traced, result, true), 0.005);
  EXPECT_TRUE(result.report.undetermined.empty());
  // Factors times the simulated ones are equal for all curves, up to the noise.
  const double first = result.report.factors[0] * scan.report.distance_factors[0];
  for (size_t c = 1; c < result.report.factors.size(); ++c)
    EXPECT_NEAR(result.report.factors[c] * scan.report.distance_factors[c] / first, 1, 0.02);
}

/// The mean of the speed spreads of a scan of the dish in the time that an uneven hand takes, and the error.
std::pair<double, double> timed_dish(double variation, LengthChoice lengths) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  SimulateOptions device;
  device.seed = 3;
  device.step = 0.012;
  device.orientation_noise = radians(0.5);
  device.speed_variation = variation;
  ScanOptions options;
  options.step = relative(0.04);
  options.lengths = lengths;
  const ScanNetwork result = network_from_scan(simulate_scan(traced, device).scan, options);
  EXPECT_EQ(result.report.warnings.empty(), variation == 0 || lengths == LengthChoice::Measured);
  double spread = 0;
  for (const double s : result.report.speed_spread) spread += s / static_cast<double>(traced.curves.size());
  return {spread, test::network_error(traced, result)};
}

// Before the speed could change along a curve, 1.8 % were left of 20 %, measured or estimated.
TEST(NetworkFromScan, FollowsAHandWhoseSpeedIsUneven) {
  const auto [none, as_measured] = timed_dish(0.2, LengthChoice::Measured);
  const auto [spread, error] = timed_dish(0.2, LengthChoice::Estimated);
  EXPECT_LT(none, 1e-6);
  EXPECT_GT(as_measured, 0.01);
  EXPECT_LT(error, 0.3 * as_measured);
  EXPECT_GT(spread, 0.05);
  EXPECT_LT(spread, 0.2);
}

TEST(NetworkFromScan, EstimatedLengthsCostNothingWhereTheMeasuredAreRight) {
  const auto [none, as_measured] = timed_dish(0, LengthChoice::Measured);
  const auto [spread, error] = timed_dish(0, LengthChoice::Estimated);
  EXPECT_LT(error, 1.2 * as_measured);
  EXPECT_LT(spread, 0.01);
}

TEST(NetworkFromScan, DoesNotDependOnOrderUnitOrientationAndDirection) {
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), test::noisy_device(6)).scan;
  const ScanNetwork reference = network_from_scan(scan);
  const double size = reference.report.size;
  const auto points = [](const ScanNetwork& n, int curve, bool reversed) {
    std::vector<int> vertices = n.network.curves[curve].vertices;
    if (reversed) std::reverse(vertices.begin(), vertices.end());
    Points rows(static_cast<Eigen::Index>(vertices.size()), 3);
    for (size_t k = 0; k < vertices.size(); ++k) rows.row(k) = n.network.positions.row(vertices[k]);
    return rows;
  };
  const int n = static_cast<int>(scan.curves.size());

  Scan permuted = scan;
  std::reverse(permuted.curves.begin(), permuted.curves.end());
  const ScanNetwork by_order = network_from_scan(permuted);
  for (int c = 0; c < n; ++c)
    EXPECT_LT((points(by_order, n - 1 - c, false) - points(reference, c, false)).norm(), 1e-8 * size);

  for (const double factor : {1e-3, 1e3}) {
    Scan scaled = scan;
    for (ScanCurve& curve : scaled.curves) curve.distances *= factor;
    const ScanNetwork result = network_from_scan(scaled);
    for (int c = 0; c < n; ++c)
      EXPECT_LT((points(result, c, false) / factor - points(reference, c, false)).norm(), 1e-8 * size);
  }

  Scan turned = scan;
  const Eigen::Matrix3d R = so3_exp({0.5, -1, 2});
  for (ScanCurve& curve : turned.curves) curve.tangents *= R.transpose(), curve.normals *= R.transpose();
  const ScanNetwork rotated = network_from_scan(turned);
  for (int c = 0; c < n; ++c)
    EXPECT_LT((points(rotated, c, false) - points(reference, c, false) * R.transpose()).norm(), 1e-8 * size);

  Scan mirrored = scan;
  const Eigen::Matrix3d M = Eigen::Vector3d(1, 1, -1).asDiagonal();
  for (ScanCurve& curve : mirrored.curves) curve.tangents *= M, curve.normals *= M;
  const ScanNetwork mirror = network_from_scan(mirrored);
  for (int c = 0; c < n; ++c)
    EXPECT_LT((points(mirror, c, false) - points(reference, c, false) * M).norm(), 1e-8 * size);

  Scan backwards = scan;
  for (ScanCurve& curve : backwards.curves) {
    const double length = curve.distances[curve.n_readings() - 1];
    curve.distances = (length - curve.distances.array()).reverse().eval();
    curve.tangents = (-curve.tangents.colwise().reverse()).eval();
    curve.normals = curve.normals.colwise().reverse().eval();
    for (int& reading : curve.node_readings) reading = static_cast<int>(curve.n_readings()) - 1 - reading;
    std::reverse(curve.node_readings.begin(), curve.node_readings.end());
    std::reverse(curve.node_ids.begin(), curve.node_ids.end());
  }
  const ScanNetwork reversed = network_from_scan(backwards);
  for (int c = 0; c < n; ++c)
    EXPECT_LT((points(reversed, c, true) - points(reference, c, false)).norm(), 1e-8 * size);
}

/// Options drawn like the positions of sliders: a coarse scan, so that many can be tried.
ScanOptions drawn_options(Random& random) {
  ScanOptions options;
  options.weights = WeightChoice::Given;
  options.energy = random.below(2) == 0 ? RegressionEnergy::Thesis : RegressionEnergy::Scaled;
  options.lambda = std::pow(10, 4 * random.uniform() - 6);
  options.mu = std::pow(10, 4 * random.uniform() - 8);
  options.sigma = 0.2 + 0.2 * static_cast<double>(random.below(3));
  options.step = relative(0.05 + 0.01 * static_cast<double>(random.below(3)));
  options.robust = random.below(2) == 0;
  return options;
}

/// The greatest distance between vertices of two networks of one scan, in sizes.
double difference(const ScanNetwork& a, const ScanNetwork& b) {
  if (a.network.positions.rows() != b.network.positions.rows()) return 1;
  return (a.network.positions - b.network.positions).rowwise().norm().maxCoeff() / a.report.size;
}

TEST(ReconstructionSolver, GivesWhatAFreshOneGivesAfterAThousandChanges) {
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Torus), test::noisy_device(1)).scan;
  ReconstructionSolver kept(scan);
  Random random(5);
  constexpr int kChanges = test::repeated(1000, 50);
  for (int i = 1; i <= kChanges; ++i) {
    const ScanOptions options = drawn_options(random);
    kept.follow(options);
    if (i % (kChanges / 5) != 0) continue;
    EXPECT_LT(difference(kept.solve(options), network_from_scan(scan, options)), 1e-9);
  }
}

TEST(ReconstructionSolver, FollowsASliderCloselyWithFewSteps) {
  // Newton's steps square the error: a slider that multiplies μ by 1.25 at a time is followed within 0.1 % of
  // the size, a third of what the network is wrong by.
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Dish), test::noisy_device(1)).scan;
  ReconstructionSolver kept(scan);
  ScanOptions options;
  options.weights = WeightChoice::Given;
  options.mu = 1e-6;
  kept.solve(options);
  for (int i = 0; i < 20; ++i) {
    options.mu *= 1.25;
    const ScanNetwork moving = kept.follow(options);
    EXPECT_LE(moving.report.iterations, 2);
    EXPECT_LT(difference(moving, network_from_scan(scan, options)), 1e-3);
  }
}

TEST(NetworkFromScan, RefusesBadOptions) {
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), {}).scan;
  ScanOptions options;
  options.step = relative(-1);
  EXPECT_THROW(network_from_scan(scan, options), InvalidInput);
  options = {};
  options.lengths = LengthChoice::Estimated;
  options.weights = WeightChoice::Thesis;
  EXPECT_THROW(network_from_scan(scan, options), InvalidInput);
}

TEST(NetworkFromScan, CanBeCancelledAtEveryReport) {
  const test::Threads one(1);  // the same reports every time
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), test::noisy_device(6)).scan;
  for (const WeightChoice weights : {WeightChoice::Auto, WeightChoice::Given}) {
    ScanOptions options;
    options.weights = weights;
    options.mu = 1e-5;
    long reports = 0;
    std::set<std::string> stages;
    const Progress count([&](std::string_view stage, double fraction) {
      stages.emplace(stage);
      EXPECT_TRUE(fraction >= 0 && fraction <= 1) << stage << " " << fraction;
      return ++reports > 0;
    });
    network_from_scan(scan, options, count);
    EXPECT_EQ(stages.count("prefilter") + stages.count("regression") + stages.count("integration"), 3U);
    const long all = reports;
    for (const long at : {1L, all / 7, all / 3, all / 2, all - 1}) {
      reports = 0;
      const Progress stop([&](std::string_view, double) { return ++reports < at; });
      EXPECT_THROW(network_from_scan(scan, options, stop), Cancelled) << at << " of " << all;
      EXPECT_EQ(reports, at);
    }
  }
}

/// The sections x, y, z = 0 of the ellipsoid with half-axes 1, 1 and `height`: where it is flat, two of them
/// turn by 180° within a few samples.
TracedNetwork flat_ellipsoid(double height) {
  const Eigen::Vector3d axes(1, 1, height);
  TracedNetwork traced;
  traced.diameter = 2 * axes.norm();
  for (int a = 0; a < 3; ++a) {
    TraceRequest request;
    request.surface = [axes](const Eigen::Vector3d& x, Eigen::Vector3d& gradient) {
      gradient = 2 * x.array() / axes.array().square();
      return (x.array() / axes.array()).square().sum() - 1;
    };
    request.cut = [a](const Eigen::Vector3d& x, Eigen::Vector3d& gradient) {
      gradient = Eigen::Vector3d::Unit(a);
      return x[a];
    };
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    request.start = axes[b] * Eigen::Vector3d::Unit(b);
    request.towards = Eigen::Vector3d::Unit(c);
    request.step = 0.002;
    TracedCurve curve;
    curve.closed = true;
    curve.path = trace_intersection(request);
    for (int i = 0; i <= 4; ++i) {  // quarters, at the ends of the axes
      curve.node_distances.push_back(curve.path->length() * i / 4);
      curve.node_ids.push_back(2 * (i % 2 == 0 ? b : c) + i % 4 / 2);
    }
    traced.curves.push_back(std::move(curve));
  }
  return traced;
}

// 0.020 % is required of exact data; here the tightest radius is 1.4 steps, and the steps there are halved.
// Before shape was told from disturbance the errors were 0.03, 0.45, 0.74 and 0.32 % with most of two
// curves ignored.
TEST(NetworkFromScan, TakesTightTurnsForShapeAndImprovesWithTheNoise) {
  const TracedNetwork traced = flat_ellipsoid(0.3);
  double last = 0;
  for (const double noise : {0.0, 0.5, 1.0, 2.0}) {
    if (test::kSanitized && noise != 1) continue;
    SimulateOptions device;
    device.seed = 1;
    device.orientation_noise = radians(noise);
    device.drift = radians(0.5 * noise);
    device.odometer_error = 0.0015 * noise;
    const ScanNetwork result = network_from_scan(simulate_scan(traced, device).scan);
    const double error = test::network_error(traced, result);
    EXPECT_GT(error, last) << noise;
    EXPECT_LT(error, 1e-4 + 9e-4 * noise) << noise;
    EXPECT_TRUE(result.report.warnings.empty()) << result.report.warnings.front();
    last = error;
  }
}

// Points 0.8 % apart on the same curves, as a drawing program exports them: chords to the next point.
TEST(NetworkFromScan, TakesDrawnCurvesForExactAtAnyStep) {
  const TracedNetwork traced = flat_ellipsoid(0.3);
  SimulateOptions device;
  device.step = 0.008;
  device.jitter = 0;
  device.dwell = 1;
  SimulatedScan simulated = simulate_scan(traced, device);
  for (size_t c = 0; c < traced.curves.size(); ++c) {
    ScanCurve& curve = simulated.scan.curves[c];
    const auto at = [&](Eigen::Index i) {
      return traced.curves[c].path->at(simulated.true_distances[c][i]).position;
    };
    for (Eigen::Index i = 0; i + 1 < curve.n_readings(); ++i) {
      const Eigen::Vector3d chord = at(i + 1) - at(i);
      curve.tangents.row(i) = chord.normalized().transpose();
      curve.distances[i + 1] = curve.distances[i] + chord.norm();
    }
  }
  simulated.scan.tangents = TangentConvention::ToNext;
  for (const double step : {0.016, 0.008, 0.002}) {
    ScanOptions options;
    options.step = relative(step);
    const ScanNetwork result = network_from_scan(simulated.scan, options);
    // At 1.6 % a step turns by up to 25°: the error is that of the samples.
    EXPECT_LT(test::network_error(traced, result), step > 0.01 ? 4e-4 : 2.2e-4) << step;
    EXPECT_TRUE(result.report.warnings.empty()) << step;
    EXPECT_EQ(result.report.lambda, 0);
  }
}

}  // namespace
}  // namespace batten
