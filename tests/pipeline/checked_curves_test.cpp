#include "batten/pipeline/checked_curves.hpp"

#include "operators/sample_meshes.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// A sheet over −1 ≤ x ≤ 1, 0 ≤ y ≤ 1: flat up to x = 0, then as told. Vertices lie on x = 0.
TriangleMesh sheet(int n, const std::function<Vector3d(double x, double y)>& bend) {
  return samples::mapped_grid(2 * n + 1, n + 1, false, false, [&](double u, double v) {
    const double x = 2 * u - 1;
    return x <= 0 ? Vector3d(x, v, 0) : bend(x, v);
  });
}

TriangleMesh roof(int n, double angle) {
  return sheet(n, [=](double x, double y) { return Vector3d(x * std::cos(angle), y, -x * std::sin(angle)); });
}

/// Straight curves along y, at the places given.
CurveNetwork lines(const std::vector<Vector3d>& starts) {
  CurveNetwork network;
  constexpr int kSteps = 10;
  network.positions.resize(static_cast<Eigen::Index>(starts.size()) * (kSteps + 1), 3);
  int v = 0;
  for (const Vector3d& start : starts) {
    NetworkCurve& curve = network.curves.emplace_back();
    for (int i = 0; i <= kSteps; ++i) {
      network.positions.row(v) = (start + i * Vector3d(0, 1.0 / kSteps, 0)).transpose();
      curve.vertices.push_back(v++);
    }
  }
  return network;
}

TEST(CheckCurves, AKinkFailsWithItsAngleAndPlaceAndASmoothCurvePasses) {
  const TriangleMesh mesh = roof(20, radians(2));
  CurveNetwork network = lines({{0, 0, 0}, {-0.5, 0, 0}});
  network.curves[0].name = "ridge";
  const CurveCheck check = check_curves(mesh, network);
  EXPECT_FALSE(check.passes());
  EXPECT_EQ(check.n_checked, 2);
  EXPECT_EQ(check.n_failed, 1);
  const CheckedCurve& ridge = check.curves[0];
  EXPECT_EQ(ridge.name, curve_name(network, 0));
  EXPECT_EQ(ridge.verdict, CurveVerdict::Fail);
  ASSERT_EQ(ridge.reasons.size(), 1u);
  EXPECT_EQ(ridge.reasons[0], "normals differ by 2 degrees, more than 0.5");
  EXPECT_NEAR(ridge.worst.x(), 0, 1e-9);
  EXPECT_NEAR(degrees(ridge.figures.max_normal_jump), 2, 1e-6);
  EXPECT_EQ(check.curves[1].verdict, CurveVerdict::Pass);
  EXPECT_TRUE(check.curves[1].reasons.empty());
  EXPECT_LT(check.curves[1].figures.max_normal_jump, 1e-9);
}

TEST(CheckCurves, HoldsToWhatIsAskedFor) {
  const TriangleMesh mesh = roof(20, radians(2));
  CurveNetwork network = lines({{0, 0, 0}});
  CurveCheckOptions options;
  options.tolerance = radians(2.1);
  EXPECT_TRUE(check_curves(mesh, network, options).passes());
  options.tolerance = radians(1.9);
  EXPECT_FALSE(check_curves(mesh, network, options).passes());
  options.require = ContinuityClass::G0;
  EXPECT_TRUE(check_curves(mesh, network, options).passes());
  network.curves[0].sharp = true;  // an edge that is meant to be one
  const CurveCheck check = check_curves(mesh, network);
  EXPECT_EQ(check.curves[0].verdict, CurveVerdict::Sharp);
  EXPECT_TRUE(check.passes());
  EXPECT_EQ(check.n_checked, 1);
}

