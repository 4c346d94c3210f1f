#include "sanitizers.hpp"
#include "strokes.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/sketch/closing_detail.hpp"
#include "batten/sketch/stroke.hpp"

namespace batten {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using strokes::kO;
using strokes::kX;
using strokes::kY;

/// A plane and a circle in it by least squares: principal plane, then Kåsa's linear fit.
struct CircleFit {
  Vector3d centre, normal;
  double radius;

  explicit CircleFit(const Points& points) {
    const Eigen::RowVector3d mean = points.colwise().mean();
    const Points centred = points.rowwise() - mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(centred.transpose() * centred));
    normal = axes.eigenvectors().col(0);
    const Eigen::MatrixX2d flat = centred * axes.eigenvectors().rightCols<2>();
    Eigen::MatrixX3d rows(points.rows(), 3);
    rows << 2 * flat, Eigen::VectorXd::Ones(points.rows());
    const Vector3d solution =
        (rows.transpose() * rows).ldlt().solve(rows.transpose() * flat.rowwise().squaredNorm());
    centre = mean.transpose() + axes.eigenvectors().rightCols<2>() * solution.head<2>();
    radius = std::sqrt(solution[2] + solution.head<2>().squaredNorm());
  }

  double rms_of(const Points& points) const {
    double sum = 0;
    for (Index i = 0; i < points.rows(); ++i) {
      const Vector3d off = points.row(i).transpose() - centre;
      const double height = off.dot(normal), wide = (off - height * normal).norm() - radius;
      sum += height * height + wide * wide;
    }
    return std::sqrt(sum / static_cast<double>(points.rows()));
  }
};

/// Points at even steps along a stroke, so that places where the hand was slow do not count more.
Points evenly(const Stroke& stroke, int n) {
  const std::vector<double> arcs = stroke.arcs();
  Points points(n, 3);
  std::size_t k = 0;
  for (int i = 0; i < n; ++i) {
    const double arc = arcs.back() * i / n;
    while (k + 2 < arcs.size() && arcs[k + 1] <= arc) ++k;
    const double t = (arc - arcs[k]) / (arcs[k + 1] - arcs[k]);
    const auto row = static_cast<Index>(k), next = (row + 1) % stroke.points.rows();
    points.row(i) = (1 - t) * stroke.points.row(row) + t * stroke.points.row(next);
  }
  return points;
}

StrokeOptions as_inserted(const Points& points) {
  StrokeOptions options;
  options.snap = 0.015 * (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  options.recognise_loops = true;
  return options;
}

Points read_pen(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<double> all;
  for (double value = 0; file >> value;) all.push_back(value);
  Points points(static_cast<Index>(all.size() / 7), 3);
  for (Index i = 0; i < points.rows(); ++i)
    for (Index k = 0; k < 3; ++k) points(i, k) = all[static_cast<std::size_t>(7 * i + k)];
  return points;
}

// Circles and lines drawn with a tracked pen: all circles are loops, told or not, and lie
// around the best circle of the samples no worse than those do, pen slips and overlaps included; no line is
// one.
TEST(FindClosing, TellsDrawnCirclesFromDrawnLines) {
  const std::filesystem::path folder = BATTEN_SHARED_DATA "/pen/study1_user1";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no public data in ../shared/data/pen";
  int circles = 0, lines = 0, with_corners = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const Points points = read_pen(entry.path());
    StrokeOptions options = as_inserted(points);
    const Stroke stroke = prepare_stroke(points, options);
    if (name.find("circle") == std::string::npos) {
      ++lines;
      EXPECT_FALSE(stroke.closed) << name;
      continue;
    }
    ++circles;
    ASSERT_TRUE(stroke.closed) << name;
    options.closed = true;
    const Stroke closed = prepare_stroke(points, options);
    Stroke drawn;
    drawn.points = points;
    const Points all = evenly(drawn, 400);
    const CircleFit best(all);
    for (const Stroke* each : {&stroke, &closed}) {
      with_corners += each->corners.empty() ? 0 : 1;
      EXPECT_FALSE(self_contact(*each, 0.25 * options.snap).found) << name;
      EXPECT_LE(best.rms_of(evenly(*each, 400)), 1.1 * best.rms_of(all)) << name;
    }
  }
  EXPECT_EQ(circles, 54);
  EXPECT_EQ(lines, 54);
  EXPECT_LE(with_corners, 6);  // of 108: one hand turned sharply on its way, others where they came round
}

