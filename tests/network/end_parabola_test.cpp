#include "batten/network/end_parabola.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

// On a circle the derivative at the end is the tangent up to second order in the length of the samples, that
// of the chord to first order: halving the step divides the errors by four and by two.
TEST(EndParabola, ConvergesAtSecondOrderToTheTangentOfACircle) {
  const auto errors = [](double step) {
    EndParabola parabola({1, 0, 0});
    for (int k = 1; k <= 4; ++k) parabola.add({std::cos(k * step), std::sin(k * step), 0});
    const Vector3d tangent(0, 1, 0);
    return std::pair((parabola.tangent() - tangent).norm(), (parabola.chord() - tangent).norm());
  };
  const auto [coarse, coarse_chord] = errors(0.02);
  const auto [fine, fine_chord] = errors(0.01);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
  EXPECT_NEAR(coarse_chord / fine_chord, 2, 0.1);
}

// Least squares: what is left is at right angles to s and to s², for any samples.
TEST(EndParabola, LeavesAResidualThatNoOtherParabolaLowers) {
  Random random(3);
  const Vector3d end = random.normal3();
  std::vector<Vector3d> samples;
  EndParabola parabola(end);
  Vector3d x = end;
  for (int k = 0; k < 6; ++k) {
    x += Vector3d(0.1, 0.02, 0) + 0.02 * random.normal3();
    samples.push_back(x);
    parabola.add(x);
  }
  // The curvature term from the first normal equation, then the second must hold.
  double s = 0, s2 = 0, s3 = 0, s4 = 0;
  Vector3d previous = end, p1 = Vector3d::Zero(), p2 = Vector3d::Zero();
  for (const Vector3d& sample : samples) {
    s += (sample - previous).norm();
    previous = sample;
    s2 += s * s, s3 += s * s * s, s4 += s * s * s * s;
    p1 += s * (sample - end), p2 += s * s * (sample - end);
  }
  const Vector3d b = (p1 - s2 * parabola.tangent()) / s3;
  EXPECT_LT((p2 - s3 * parabola.tangent() - s4 * b).norm(), 1e-12 * p2.norm());
  EXPECT_NEAR(parabola.length(), s, 1e-15);
}

TEST(EndParabola, OfOneSampleIsTheChord) {
  EndParabola parabola({0, 0, 0});
  parabola.add({3, 4, 0});
  EXPECT_LT((parabola.tangent() - Vector3d(0.6, 0.8, 0)).norm(), 1e-15);
}

}  // namespace
}  // namespace batten::detail