// A plane that goes over into a cylinder of radius 2: one normal, curvatures 0 and 1/2.
TEST(CheckCurves, AJumpOfTheCurvatureFailsG2AndPassesG1) {
  const TriangleMesh mesh = sheet(
      40, [](double x, double y) { return Vector3d(2 * std::sin(x / 2), y, -2 * (1 - std::cos(x / 2))); });
  const CurveNetwork network =
      lines({{0, 0, 0}, {-0.5, 0, 0}, {2 * std::sin(0.25), 0, -2 * (1 - std::cos(0.25))}});
  CurveCheckOptions options;
  EXPECT_TRUE(check_curves(mesh, network, options).passes());
  options.require = ContinuityClass::G2;
  const CurveCheck check = check_curves(mesh, network, options);
  EXPECT_EQ(check.curves[0].verdict, CurveVerdict::Fail);
  EXPECT_NE(check.curves[0].reasons.at(0).find("curvatures differ by"), std::string::npos);
  EXPECT_GT(check.curves[0].max_curvature_share, 0.8);  // 1, less what the quadrics smooth
  EXPECT_EQ(check.curves[1].verdict, CurveVerdict::Pass) << "on the plane";
  EXPECT_EQ(check.curves[2].verdict, CurveVerdict::Pass) << "on the cylinder";
}

TEST(CheckCurves, WhatCannotBeJudgedIsNoSuccess) {
  // Off the surface by a tenth of its size, 2.2.
  const CurveCheck away = check_curves(roof(20, 0), lines({{-0.5, 0, 0.2}}));
  EXPECT_EQ(away.n_failed, 1);
  EXPECT_NE(away.curves[0].reasons.at(0).find("% of the size off the surface, more than 1 %"),
            std::string::npos)
      << away.curves[0].reasons[0];
  // Two triangles on either side are no quadric.
  const CurveCheck coarse = check_curves(roof(1, 0), lines({{0, 0, 0}}));
  ASSERT_EQ(coarse.curves[0].figures.n_samples, 0);
  EXPECT_EQ(coarse.n_failed, 1);
  EXPECT_NE(coarse.curves[0].reasons.at(0).find("cannot be measured"), std::string::npos);
}

TEST(CheckCurves, ABorderIsNotChecked) {
  const CurveCheck check = check_curves(roof(20, 0), lines({{-1, 0, 0}}));
  EXPECT_EQ(check.curves[0].verdict, CurveVerdict::Border);
  EXPECT_EQ(check.n_checked, 0);
  EXPECT_TRUE(check.passes());
}

TEST(CheckCurves, NamesWhatIsWrongWithItsInput) {
  const auto message = [](const CurveNetwork& network, const CurveCheckOptions& options) -> std::string {
    try {
      check_curves(roof(4, 0), network, options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({}, {}).find("no curves"), std::string::npos);
  CurveCheckOptions options;
  options.tolerance = 0;
  EXPECT_NE(message(lines({{0, 0, 0}}), options).find("tolerance"), std::string::npos);
  options = {};
  options.gap = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(lines({{0, 0, 0}}), options).find("gap"), std::string::npos);
  options = {};
  options.curvature = -1;
  EXPECT_NE(message(lines({{0, 0, 0}}), options).find("curvature"), std::string::npos);
  options = {};
  options.distance = 0;
  EXPECT_NE(message(lines({{0, 0, 0}}), options).find("distance"), std::string::npos);
}

TEST(Surroundings, AreTheTrianglesAndThePieceOfTheCurveNearAPlace) {
  const TriangleMesh mesh = roof(20, 0);
  const CurveNetwork network = lines({{0, 0, 0}, {-0.5, 0, 0}});
  const Surroundings there = surroundings(mesh, network, 0, {0, 0.5, 0}, 0.22);
  ASSERT_GT(there.mesh.n_triangles(), 0);
  EXPECT_LT(there.mesh.n_triangles(), mesh.n_triangles() / 4);
  for (Eigen::Index v = 0; v < there.mesh.n_vertices(); ++v)
    EXPECT_LT((there.mesh.positions.row(v) - Eigen::RowVector3d(0, 0.5, 0)).norm(), 0.22 + 0.08);
  EXPECT_LT((there.normal - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT(there.spread, 1e-12);
  EXPECT_NEAR(surroundings(roof(20, radians(8)), network, 0, {0, 0.5, 0}, 0.3).spread, radians(4),
              radians(0.05));
  ASSERT_EQ(there.network.curves.size(), 1u);
  EXPECT_EQ(there.network.curves[0].vertices, (std::vector<int>{3, 4, 5, 6, 7}));
  EXPECT_THROW(surroundings(mesh, network, 0, {9, 9, 9}, 0.1), InvalidInput);
}

}  // namespace
}  // namespace batten
