#include "batten/scan/prefilter.hpp"

#include "scan/scan_fixtures.hpp"
#include "threads.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

SimulatedScan sphere(const SimulateOptions& options) {
  return simulate_scan(trace_shape(AnalyticShape::Sphere), options);
}

TEST(Prefilter, FindsAllRandomOutliersAndNoOthers) {
  SimulateOptions options = test::noisy_device(3);
  std::vector<std::string> warnings;
  for (const CleanCurve& curve : clean_readings(sphere(options).scan, {}, warnings))
    EXPECT_EQ(curve.n_outliers, 0);
  options.outliers = 0.05;
  const SimulatedScan scan = sphere(options);
  long removed = 0;
  for (const CleanCurve& curve : clean_readings(scan.scan, {}, warnings)) removed += curve.n_outliers;
  // A random orientation is within a few degrees of the right one in one case of thousands.
  EXPECT_GE(removed, scan.report.n_outliers - 1);
  EXPECT_LE(removed, scan.report.n_outliers + 2);
  EXPECT_TRUE(warnings.empty());
}

TEST(Prefilter, EstimatesTheNoiseOfAReading) {
  // 800 readings: the median's standard error is about 3 %; drift and shape must not count.
  std::vector<std::string> warnings;
  const std::vector<CleanCurve> clean = clean_readings(sphere(test::noisy_device(1)).scan, {}, warnings);
  EXPECT_NEAR(reading_noise(clean), radians(2), radians(0.2));
}

TEST(Prefilter, MakesNodesSamplesAndSharesEveryReading) {
  std::vector<std::string> warnings;
  const Scan scan = sphere(test::noisy_device(1)).scan;
  const std::vector<CleanCurve> clean = clean_readings(scan, {}, warnings);
  PrefilterOptions options;
  options.step = 0.05;
  const SampledScan samples = resample(scan, clean, options);
  for (size_t c = 0; c < samples.curves.size(); ++c) {
    const SampledCurve& curve = samples.curves[c];
    EXPECT_NEAR(curve.weights.sum(), static_cast<double>(scan.curves[c].n_readings()), 1e-9);
    for (size_t j = 0; j < curve.node_samples.size(); ++j)
      EXPECT_DOUBLE_EQ(
          curve.parameters[curve.node_samples[j]],
          scan.curves[c].distances[scan.curves[c].node_readings[j]] - scan.curves[c].distances[0]);
    for (int k = 0; k + 1 < curve.n_samples(); ++k) EXPECT_NEAR(curve.step(k), 0.05, 0.005);
  }
}

TEST(Prefilter, IsExactOnCirclesAlsoAtEndsAndWithFewReadings) {
  // A frame that turns at a constant rate is a straight line in the local fit, wherever the readings lie.
  SimulateOptions device;
  for (const double reading_step : {0.002, 0.05}) {
    device.step = reading_step;
    const TracedNetwork traced = trace_shape(AnalyticShape::Sphere);
    const Scan scan = simulate_scan(traced, device).scan;
    std::vector<std::string> warnings;
    PrefilterOptions options;
    options.step = 0.03;
    options.wrap = false;
    const SampledScan samples = resample(scan, clean_readings(scan, {}, warnings), options);
    for (size_t c = 0; c < samples.curves.size(); ++c)
      for (int k = 0; k < samples.curves[c].n_samples(); ++k) {
        const CurvePoint point = traced.curves[c].path->at(samples.curves[c].parameters[k]);
        EXPECT_LT((samples.curves[c].frames[k] - darboux_frame(point.tangent, point.normal)).norm(), 1e-6);
      }
  }
}

// A reading takes some 35 µs on one thread: a report at least every 500 readings and samples is one every 20
// ms.
TEST(Prefilter, ReportsAsOftenAsThereAreReadingsAndCanBeCancelled) {
  const test::Threads one(1);
  SimulateOptions device = test::noisy_device(5);
  device.step = 0.001;
  const Scan scan = sphere(device).scan;
  long n_readings = 0, reports = 0;
  for (const ScanCurve& curve : scan.curves) n_readings += curve.n_readings();
  std::vector<std::string> warnings;
  const Progress count([&](std::string_view, double) { return ++reports > 0; });
  const std::vector<CleanCurve> clean = clean_readings(scan, {}, warnings, count);
  EXPECT_GE(500 * reports, n_readings);
  PrefilterOptions options;
  options.step = 0.004;
  reports = 0;
  const SampledScan samples = resample(scan, clean, options, count);
  EXPECT_GE(500 * reports, samples.n_samples());
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(clean_readings(scan, {}, warnings, stop), Cancelled);
  EXPECT_THROW(resample(scan, clean, options, stop), Cancelled);
}

}  // namespace
}  // namespace batten
