#include "batten/sketch/stroke.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

double length_of(const FittedStroke& fitted) {
  double length = 0;
  for (const FittedStroke::Piece& piece : fitted.pieces)
    for (Eigen::Index i = 1; i < piece.points.rows(); ++i)
      length += (piece.points.row(i) - piece.points.row(i - 1)).norm();
  return length;
}

// A spine with tremor, held at crossings that lie off it by as much: where a sample is close to a held point,
// the two ask for a slope that has nothing to do with the stroke, and the curve must not swing after it. The
// straight line is 15 long.
TEST(FitStroke, DoesNotSwingBesideHeldPoints) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Points points(91, 3);
    for (int i = 0; i <= 90; ++i)
      points.row(i) << 0.003 * random.normal(), 0.003 * random.normal(),
          15.0 * i / 90 + 0.003 * random.normal();
    const Stroke stroke = prepare_stroke(points, {});
    std::vector<HeldPoint> held{{0, Vector3d(0, 0, 0)}};
    for (const double z : {4.5, 8.0, 10.01, 12.0})
      held.push_back({z / 15 * stroke.length, Vector3d(0.004 * random.normal(), 0.004 * random.normal(), z)});
    held.push_back({stroke.length, Vector3d(0, 0, 15)});
    EXPECT_NEAR(length_of(fit_stroke(stroke, held)), 15, 0.02) << seed;
  }
}

// Samples far apart at a steep end, dense elsewhere: more spans than samples there. The profile of an
// outline, |y/4|⁴ + |z/2.2|⁴ = 1, sampled at equal steps of y, so that the first step rises by 0.7.
TEST(FitStroke, DoesNotSwingWhereSamplesAreFarApart) {
  const auto profile = [](double y) { return Vector3d(0, y, 2.2 * std::pow(1 - std::pow(y / 4, 4), 0.25)); };
  double truth = 0;
  constexpr int kFine = 4000;  // over the angle, where no step is steep
  const auto at_angle = [](double a) {
    const double c = std::cos(a), s = std::sin(a);
    return Vector3d(0, 4 * std::copysign(std::sqrt(std::abs(c)), c), 2.2 * std::sqrt(std::abs(s)));
  };
  for (int i = 0; i < kFine; ++i)
    truth += (at_angle(kPi * (i + 1) / kFine) - at_angle(kPi * i / kFine)).norm();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    Points points(161, 3);
    for (int i = 0; i <= 160; ++i) {
      points.row(i) = profile(-4 + 8.0 * i / 160).transpose();
      if (i > 0 && i < 160)
        for (int k = 0; k < 3; ++k) points(i, k) += 0.003 * random.normal();
    }
    const Stroke stroke = prepare_stroke(points, {});
    const std::vector<HeldPoint> held{{0, Vector3d(0.001, -3.999, 0.001)},
                                      {stroke.length, Vector3d(0.001, 4.001, -0.001)}};
    EXPECT_NEAR(length_of(fit_stroke(stroke, held)), truth, 0.01 * truth) << seed;
  }
}

/// Samples at uneven steps along a line through corners, with noise of `sigma` in every coordinate.
Points drawn(const std::vector<Vector3d>& corners, int n, double sigma, Random& random) {
  std::vector<double> arcs{0}, steps{0};
  for (size_t k = 1; k < corners.size(); ++k)
    arcs.push_back(arcs.back() + (corners[k] - corners[k - 1]).norm());
  for (int i = 1; i < n; ++i) steps.push_back(steps.back() + random.uniform(0.5, 1.5));
  Points points(n, 3);
  for (int i = 0; i < n; ++i) {
    const double arc = arcs.back() * steps[static_cast<size_t>(i)] / steps.back();
    size_t k = 1;
    while (k + 1 < arcs.size() && arcs[k] < arc) ++k;
    const double t = (arc - arcs[k - 1]) / (arcs[k] - arcs[k - 1]);
    points.row(i) = ((1 - t) * corners[k - 1] + t * corners[k]).transpose();
    for (int c = 0; c < 3; ++c) points(i, c) += sigma * random.normal();
  }
  return points;
}

