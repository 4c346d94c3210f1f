#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/sketch/stroke_spline_detail.hpp"

namespace batten {
namespace {

using detail::StrokeSample;
using detail::StrokeSpline;
using Eigen::Vector3d;

template <typename Curve>
std::vector<StrokeSample> samples_of(const Curve& curve, int n) {
  std::vector<StrokeSample> samples;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) / n;
    samples.push_back({t, 1.0 / n, curve(t)});
  }
  return samples;
}

Vector3d cubic(double t) {
  return {1 + t, 2 * t * t - t, 3 * t * t * t - 2 * t};
}

Vector3d circle_point(double t) {
  return {std::cos(2 * kPi * t), std::sin(2 * kPi * t), 0};
}

// A cubic polynomial is a cubic spline of any number of spans.
TEST(StrokeSpline, LeastSquaresGiveBackCubics) {
  for (const int spans : {1, 3, 8}) {
    const StrokeSpline spline =
        detail::least_squares_spline(samples_of(cubic, 40), {}, spans, /*periodic=*/false, 0);
    for (const double t : {0.0, 0.1, 0.5, 0.77, 1.0})
      EXPECT_LT((spline.at(t) - cubic(t)).norm(), 1e-10) << spans << " spans at " << t;
  }
}

TEST(StrokeSpline, LeastSquaresMeetHeldPointsExactly) {
  const std::vector<StrokeSample> held{{0, 1, {1.1, 0, 0}}, {0.4, 1, {1.4, -0.1, -0.5}}, {1, 1, {2, 1, 1.2}}};
  const StrokeSpline spline = detail::least_squares_spline(samples_of(cubic, 40), held, 4, false, 1e-9);
  for (const StrokeSample& hold : held) EXPECT_LT((spline.at(hold.t) - hold.point).norm(), 1e-10) << hold.t;
}

// All of the weight in bending leaves a straight line: second differences of the control points of a clamped
// spline of one span vanish on it.
TEST(StrokeSpline, BendingStraightens) {
  const StrokeSpline spline = detail::least_squares_spline(samples_of(cubic, 40), {}, 1, false, 1e9);
  const Vector3d chord = spline.at(1) - spline.at(0);
  for (const double t : {0.25, 0.5, 0.75})
    EXPECT_LT((spline.at(t) - spline.at(0) - t * chord).norm(), 1e-6) << t;
}

// Periodic splines come round with their first two derivatives; the circle is met to fourth order.
TEST(StrokeSpline, PeriodicOnesComeRoundSmoothly) {
  const auto worst = [](int spans) {
    const StrokeSpline spline =
        detail::least_squares_spline(samples_of(circle_point, 400), {}, spans, /*periodic=*/true, 0);
    const double h = 1e-4;
    EXPECT_LT((spline.at(0) - spline.at(1)).norm(), 1e-12);
    EXPECT_LT((spline.at(h) - spline.at(0) - (spline.at(1) - spline.at(1 - h))).norm(), 100 * h * h);
    double distance = 0;
    for (int i = 0; i < 100; ++i) distance = std::max(distance, std::abs(spline.at(i / 100.0).norm() - 1));
    return distance;
  };
  EXPECT_NEAR(std::log2(worst(16) / worst(32)), 4, 0.3);
}

// Where a closed stroke begins is nothing that bending knows: turned on by a span, the samples give the same
// curve.
TEST(StrokeSpline, BendingComesRoundTheBeginning) {
  constexpr int kSpans = 8, kSamples = 160;
  const auto spline_from = [](int begin) {
    std::vector<StrokeSample> samples = samples_of(circle_point, kSamples);
    for (int i = 0; i < kSamples; ++i) {
      const double t = (i + 0.5) / kSamples + static_cast<double>(begin) / kSpans;
      samples[static_cast<size_t>(i)].point = (1 + 0.3 * std::sin(6 * kPi * t)) * circle_point(t);
    }
    return detail::least_squares_spline(samples, {}, kSpans, /*periodic=*/true, 0.01);
  };
  const StrokeSpline first = spline_from(0), later = spline_from(3);
  for (int i = 0; i < 40; ++i) {
    const double t = i / 40.0;
    EXPECT_LT((later.at(t) - first.at(std::fmod(t + 3.0 / kSpans, 1.0))).norm(), 1e-12) << t;
  }
}

