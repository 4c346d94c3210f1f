#include "scan/scan_fixtures.hpp"

#include <gtest/gtest.h>

#include "batten/scan/integration.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/rate_change_detail.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// The exact frames of the border of a dish, whose rate of turn changes, at n + 1 places.
SampledScan border_of_dish(int n) {
  const TracedCurve curve = trace_shape(AnalyticShape::Dish).curves.front();
  SampledCurve sampled;
  sampled.parameters = Eigen::VectorXd::LinSpaced(n + 1, 0, 0.7 * curve.path->length());
  for (int k = 0; k <= n; ++k) {
    const CurvePoint point = curve.path->at(sampled.parameters[k]);
    sampled.frames.push_back(darboux_frame(point.tangent, point.normal));
  }
  return {{sampled}};
}

TEST(RateChange, StepsAreOfFourthOrderWhereTheRateOfTurnChanges) {
  const TracedCurve curve = trace_shape(AnalyticShape::Dish).curves.front();
  const Vector3d truth = curve.path->at(0.7 * curve.path->length()).position - curve.path->at(0).position;
  const auto errors = [&](int n) {
    const SampledScan scan = border_of_dish(n);
    const auto error = [&](const Points& steps) {
      return (steps.colwise().sum().transpose() - truth).norm();
    };
    return std::pair(error(frame_steps(scan, StepRule::ConstantRate)[0]), error(fourth_order_steps(scan)[0]));
  };
  const auto [coarse2, coarse4] = errors(20);
  const auto [fine2, fine4] = errors(80);
  EXPECT_NEAR(std::log2(coarse2 / fine2) / 2, 2, 0.2);
  // Both ends take the change of their neighbours: of third order, on a step each.
  EXPECT_GT(std::log2(coarse4 / fine4) / 2, 3.4);
  EXPECT_LT(fine4, 0.05 * fine2);
}

TEST(RateChange, IsThatOfThePolynomialAndBoundedAtCorners) {
  // ω = s² x at the middles of even steps: ω' = 2 s at the samples between.
  const double h = 0.1;
  std::vector<Vector3d> omega;
  for (int k = 0; k < 6; ++k) omega.push_back(std::pow((k + 0.5) * h, 2) * Vector3d::UnitX());
  const std::vector<double> lengths(6, h);
  const std::vector<Vector3d> changes = rate_changes(omega, lengths, false);
  ASSERT_EQ(changes.size(), 7U);
  for (int k = 1; k < 6; ++k) EXPECT_NEAR(changes[k].x(), 2 * k * h, 1e-12) << k;
  EXPECT_EQ(changes[0], changes[1]);
  EXPECT_EQ(changes[6], changes[5]);
  const std::vector<Vector3d> ring = rate_changes(omega, lengths, true);
  EXPECT_NEAR(ring[0].x(), (omega[0].x() - omega[5].x()) / h, 1e-12);
  EXPECT_EQ(ring[0], ring[6]);
  omega[3] = {100, 0, 0};  // 10 rad within a step
  EXPECT_NEAR(h * h * rate_changes(omega, lengths, false)[3].norm(), 0.5, 1e-12);
}

TEST(RateChange, TheLagOfThePrefilterIsTakenOff) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  SimulateOptions device;
  device.step = 0.004;
  const Scan scan = simulate_scan(traced, device).scan;
  std::vector<std::string> warnings;
  PrefilterOptions options;
  options.step = 0.04 * traced.diameter;
  options.wrap = false;
  SampledScan samples = resample(scan, clean_readings(scan, {}, warnings), options);
  const auto error = [&] {
    double sum = 0;
    for (size_t c = 0; c < traced.curves.size(); ++c) {
      const SampledCurve& curve = samples.curves[c];
      for (int k = 1; k + 1 < curve.n_samples(); ++k) {
        const CurvePoint p = traced.curves[c].path->at(curve.parameters[k]);
        sum += so3_log(darboux_frame(p.tangent, p.normal).transpose() * curve.frames[k]).norm();
      }
    }
    return sum;
  };
  const double before = error();
  remove_lag(samples);
  EXPECT_LT(error(), 0.15 * before);
}

}  // namespace
}  // namespace batten