/// How a hand draws the closed curve r(t), t in [0, 1): beginning anywhere, running `past` its start (or
/// stopping short of it, below 0), drifting aside by `drift` on the way, with tremor.
template <typename Curve>
Points by_hand(const Curve& curve, double past, const Vector3d& drift, double tremor, Random& random) {
  constexpr int kSamples = 120;
  const double start = random.uniform(0, 1);
  Points points(kSamples, 3);
  for (int i = 0; i < kSamples; ++i) {
    const double way = (1 + past) * i / (kSamples - 1);
    points.row(i) = (curve(start + way) + (way - 0.5) * drift).transpose();
    for (int k = 0; k < 3; ++k) points(i, k) += tremor * random.normal();
  }
  return points;
}

// Round, oval, egg-shaped and saddle-shaped loops of size 2, drawn from 12 % short to 15 % past their start
// and drifting aside by up to a tenth of their size: closed, and nowhere further from the curve than half the
// drift, the sagitta of the gap and the tremor explain.
TEST(FindClosing, ClosesLoopsOfManyShapes) {
  const auto angle = [](double t) { return 2 * kPi * t; };
  const auto circle = [&](double t) { return Vector3d(std::cos(angle(t)), std::sin(angle(t)), 0); };
  const auto oval = [&](double t) { return Vector3d(std::cos(angle(t)), 0.4 * std::sin(angle(t)), 0); };
  const auto egg = [&](double t) {
    return Vector3d(std::cos(angle(t)), (0.7 - 0.2 * std::cos(angle(t))) * std::sin(angle(t)), 0);
  };
  const auto saddle = [&](double t) {
    return Vector3d(std::cos(angle(t)), std::sin(angle(t)), 0.4 * std::cos(2 * angle(t)));
  };
  const std::vector<std::function<Vector3d(double)>> shapes{circle, oval, egg, saddle};
  int n = 0, missed = 0;
  for (std::size_t shape = 0; shape < shapes.size(); ++shape)
    for (std::uint64_t seed = 1; seed <= test::repeated(25U, 5U); ++seed) {
      Random random(100 * seed + shape);
      const double past = random.uniform(shape == 1 ? -0.05 : -0.09, 0.15);
      const Vector3d drift = random.uniform(0, 0.15) * random.direction();
      const Points points = by_hand(shapes[shape], past, drift, 0.004, random);
      const Stroke stroke = prepare_stroke(points, as_inserted(points));
      ++n;
      if (!stroke.closed) {
        ++missed;
        continue;
      }
      const Points even = evenly(stroke, 200);
      for (Index i = 0; i < even.rows(); ++i) {
        double nearest = 1e300;
        for (int k = 0; k < 2000; ++k)
          nearest = std::min(nearest, (shapes[shape](k / 2000.0) - even.row(i).transpose()).norm());
        ASSERT_LE(nearest, 0.5 * (1 + std::max(past, 0.0)) * drift.norm() + 0.05) << shape << " " << seed;
      }
    }
  EXPECT_LE(missed, std::max(1, n / 33));
}

// What a hand means to be open stays open: arcs of up to 300 degrees, hairpins, an S, an omega, a helix of
// one and a half turns, a 6 with its tail.
TEST(FindClosing, LeavesOpenWhatIsOpen) {
  const auto sampled = [](const std::function<Vector3d(double)>& curve) {
    Points points(150, 3);
    for (Index i = 0; i < 150; ++i) points.row(i) = curve(static_cast<double>(i) / 149).transpose();
    return points;
  };
  const auto arc = [](double degrees) {
    return [degrees](double t) {
      const double a = degrees * kPi / 180 * t;
      return Vector3d(std::cos(a), std::sin(a), 0);
    };
  };
  const auto hairpin = [](double t) {  // two sides of 2, 0.3 apart
    const double s = 4 * t + 0.47 * t;
    if (s < 2) return Vector3d(s, 0.15, 0);
    if (s > 2.47) return Vector3d(2 - (s - 2.47), -0.15, 0);
    const double a = kPi / 2 - (s - 2) / 0.15;
    return Vector3d(2 + 0.15 * std::cos(a), 0.15 * std::sin(a), 0);
  };
  const auto letter_s = [](double t) { return Vector3d(std::sin(4 * kPi * t), 2 * t, 0); };
  const auto omega = [](double t) {
    if (t < 0.2) return Vector3d(-1.2 + 5 * t, -1, 0);
    if (t > 0.8) return Vector3d(0.2 + 5 * (t - 0.8), -1, 0);
    const double a = -kPi / 2 - 0.2 - (2 * kPi - 0.4) * (t - 0.2) / 0.6;
    return Vector3d(std::cos(a), std::sin(a), 0);
  };
  const auto helix = [](double t) { return Vector3d(std::cos(3 * kPi * t), std::sin(3 * kPi * t), 1.5 * t); };
  const auto six = [](double t) {
    if (t < 0.35) return Vector3d(-1, 5.5 * (0.35 - t), 0);
    const double a = kPi + 2 * kPi * (t - 0.35) / 0.65;
    return Vector3d(std::cos(a), std::sin(a), 0);
  };
  const std::vector<std::function<Vector3d(double)>> curves{arc(180), arc(270), arc(300), hairpin,
                                                            letter_s, omega,    helix,    six};
  for (std::size_t k = 0; k < curves.size(); ++k) EXPECT_FALSE(detail::find_closing(sampled(curves[k]))) << k;
}