// Noise is no corner and hides none, however dense the samples: noise of 0.4 % of the length is twelve times
// the way from one of 3,000 samples to the next. Two strokes of a hundred may be read wrongly.
TEST(PrepareStroke, FindsCornersAmongNoise) {
  for (const int n : {150, 400, 3000})
    for (const double sigma : {0.0, 0.001, 0.002, 0.004}) {
      int wrong = 0;
      constexpr int kStrokes = 50;
      for (int k = 0; k < kStrokes; ++k) {
        Random random(static_cast<std::uint64_t>(k + 1));
        const Stroke line =
            prepare_stroke(drawn({Vector3d(0, 0, 0), Vector3d(1, 0, 0)}, n, sigma, random), StrokeOptions{});
        const Stroke bracket = prepare_stroke(
            drawn({Vector3d(0, 0, 0), Vector3d(0, 0.3, 0), Vector3d(0.4, 0.3, 0), Vector3d(0.4, 0, 0)}, n,
                  sigma, random),
            StrokeOptions{});
        wrong += !line.corners.empty() + (bracket.corners.size() != 2);
        for (const int corner : bracket.corners) {
          const Vector3d at = bracket.points.row(corner);
          const double off = std::min((at - Vector3d(0, 0.3, 0)).norm(), (at - Vector3d(0.4, 0.3, 0)).norm());
          wrong += off > 0.03;
        }
      }
      EXPECT_LE(wrong, 2) << n << " samples, noise " << sigma;
    }
}

// Where a pen is set down it often slips to one side. Within the snapping distance of an end that is no
// corner; further away it is one.
TEST(PrepareStroke, HooksAtTheEndsAreNoCorners) {
  for (const double snap : {0.0, 0.03}) {
    Random random(3);
    StrokeOptions options;
    options.snap = snap;
    const Stroke stroke = prepare_stroke(
        drawn({Vector3d(0, 0.02, 0), Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 0, 0.02)}, 2000, 0,
              random),
        options);
    EXPECT_EQ(stroke.corners.size(), snap > 0 ? 0U : 2U);
  }
}

/// Points with a tremor of `deviation` a coordinate, smooth over some three samples, and a third as much that
/// is not.
Points with_tremor(Points points, double deviation, std::uint64_t seed) {
  Random random(seed);
  const Eigen::Index n = points.rows();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> white(static_cast<size_t>(n) + 20);
    for (double& value : white) value = random.normal();
    for (Eigen::Index i = 0; i < n; ++i) {
      double sum = 0, squares = 0;
      for (int k = -10; k <= 10; ++k) {
        const double weight = std::exp(-0.5 * k * k / (2.8 * 2.8));
        sum += weight * white[static_cast<size_t>(i + 10 + k)];
        squares += weight * weight;
      }
      points(i, axis) += deviation * (sum / std::sqrt(squares) + 0.35 * random.normal());
    }
  }
  return points;
}

Points circle_of(int n, double radius) {
  Points points(n, 3);
  for (int i = 0; i < n; ++i)
    points.row(i) << radius * std::cos(2 * kPi * i / n), radius * std::sin(2 * kPi * i / n), 0;
  return points;
}

// Strokes without noise stay as they are to the last bit, also those of few samples, whose distance from
// cubics looks like noise, and those rounded to the digits of a file.
TEST(NeatStroke, LeavesExactStrokesAlone) {
  for (const int n : {12, 16, 24, 60, 200})
    for (const double digits : {0.0, 1e6}) {
      Points points = circle_of(n, 3);
      if (digits > 0) points = (points * digits).array().round() / digits;
      StrokeOptions options;
      options.closed = true;
      const Stroke stroke = prepare_stroke(points, options), neat = neat_stroke(stroke);
      EXPECT_FALSE(neat.is_neat) << n;
      EXPECT_EQ(neat.points, stroke.points) << n;
    }
}

// The mean square distance of samples from a circle with tremor s in each coordinate, a ninth of it from
// sample to sample, is 2 · 1.12 s² across the circle. Over some ten samples tremor is like the stroke itself;
// what a spline of few spans leaves of it is four fifths in the mean. There are no corners, and a line stays
// a line.
TEST(NeatStroke, TakesTremorFromCirclesAndLines) {
  const double deviation = 0.03;
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    StrokeOptions options;
    options.closed = true;
    const Stroke circle =
        neat_stroke(prepare_stroke(with_tremor(circle_of(90, 3), deviation, seed), options));
    EXPECT_TRUE(circle.is_neat) << seed;
    EXPECT_TRUE(circle.corners.empty()) << seed;
    for (Eigen::Index i = 0; i < circle.points.rows(); ++i) {
      const double aside = circle.points.row(i).head(2).norm() - 3, up = circle.points(i, 2);
      squares += (aside * aside + up * up) / static_cast<double>(circle.points.rows());
    }

    Points line(81, 3);
    for (int i = 0; i <= 80; ++i) line.row(i) << 10.0 * i / 80, 0, 0;
    const Stroke straight = neat_stroke(prepare_stroke(with_tremor(line, 0.08, seed), {}));
    EXPECT_TRUE(straight.corners.empty()) << seed;
    EXPECT_LT(straight.length, 10.5) << seed;
  }
  EXPECT_LT(squares / 20, 0.8 * 2 * 1.12 * deviation * deviation);
}

