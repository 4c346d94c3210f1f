#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/scan/calibration.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/regression.hpp"
#include "batten/scan/sensor_log.hpp"

// What is wrong with options is named with field and value, by problem() and by who uses them.

namespace batten {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The options with one field at every value in turn: all are refused, in the same words, by `call`.
template <typename Options, typename Field, typename Value, typename Call>
void expect_option_refused(Field Options::*field, const std::string& name,
                           std::initializer_list<Value> values, const Call& call) {
  for (const Value value : values) {
    Options options;
    options.*field = value;
    const std::string problem = options.problem().value_or("none");
    EXPECT_EQ(problem.find(name + " must "), 0U) << problem;
    EXPECT_NE(problem.find("got "), std::string::npos) << problem;
    try {
      call(options);
      ADD_FAILURE() << name << " = " << value << " was accepted";
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.what(), problem);
    }
  }
}

/// The options with one field at every value in turn: none is refused.
template <typename Options, typename Field, typename Value>
void expect_option_accepted(Field Options::*field, std::initializer_list<Value> values) {
  for (const Value value : values) {
    Options options;
    options.*field = value;
    EXPECT_EQ(options.problem(), std::nullopt) << value;
  }
}

TEST(ScanRoomOptions, OfCleaningAndPrefilter) {
  const auto clean = [](const CleanOptions& options) {
    std::vector<std::string> warnings;
    clean_readings(Scan(), options, warnings);
  };
  expect_option_refused(&CleanOptions::outlier_cosine, "outlier_cosine", {-0.1, 1.1, kNan}, clean);
  expect_option_accepted(&CleanOptions::outlier_cosine, {0.0, 1.0});
  const auto sample = [](const PrefilterOptions& options) { resample(Scan(), {}, options); };
  expect_option_refused(&PrefilterOptions::step, "step", {-1e-9, kInfinite, kNan}, sample);
  expect_option_accepted(&PrefilterOptions::step, {0.0, 3.0});
  expect_option_refused(&PrefilterOptions::sigma, "sigma", {0.0, 2.1, kNan}, sample);
  expect_option_accepted(&PrefilterOptions::sigma, {1e-3, 2.0});
}

TEST(ScanRoomOptions, OfTheRegression) {
  const auto regress = [](const RegressionOptions& options) { regress_frames(SampledScan(), options); };
  const auto energy = [](const RegressionOptions& options) {
    regression_energy(SampledScan(), SampledScan(), options);
  };
  expect_option_refused(&RegressionOptions::lambda, "lambda", {-1.0, kInfinite, kNan}, regress);
  expect_option_refused(&RegressionOptions::lambda, "lambda", {-1.0}, energy);
  expect_option_refused(&RegressionOptions::mu, "mu", {-1.0, kNan}, regress);
  expect_option_refused(&RegressionOptions::xi, "xi", {-1.0, kNan}, regress);
  expect_option_refused(&RegressionOptions::unit, "unit", {0.0, -1.0, kInfinite, kNan}, regress);
  expect_option_refused(&RegressionOptions::max_iterations, "max_iterations", {-1}, regress);
  expect_option_refused(&RegressionOptions::tolerance, "tolerance", {-1e-3, kNan}, regress);
  expect_option_accepted(&RegressionOptions::lambda, {0.0, 1e6});
  expect_option_accepted(&RegressionOptions::tolerance, {0.0});
}

TEST(ScanRoomOptions, OfTheJointEstimate) {
  const auto estimate = [](const JointOptions& options) { estimate_jointly(SampledScan(), options); };
  expect_option_refused(&JointOptions::size, "size", {0.0, -1.0, kInfinite, kNan}, estimate);
  expect_option_refused(&JointOptions::reading_noise, "reading_noise", {-1.0, kNan}, estimate);
  expect_option_refused(&JointOptions::scale_deviation, "scale_deviation", {-1.0, kNan}, estimate);
  expect_option_refused(&JointOptions::xi, "xi", {-1.0, kInfinite}, estimate);
  expect_option_accepted(&JointOptions::reading_noise, {0.0});
}

// The estimate takes logarithms of all figures of a noise model that it is given.
TEST(ScanRoomOptions, ANoiseModelHasAllItsFigures) {
  const NoiseModel whole{0.01, 0.02, 0.2, 0.003, 100, 10, 1e4};
  EXPECT_EQ(whole.problem(), std::nullopt);
  JointOptions options;
  options.noise = whole;
  EXPECT_EQ(options.problem(), std::nullopt);
  for (double NoiseModel::*figure :
       {&NoiseModel::white, &NoiseModel::drift, &NoiseModel::drift_length, &NoiseModel::scale,
        &NoiseModel::stretch, &NoiseModel::bending, &NoiseModel::jerk}) {
    options.noise = whole;
    (*options.noise).*figure = 0;
    ASSERT_TRUE(options.problem().has_value());
    EXPECT_EQ(*options.problem(), "noise." + *options.noise->problem());
    EXPECT_THROW(estimate_jointly(SampledScan(), options), InvalidInput);
  }
}

TEST(ScanRoomOptions, OfCalibrationAndOrientation) {
  const auto fit = [](const EllipsoidFitOptions& options) {
    EllipsoidFitReport report;
    fit_ellipsoid(Points::Zero(0, 3), report, options);
  };
  expect_option_refused(&EllipsoidFitOptions::smallest_coverage, "smallest_coverage", {-0.1, 1.1, kNan}, fit);
  expect_option_refused(&EllipsoidFitOptions::largest_uncertainty, "largest_uncertainty", {0.0, kNan}, fit);
  expect_option_refused(&EllipsoidFitOptions::max_iterations, "max_iterations", {0}, fit);
  const auto orient = [](const LogScanOptions& options) { scan_from_log(SensorLog(), options); };
  expect_option_refused(&LogScanOptions::inclination, "inclination", {1.6, -1.6, kNan}, orient);
  expect_option_accepted(&LogScanOptions::inclination, {1.5, -1.5});
  expect_option_refused(&LogScanOptions::accelerometer_weight, "accelerometer_weight", {0.0, kInfinite},
                        orient);
  expect_option_refused(&LogScanOptions::magnetometer_weight, "magnetometer_weight", {0.0, kNan}, orient);
  LogScanOptions options;
  options.calibration.magnetometer.matrix.row(2).setZero();
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_EQ(options.problem()->find("calibration must "), 0U);
}

}  // namespace
}  // namespace batten