// A circle with a tail that leaves it straight: closed where the tail is what a pen leaves beside a loop,
// open where it leads away as far as a third of the whole, the limit for what is cut off.
TEST(FindClosing, CutsOffNoTailThatLeadsAway) {
  const auto with_tail = [](double tail) {
    Points points(300, 3);
    for (Index i = 0; i < 300; ++i) {
      const double s = (tail + 2 * kPi) * static_cast<double>(i) / 299, a = s - tail;
      points.row(i) =
          (s < tail ? Vector3d(1 + tail - s, 0, 0) : Vector3d(std::cos(a), std::sin(a), 0)).transpose();
    }
    return points;
  };
  EXPECT_TRUE(detail::find_closing(with_tail(0.8)));
  EXPECT_FALSE(detail::find_closing(with_tail(1.17)));
}

// A circle run on by an eighth is a loop whose end overlaps; one and a half turns are a coil. At the end of
// the search its ends are near each other too, and still nearer beyond.
TEST(FindClosing, LeavesCoilsOpen) {
  const auto turns = [](double n) { return strokes::arc(kO, kX, kY, 0, 2 * kPi * n, 240); };
  EXPECT_TRUE(detail::find_closing(turns(1.125)));
  EXPECT_FALSE(detail::find_closing(turns(1.5)));
}

// A figure of eight is a loop, and one that meets itself.
TEST(FindClosing, FiguresOfEightMeetThemselves) {
  Points points(200, 3);
  for (Index i = 0; i < 200; ++i) {
    const double a = 0.4 + 2 * kPi * static_cast<double>(i) / 196;
    points.row(i) << std::cos(a), std::sin(2 * a) / 2, 0;
  }
  const StrokeOptions options = as_inserted(points);
  const Stroke stroke = prepare_stroke(points, options);
  EXPECT_TRUE(stroke.closed);
  EXPECT_TRUE(self_contact(stroke, 0.25 * options.snap).found);
}

// Closed polygons keep all their corners, the one where the hand began among them.
TEST(FindClosing, KeepsTheCornerWhereAPolygonBegins) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Points points = strokes::polygon(
        {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0), Vector3d(0, 1, 0), Vector3d(0.01, 0.03, 0)},
        30);
    for (Index i = 0; i < points.rows(); ++i)
      for (int k = 0; k < 3; ++k) points(i, k) += 0.002 * random.normal();
    const Stroke stroke = prepare_stroke(points, as_inserted(points));
    ASSERT_TRUE(stroke.closed);
    EXPECT_EQ(stroke.corners.size(), 4U) << seed;
  }
}

// Exact loops are the samples that were given.
TEST(ClosedLoop, LeavesExactLoopsAlone) {
  Points points(100, 3);
  for (Index i = 0; i < 100; ++i) {
    const double a = 2 * kPi * static_cast<double>(i) / 100;
    points.row(i) << std::cos(a), 0.5 * std::sin(a), 0.2 * std::cos(3 * a);
  }
  const detail::ClosedLoop loop = detail::closed_loop(points, detail::closing_of_loop(points));
  EXPECT_FALSE(loop.joined);
  EXPECT_TRUE(loop.points == points);
}

}  // namespace
}  // namespace batten