// The corners of a rectangle with tremor are there, near their places, and there are no others.
TEST(NeatStroke, KeepsDrawnCorners) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Points points(120, 3);
    const std::array<Vector3d, 4> corners{Vector3d(0, 0, 0), Vector3d(6, 0, 0), Vector3d(6, 4, 0),
                                          Vector3d(0, 4, 0)};
    for (int i = 0; i < 120; ++i) {
      const size_t side = static_cast<size_t>((i + 15) / 30) % 4;
      const double t = ((i + 15) % 30) / 30.0;
      points.row(i) = ((1 - t) * corners[side] + t * corners[(side + 1) % 4]).transpose();
    }
    StrokeOptions options;
    options.closed = true;
    const Stroke neat = neat_stroke(prepare_stroke(with_tremor(points, 0.02, seed), options));
    ASSERT_EQ(neat.corners.size(), 4U) << seed;
    for (const int corner : neat.corners) {
      double nearest = 10;
      for (const Vector3d& place : corners)
        nearest = std::min(nearest, (neat.points.row(corner).transpose() - place).norm());
      EXPECT_LT(nearest, 0.2) << seed;
    }
  }
}

TEST(PrepareStroke, NamesOptionsOutOfRange) {
  Points line(2, 3);
  line << 0, 0, 0, 1, 0, 0;
  for (const StrokeOptions& options :
       {StrokeOptions{.snap = -1}, StrokeOptions{.snap = std::nan("")}, StrokeOptions{.corner_angle = 0}}) {
    ASSERT_NE(options.problem(), std::nullopt);
    EXPECT_THROW(prepare_stroke(line, options), InvalidInput) << *options.problem();
  }
  EXPECT_EQ(StrokeOptions{.snap = -1}.problem(), "snap must be finite and at least 0, got -1");
  EXPECT_EQ(StrokeOptions{.corner_angle = 0}.problem(), "corner_angle must be above 0, got 0");
  EXPECT_EQ(StrokeOptions().problem(), std::nullopt);
}

// Held points off a neat stroke move it without a swing: the curve goes through them and is nowhere farther
// from the line than they are.
TEST(NeatStroke, IsMovedOntoHeldPoints) {
  Points line(81, 3);
  for (int i = 0; i <= 80; ++i) line.row(i) << 10.0 * i / 80, 0, 0;
  Stroke stroke = prepare_stroke(line, {});
  stroke.is_neat = true;
  const std::vector<HeldPoint> held{
      {0, Vector3d(0, 0.1, 0)}, {4, Vector3d(4, -0.2, 0)}, {10, Vector3d(10, 0, 0.1)}};
  const FittedStroke fitted = fit_stroke(stroke, held);
  ASSERT_EQ(fitted.pieces.size(), 2U);
  EXPECT_EQ(fitted.pieces[0].points.row(0).transpose(), held[0].position);
  EXPECT_EQ(fitted.pieces[1].points.row(0).transpose(), held[1].position);
  for (const FittedStroke::Piece& piece : fitted.pieces)
    EXPECT_LT(piece.points.rightCols(2).rowwise().norm().maxCoeff(), 0.2001);
  // Halfway between two held points the line is moved by half of each.
  const auto nearest_to = [&](double x) {
    Eigen::RowVector3d best(1e9, 0, 0);
    for (const FittedStroke::Piece& piece : fitted.pieces)
      for (Eigen::Index i = 0; i < piece.points.rows(); ++i)
        if (std::abs(piece.points(i, 0) - x) < std::abs(best.x() - x)) best = piece.points.row(i);
    return best;
  };
  EXPECT_LT((nearest_to(2) - Eigen::RowVector3d(2, -0.05, 0)).tail<2>().norm(), 0.02);
  EXPECT_LT((nearest_to(7) - Eigen::RowVector3d(7, -0.1, 0.05)).tail<2>().norm(), 0.02);
}

}  // namespace
}  // namespace batten
