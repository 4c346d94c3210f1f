#include "batten/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d frame_of(const ScanCurve& curve, Eigen::Index i) {
  const Vector3d t = curve.tangents.row(i);
  const Vector3d n = curve.normals.row(i);
  Matrix3d X;
  X << t, n, t.cross(n);
  return X;
}

class EveryScan : public ::testing::TestWithParam<std::string> {
 protected:
  static const TracedNetwork& traced() {
    static std::map<std::string, TracedNetwork> cache;
    const auto shape = parse_choice<AnalyticShape>(GetParam());
    auto place = cache.find(GetParam());
    if (place == cache.end()) place = cache.emplace(GetParam(), trace_shape(shape)).first;
    return place->second;
  }
};

TEST_P(EveryScan, IsAValidScan) {
  const SimulatedScan simulated = simulate_scan(traced());
  EXPECT_NO_THROW(check_scan(simulated.scan));
  EXPECT_EQ(simulated.scan.curves.size(), traced().curves.size());
}

// With nothing wrong a reading is the frame of the curve, so the trapezoidal rule over the tangents leads
// from node to node with an error of second order in the step.
TEST_P(EveryScan, ReadingsIntegrateBackToTheNodesAtSecondOrder) {
  const auto worst_gap = [](double step) {
    SimulateOptions options;
    options.step = step;
    options.jitter = 0;
    options.dwell = 1;
    const SimulatedScan simulated = simulate_scan(traced(), options);
    double worst = 0;
    for (const ScanCurve& curve : simulated.scan.curves)
      for (size_t j = 0; j + 1 < curve.node_ids.size(); ++j) {
        Vector3d x = traced().node_positions.row(curve.node_ids[j]);
        for (int i = curve.node_readings[j]; i < curve.node_readings[j + 1]; ++i)
          x += (curve.distances[i + 1] - curve.distances[i]) / 2 *
               (curve.tangents.row(i) + curve.tangents.row(i + 1)).transpose();
        const Vector3d end = traced().node_positions.row(curve.node_ids[j + 1]);
        worst = std::max(worst, (x - end).norm() / traced().diameter);
      }
    return worst;
  };
  const double coarse = worst_gap(0.016);
  const double fine = worst_gap(0.004);
  EXPECT_LT(fine, 2e-4);
  if (coarse < 1e-12) GTEST_SKIP() << "every curve is straight";
  EXPECT_NEAR(std::log2(coarse / fine) / 2, 2, 0.15);
}

TEST_P(EveryScan, FramesAreOrthonormalWithAndWithoutNoise) {
  SimulateOptions options;
  options.orientation_noise = radians(2);
  options.drift = radians(1);
  options.outliers = 0.05;
  options.disturbance = radians(30);
  for (const SimulateOptions& o : {SimulateOptions(), options}) {
    const SimulatedScan simulated = simulate_scan(traced(), o);
    for (const ScanCurve& curve : simulated.scan.curves)
      for (Eigen::Index i = 0; i < curve.n_readings(); ++i) {
        ASSERT_NEAR(curve.tangents.row(i).norm(), 1, 1e-14);
        ASSERT_NEAR(curve.normals.row(i).norm(), 1, 1e-14);
        ASSERT_LT(std::abs(curve.tangents.row(i).dot(curve.normals.row(i))), 1e-14);
      }
  }
}