// Between two offsets the rise is 3 s² − 2 s³: half at half way, with no slope at either end.
TEST(StrokeSpline, OffsetsChangeWithoutOvershoot) {
  StrokeSpline spline;
  spline.offsets = {{0.2, 1, {0, 0, 0}}, {0.6, 1, {1, -2, 0}}};
  EXPECT_LT((spline.offset_at(0.4) - Vector3d(0.5, -1, 0)).norm(), 1e-15);
  EXPECT_LT((spline.offset_at(0.3) - Vector3d(1, -2, 0) * (3 / 16.0 - 2 / 64.0)).norm(), 1e-15);
  EXPECT_EQ(spline.offset_at(0.1), Vector3d(0, 0, 0));  // before all: that of the first
  EXPECT_EQ(spline.offset_at(0.9), Vector3d(1, -2, 0));
  spline.periodic = true;  // from 0.6 over the seam to 1.2: 0.9 is half way
  EXPECT_LT((spline.offset_at(0.9) - Vector3d(0.5, -1, 0)).norm(), 1e-15);
  EXPECT_LT((spline.offset_at(0.1) - Vector3d(1, -2, 0) * (1 - (3 * 25 / 36.0 - 2 * 125 / 216.0))).norm(),
            1e-14);
}

// Held points at every hundredth, each off a noisy line by up to as much: all are met, and nothing
// swings further than they lie.
TEST(StrokeSpline, DenseHeldPointsAreMetWithoutSwinging) {
  const auto line = [](double t) { return Vector3d(t, 0, 0); };
  Random random(3);
  std::vector<StrokeSample> held{{0, 1, line(0)}};
  for (int i = 40; i < 50; ++i) held.push_back({i / 100.0, 1, {i / 100.0, 0.01 * random.uniform(-1, 1), 0}});
  held.push_back({1, 1, line(1)});
  const detail::FitAims aims{0.01, 1e-5, true};
  const StrokeSpline spline = detail::fitted_spline(samples_of(line, 50), held, false, aims);
  for (const StrokeSample& hold : held) EXPECT_LT((spline.at(hold.t) - hold.point).norm(), 1e-12) << hold.t;
  for (int i = 0; i <= 1000; ++i) EXPECT_LT(std::abs(spline.at(i / 1000.0).y()), 0.015) << i;
}

// Spans double until the rest is no more than the tolerance; where samples are noisy they end at a quarter of
// the samples, where they are not at their number.
TEST(StrokeSpline, NoiseLimitsTheSpans) {
  const auto wave = [](double t) { return Vector3d(t, std::sin(60 * kPi * t), 0); };
  const auto samples = samples_of(wave, 60);
  EXPECT_EQ(detail::fitted_spline(samples, {}, false, {1e-9, 1e-9, true}).spans, 16);
  EXPECT_EQ(detail::fitted_spline(samples, {}, false, {1e-9, 1e-9, false}).spans, 64);
  EXPECT_EQ(detail::fitted_spline(samples_of(cubic, 60), {}, false, {1e-6, 1e-12, false}).spans, 4);
}

// n chords of a circle of radius 1 leave it by 1 − cos(π / n), which is to be 1e-5 of the length 2 π.
TEST(StrokeSpline, IsSampledAsFinelyAsItTurns) {
  const StrokeSpline round = detail::least_squares_spline(samples_of(circle_point, 400), {}, 64, true, 0);
  const int n = detail::samples_needed(round, 0, 1, 2 * kPi);
  EXPECT_NEAR(n, kPi / std::acos(1 - 2e-5 * kPi), 4);
  const auto line = [](double t) { return Vector3d(t, 0, 0); };
  const StrokeSpline straight = detail::least_squares_spline(samples_of(line, 40), {}, 4, false, 0);
  EXPECT_EQ(detail::samples_needed(straight, 0, 1, 1), 16) << "the least";
  const Points points = detail::sampled(round, 0.75, 1.25, 10);
  ASSERT_EQ(points.rows(), 11);
  for (int i = 0; i <= 10; ++i)
    EXPECT_LT((points.row(i).transpose() - circle_point(0.75 + 0.05 * i)).norm(), 1e-5)
        << "over the seam " << i;
}

}  // namespace
}  // namespace batten
