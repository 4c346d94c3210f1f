#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/session/document.hpp"

namespace batten {
namespace {

using namespace strokes;
using namespace test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// How a sheet of curves is drawn: so many lines each way on gentle waves, turned and scaled.
struct Sheet {
  int lines;
  double wave;
  double uneven;  ///< 0: evenly spaced; below 1: how far spaces differ from one another
  Matrix3d frame = Matrix3d::Identity();
};

Points on_sheet(const Sheet& sheet, std::initializer_list<Vector3d> corners, int n) {
  Points points = polygon(corners, n);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    points(i, 2) = sheet.wave * std::sin(2.5 * points(i, 0)) * std::cos(2 * points(i, 1));
  return points * sheet.frame.transpose();
}

/// Draws it as with a pen and counts. The grid of n lines each way has (n + 1)² faces; V, E and the borders
/// follow: four corners, and a vertex at both ends of every line and at each of the n² crossings.
void expect_grid(const Sheet& sheet) {
  const double scale = sheet.frame.col(0).norm();
  const int n = sheet.lines;
  Document document = one_model();
  document.apply(
      on_model(InsertEdit{{on_sheet(sheet, {kO, kX, kX + kY, kY, kO}, 100), true}, {.snap = 5e-4 * scale}}));
  const auto place = [&](int k) {
    const double t = static_cast<double>(k) / (n + 1);
    return t + sheet.uneven / (2 * kPi * 3) * std::sin(2 * kPi * 3 * t);
  };
  for (int k = 1; k <= n; ++k)
    for (const bool along_x : {true, false}) {
      const Vector3d from = place(k) * (along_x ? kY : kX), to = from + (along_x ? kX : kY);
      ASSERT_NO_THROW(document.apply(
          on_model(InsertEdit{{on_sheet(sheet, {from, to}, 200), false}, {.snap = 5e-4 * scale}})))
          << "line " << k << (along_x ? " along x" : " along y");
    }
  const SketchCounts counts = model_of(document).counts();
  EXPECT_EQ(counts.curves, 2 * n + 1);
  EXPECT_EQ(counts.vertices, n * n + 4 * n + 4);
  EXPECT_EQ(counts.edges, 2 * n * (n + 1) + 4 * (n + 1));
  EXPECT_EQ(counts.faces, (n + 1) * (n + 1));
  EXPECT_EQ(counts.boundary_loops, 1);
  EXPECT_EQ(model_of(document).broken_invariant(), "");
  // Curves through hundreds of crossings stay on the sheet, and do not swing between them.
  double off = 0;
  for (const SketchEdge& edge : model_of(document).edges()) {
    if (!edge.alive) continue;
    const Points flat = edge.polyline->points() * sheet.frame.inverse().transpose();
    for (Eigen::Index i = 0; i < flat.rows(); ++i)
      off = std::max(
          off, std::abs(flat(i, 2) - sheet.wave * std::sin(2.5 * flat(i, 0)) * std::cos(2 * flat(i, 1))));
  }
  EXPECT_LT(off, 2e-4);
}

// Under sanitizers it would take minutes.
#ifdef NDEBUG
constexpr int kLines = 250;
#else
constexpr int kLines = 60;
#endif

// From 130 lines each way on, more crossings on a curve than a spline of 128 spans can hold.
TEST(DenseSheet, FiveHundredCurves) {
  expect_grid({kLines, 0.1, 0});
}

TEST(DenseSheet, UnevenSpacing) {
  expect_grid({kLines / 2, 0.1, 0.5});
}

TEST(DenseSheet, TurnedAndScaledByAThousandEitherWay) {
  const Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  expect_grid({kLines / 2 - 5, 0.1, 0, 1e-3 * turn});
  expect_grid({kLines / 2 - 5, 0.1, 0, 1e3 * turn});
}

}  // namespace
}  // namespace batten