TEST_P(EveryScan, EveryNodeIsReadDwellTimesAtItsPlace) {
  SimulateOptions options;
  options.dwell = 4;
  options.odometer_error = 0.01;
  const SimulatedScan simulated = simulate_scan(traced(), options);
  for (size_t c = 0; c < simulated.scan.curves.size(); ++c) {
    const ScanCurve& curve = simulated.scan.curves[c];
    EXPECT_EQ(curve.node_ids, traced().curves[c].node_ids);
    for (size_t j = 0; j < curve.node_ids.size(); ++j) {
      const int first = curve.node_readings[j];
      for (int i = first; i < first + 4; ++i) {
        EXPECT_EQ(curve.distances[i], curve.distances[first]);
        EXPECT_EQ(simulated.true_distances[c][i], traced().curves[c].node_distances[j]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Simulate, EveryScan, ::testing::ValuesIn(choice_words<AnalyticShape>()),
                         [](const auto& shape) { return shape.param; });

/// A scan with so many readings that statistics are sharp: the sphere's three circles.
SimulatedScan sphere_scan(SimulateOptions options) {
  static const TracedNetwork sphere = trace_shape(AnalyticShape::Sphere);
  return simulate_scan(sphere, options);
}

/// Errors of all readings as rotation vectors in the world, 3 × n; measured = exp(error) · truth.
Eigen::Matrix3Xd frame_errors(const SimulatedScan& simulated) {
  std::vector<Vector3d> errors;
  for (size_t c = 0; c < simulated.scan.curves.size(); ++c)
    for (Eigen::Index i = 0; i < simulated.scan.curves[c].n_readings(); ++i)
      errors.push_back(so3_log(frame_of(simulated.scan.curves[c], i) *
                               simulated.true_frames[c][static_cast<size_t>(i)].transpose()));
  Eigen::Matrix3Xd all(3, static_cast<Eigen::Index>(errors.size()));
  for (size_t i = 0; i < errors.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = errors[i];
  return all;
}

// n = 27,000 draws: the relative standard deviation of an estimated standard deviation is 1/sqrt(2n) = 0.4 %;
// five of them are allowed.
TEST(Simulate, WhiteNoiseHasTheAskedForDeviationPerAxisAndNoMemory) {
  SimulateOptions options;
  options.orientation_noise = radians(2);
  options.step = 0.0006;
  options.dwell = 1;
  const SimulatedScan simulated = sphere_scan(options);
  const Eigen::Matrix3Xd errors = frame_errors(simulated);
  const auto n = static_cast<double>(errors.cols());
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(degrees(std::sqrt(errors.row(axis).squaredNorm() / n)), 2, 5 * 2 / std::sqrt(2 * n));
  const double lag_one =
      (errors.leftCols(errors.cols() - 1).cwiseProduct(errors.rightCols(errors.cols() - 1))).sum();
  EXPECT_LT(std::abs(lag_one) / errors.squaredNorm(), 5 / std::sqrt(3 * n));
  EXPECT_NEAR(degrees(simulated.report.rms_orientation_noise), 2, 5 * 2 / std::sqrt(6 * n));
}

// AR(1): the correlation over a distance d is exp(−d / length). Averaged over seeds, since each scan holds
// only some forty correlation lengths.
TEST(Simulate, DriftForgetsItselfOverItsLength) {
  SimulateOptions options;
  options.drift = radians(1);
  options.dwell = 1;
  options.jitter = 0;
  const double diameter = 2 * std::sqrt(3.0);
  const double length = options.drift_length * diameter;
  double squares = 0;
  double products = 0;
  double n = 0;
  double n_pairs = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    options.seed = seed;
    const SimulatedScan simulated = sphere_scan(options);
    const Eigen::Matrix3Xd errors = frame_errors(simulated);
    Eigen::Index first = 0;
    for (const Eigen::VectorXd& s : simulated.true_distances) {
      // Readings one correlation length apart.
      const Eigen::Index lag = std::lround(length / (s[1] - s[0]));
      for (Eigen::Index i = 0; i + lag < s.size(); ++i) {
        products += errors.col(first + i).dot(errors.col(first + i + lag));
        n_pairs += 3;
      }
      first += s.size();
    }
    squares += errors.squaredNorm();
    n += 3 * static_cast<double>(errors.cols());
  }
  EXPECT_NEAR(degrees(std::sqrt(squares / n)), 1, 0.03);
  EXPECT_NEAR((products / n_pairs) / (squares / n), std::exp(-1), 0.04);
}

TEST(Simulate, DistancesOfACurveAreWrongByOneFactor) {
  SimulateOptions options;
  options.odometer_error = 0.01;
  options.curve_length_error = 0.15;
  const SimulatedScan simulated = sphere_scan(options);
  for (size_t c = 0; c < 3; ++c) {
    const double factor = simulated.report.distance_factors[c];
    EXPECT_NE(factor, 1);
    EXPECT_LT(
        (simulated.scan.curves[c].distances - factor * simulated.true_distances[c]).cwiseAbs().maxCoeff(),
        1e-14);
  }
}

// 3 curves × 400 seeds: standard deviation of N(0, 0.003) and bounds and variance of U(−0.15, 0.15).
TEST(Simulate, FactorsFollowTheirDistributions) {
  double odometer = 0;
  double length = 0;
  double largest = 0;
  constexpr int kSeeds = 400;
  for (int seed = 0; seed < kSeeds; ++seed) {
    SimulateOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.step = 0.2;
    options.odometer_error = 0.003;
    for (const double factor : sphere_scan(options).report.distance_factors)
      odometer += (factor - 1) * (factor - 1);
    options.odometer_error = 0;
    options.curve_length_error = 0.15;
    for (const double factor : sphere_scan(options).report.distance_factors) {
      length += (factor - 1) * (factor - 1);
      largest = std::max(largest, std::abs(factor - 1));
    }
  }
  EXPECT_NEAR(std::sqrt(odometer / (3 * kSeeds)), 0.003, 5 * 0.003 / std::sqrt(6.0 * kSeeds));
  EXPECT_NEAR(std::sqrt(length / (3 * kSeeds)), 0.15 / std::sqrt(3.0), 0.005);
  EXPECT_LE(largest, 0.15);
}

// A binomial count; random orientations are uniform, so their mean matrix vanishes and the mean of cos² of
// the angle between two of their axes is 1/3.
TEST(Simulate, OutliersAreTheAskedForFractionAndUniform) {
  SimulateOptions options;
  options.outliers = 0.05;
  options.step = 0.001;
  const SimulatedScan simulated = sphere_scan(options);
  double n = 0;
  double different = 0;
  Matrix3d mean = Matrix3d::Zero();
  double cosines = 0;
  for (size_t c = 0; c < 3; ++c)
    for (Eigen::Index i = 0; i < simulated.scan.curves[c].n_readings(); ++i) {
      const Matrix3d relative = simulated.true_frames[c][static_cast<size_t>(i)].transpose() *
                                frame_of(simulated.scan.curves[c], i);
      n += 1;
      if ((relative - Matrix3d::Identity()).norm() < 1e-12) continue;
      different += 1;
      mean += relative;
      cosines += relative(0, 0) * relative(0, 0);
    }
  EXPECT_EQ(different, static_cast<double>(simulated.report.n_outliers));
  EXPECT_NEAR(different / n, 0.05, 5 * std::sqrt(0.05 * 0.95 / n));
  EXPECT_LT((mean / different).cwiseAbs().maxCoeff(), 5 / std::sqrt(3 * different));
  EXPECT_NEAR(cosines / different, 1.0 / 3, 5 * 0.3 / std::sqrt(different));
}

TEST(Simulate, ADisturbanceTurnsTheHeadingOnATenthOfOneCurve) {
  SimulateOptions options;
  options.disturbance = radians(30);
  options.step = 0.002;
  const SimulatedScan simulated = sphere_scan(options);
  const int disturbed = simulated.report.disturbed_curve;
  ASSERT_GE(disturbed, 0);
  for (int c = 0; c < 3; ++c) {
    const auto& truth = simulated.true_frames[static_cast<size_t>(c)];
    const ScanCurve& curve = simulated.scan.curves[static_cast<size_t>(c)];
    double largest = 0;
    double extent = 0;
    for (Eigen::Index i = 0; i < curve.n_readings(); ++i) {
      const Vector3d error = so3_log(frame_of(curve, i) * truth[static_cast<size_t>(i)].transpose());
      // About the vertical: the tilt against gravity stays right.
      EXPECT_LT(error.head<2>().norm(), 1e-12);
      largest = std::max(largest, error.z());
      if (error.z() > 1e-9 && i > 0) extent += curve.distances[i] - curve.distances[i - 1];
    }
    if (c == disturbed) {
      EXPECT_NEAR(degrees(largest), 30, 0.1);
      EXPECT_NEAR(extent / (2 * kPi), 0.1, 0.005);
    } else {
      EXPECT_EQ(largest, 0);
    }
  }
}

TEST(Simulate, SeedsRepeatAndDiffer) {
  SimulateOptions options;
  options.seed = 7;
  options.orientation_noise = radians(2);
  const SimulatedScan a = sphere_scan(options);
  const SimulatedScan b = sphere_scan(options);
  options.seed = 8;
  const SimulatedScan c = sphere_scan(options);
  EXPECT_EQ(a.scan.curves[0].tangents, b.scan.curves[0].tangents);
  EXPECT_NE(a.scan.curves[0].tangents, c.scan.curves[0].tangents);
}

// Every effect has its own stream: with outliers on, the other readings stay bit for bit as they were.
TEST(Simulate, OneEffectDoesNotShiftTheNumbersOfAnother) {
  SimulateOptions options;
  options.orientation_noise = radians(2);
  options.drift = radians(1);
  const SimulatedScan plain = sphere_scan(options);
  options.outliers = 0.2;
  options.odometer_error = 0.01;
  options.curve_length_error = 0.1;
  const SimulatedScan more = sphere_scan(options);
  long changed = 0;
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(plain.true_distances[c], more.true_distances[c]);
    for (Eigen::Index i = 0; i < plain.scan.curves[c].n_readings(); ++i)
      changed += plain.scan.curves[c].tangents.row(i) != more.scan.curves[c].tangents.row(i) ? 1 : 0;
  }
  EXPECT_EQ(changed, more.report.n_outliers);
}

TEST(Simulate, RefusesOptionsOutOfRangeByName) {
  const auto refused = [](auto change, const char* name) {
    SimulateOptions options;
    change(options);
    try {
      sphere_scan(options);
      ADD_FAILURE() << name;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  refused([](auto& o) { o.step = 0; }, "step");
  refused([](auto& o) { o.step = NAN; }, "step");
  refused([](auto& o) { o.jitter = 0.5; }, "jitter");
  refused([](auto& o) { o.dwell = 0; }, "dwell");
  refused([](auto& o) { o.orientation_noise = -1; }, "orientation_noise");
  refused([](auto& o) { o.drift = -1; }, "drift");
  refused([](auto& o) { o.drift_length = 0; }, "drift_length");
  refused([](auto& o) { o.odometer_error = 1; }, "odometer_error");
  refused([](auto& o) { o.curve_length_error = 1; }, "curve_length_error");
  refused([](auto& o) { o.outliers = 1.5; }, "outliers");
  refused([](auto& o) { o.disturbance = 4; }, "disturbance");
  EXPECT_THROW(simulate_scan(TracedNetwork()), InvalidInput);
}

}  // namespace
}  // namespace batten
