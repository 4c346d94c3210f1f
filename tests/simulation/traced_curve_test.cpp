#include "batten/simulation/traced_curve.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

ImplicitFunction ellipsoid(const Vector3d& axes) {
  return [axes](const Vector3d& x, Vector3d& gradient) {
    gradient = 2 * x.cwiseQuotient(axes.cwiseAbs2());
    return x.cwiseQuotient(axes).squaredNorm() - 1;
  };
}

ImplicitFunction horizontal_plane(double z) {
  return [z](const Vector3d& x, Vector3d& gradient) {
    gradient = Vector3d::UnitZ();
    return x.z() - z;
  };
}

TraceRequest ellipse_request(double a, double b, double step) {
  TraceRequest request;
  request.surface = ellipsoid({a, b, 1});
  request.cut = horizontal_plane(0);
  request.start = {a, 0, 0};
  request.towards = {0, 1, 0};
  request.step = step;
  return request;
}

// The perimeter of an ellipse is 4 a E(e), the complete elliptic integral of the second kind.
TEST(TraceIntersection, LengthOfAnEllipseIsTheEllipticIntegral) {
  const double a = 2;
  const double b = 0.5;
  const double exact = 4 * a * std::comp_ellint_2(std::sqrt(1 - b * b / (a * a)));
  // The radius of curvature goes down to b²/a = 0.125.
  EXPECT_NEAR(trace_intersection(ellipse_request(a, b, 0.01))->length(), exact, 1e-11 * exact);
}

// On the unit circle the point at distance s is (cos s, sin s), whatever the step.
TEST(TraceIntersection, PointsOfACircleStandAtTheirArcLength) {
  for (const double step : {0.003, 0.02, 0.3}) {
    const auto circle = trace_intersection(ellipse_request(1, 1, step));
    EXPECT_NEAR(circle->length(), 2 * kPi, step < 0.1 ? 1e-12 : 1e-8);
    for (const double s : {0.0, 0.001, 1.0, 3.0, 6.28}) {
      const CurvePoint p = circle->at(s);
      const double tolerance = step < 0.1 ? 1e-12 : 1e-8;
      EXPECT_LT((p.position - Vector3d(std::cos(s), std::sin(s), 0)).norm(), tolerance);
      EXPECT_LT((p.tangent - Vector3d(-std::sin(s), std::cos(s), 0)).norm(), tolerance);
      EXPECT_LT((p.normal - p.position).norm(), 1e-12);
    }
  }
}

TEST(TraceIntersection, AnOpenCurveEndsWhereItIsTold) {
  TraceRequest request = ellipse_request(1, 1, 0.01);
  request.closed = false;
  request.end = {0, 1, 0};
  const auto quarter = trace_intersection(request);
  EXPECT_NEAR(quarter->length(), kPi / 2, 1e-13);
  EXPECT_LT((quarter->at(quarter->length()).position - request.end).norm(), 1e-13);
  // Distances beyond the ends are moved to them.
  EXPECT_LT((quarter->at(-1).position - request.start).norm(), 1e-13);
  EXPECT_LT((quarter->at(99).position - request.end).norm(), 1e-13);
}

TEST(TraceIntersection, RefusesWhatCannotBeTraced) {
  TraceRequest request = ellipse_request(1, 1, 0);
  EXPECT_THROW(trace_intersection(request), InvalidInput);
  request = ellipse_request(1, 1, 0.01);
  request.cut = horizontal_plane(1);  // touches the sphere in one point
  EXPECT_THROW(trace_intersection(request), InvalidInput);
  request.cut = horizontal_plane(2);  // misses it
  EXPECT_THROW(trace_intersection(request), InvalidInput);
}

/// Two quarter circles from (1, 0, 0) to (0, 1, 0) and on to (−1, 0, 0).
TracedNetwork half_circle() {
  TracedNetwork traced;
  traced.diameter = 2;
  traced.node_positions.resize(1, 3);
  traced.node_positions << 0, 1, 0;
  traced.node_normals = traced.node_positions;
  TraceRequest request = ellipse_request(1, 1, 0.01);
  request.closed = false;
  request.end = {-1, 0, 0};
  TracedCurve curve;
  curve.name = "half";
  curve.path = trace_intersection(request);
  curve.node_distances = {kPi / 2};
  curve.node_ids = {0};
  traced.curves.push_back(curve);
  return traced;
}

// The sagitta of a chord of length h on a circle of radius 1 is h²/8: the distance between the polyline and
// the curve falls with the square of the step.
TEST(TruthNetwork, FollowsTheCurveWithinTheSagitta) {
  for (const double step : {0.1, 0.01, 0.001}) {
    const CurveNetwork network = truth_network(half_circle(), step);
    ASSERT_EQ(network.curves.size(), 1U);
    const std::vector<int>& walk = network.curves[0].vertices;
    double worst = 0;
    for (size_t i = 0; i + 1 < walk.size(); ++i) {
      const Vector3d a = network.positions.row(walk[i]);
      const Vector3d b = network.positions.row(walk[i + 1]);
      EXPECT_LE((b - a).norm(), step);
      worst = std::max(worst, 1 - ((a + b) / 2).norm());
    }
    EXPECT_LT(worst, step * step / 8);
    EXPECT_GT(worst, 0.5 * step * step / 8);  // no finer than asked for
    EXPECT_EQ(network.normals.rows(), network.positions.rows());
    EXPECT_LT((network.normals - network.positions).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(TruthNetwork, NodesComeFirst) {
  const CurveNetwork network = truth_network(half_circle(), 0.1);
  EXPECT_EQ((network.positions.row(0) - Eigen::RowVector3d(0, 1, 0)).norm(), 0);
  EXPECT_EQ(std::count(network.curves[0].vertices.begin(), network.curves[0].vertices.end(), 0), 1);
  EXPECT_THROW(truth_network(half_circle(), 0), InvalidInput);
}

}  // namespace
}  // namespace batten
