#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/simulation/section_nodes_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

/// The first part of the unit circle of a plane through the z axis or of the equator, beginning at an angle.
class Arc : public ArcLengthCurve {
 public:
  Arc(const Vector3d& u, const Vector3d& v, double begin, double angle)
      : u_(u), v_(v), begin_(begin), angle_(angle) {}
  double length() const override { return angle_; }
  CurvePoint at(double distance) const override {
    const double c = std::cos(begin_ + distance), s = std::sin(begin_ + distance);
    return {c * u_ + s * v_, c * v_ - s * u_, c * u_ + s * v_};
  }

 private:
  Vector3d u_, v_;
  double begin_, angle_;
};

ImplicitFunction plane(const Vector3d& normal, double offset) {
  return [normal, offset](const Vector3d& x, Vector3d& gradient) {
    gradient = normal;
    return normal.dot(x) - offset;
  };
}

// sin(0.4 + s) = 0.3 at 2 π + asin(0.3) − 0.4 and at π − asin(0.3) − 0.4.
TEST(SectionNodes, PassagesOfACircleAreThoseOfTheClosedForm) {
  const Arc circle(Vector3d::UnitX(), Vector3d::UnitY(), 0.4, 2 * kPi);
  const std::vector<double> found = passages(circle, true, plane({0, 5, 0}, 1.5), 0.1, 1e-9);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0], kPi - std::asin(0.3) - 0.4, 1e-14);
  EXPECT_NEAR(found[1], 2 * kPi + std::asin(0.3) - 0.4, 1e-14);
}

TEST(SectionNodes, APassageAtTheSeamOfAClosedCurveIsFoundOnce) {
  for (const double begin : {-1e-15, 0.0, 1e-15}) {
    const Arc circle(Vector3d::UnitX(), Vector3d::UnitY(), begin, 2 * kPi);
    EXPECT_EQ(passages(circle, true, plane(Vector3d::UnitY(), 0), 0.1, 1e-9).size(), 2U) << begin;
  }
}

// The end is on the plane whatever rounding says: half a circle meets its diameter at both ends.
TEST(SectionNodes, AnOpenCurvePassesAtItsEnds) {
  for (const double nudge : {-1e-12, 0.0, 1e-12}) {
    const Arc half(Vector3d::UnitX(), Vector3d::UnitY(), nudge, kPi);
    const std::vector<double> found = passages(half, false, plane(Vector3d::UnitY(), 0), 0.1, 1e-9);
    ASSERT_EQ(found.size(), 2U) << nudge;
    EXPECT_NEAR(found[0], 0, 1e-9);
    EXPECT_NEAR(found[1], kPi, 1e-9);
  }
}

// Three great circles of the planes x = 0, y = 0, z = 0 meet on the axes. A plane is also passed where its
// own curve is not: the last curve, a short arc, lies in z = 0 and reaches only the positive x axis.
TEST(SectionNodes, NodesAreWhereBothCurvesPass) {
  TracedNetwork traced;
  traced.diameter = 2 * std::sqrt(3.0);
  std::vector<ImplicitFunction> cuts;
  const auto add = [&](int axis, double begin, double angle) {
    TracedCurve curve;
    curve.closed = angle == 2 * kPi;
    curve.path =
        std::make_shared<Arc>(Vector3d::Unit((axis + 1) % 3), Vector3d::Unit((axis + 2) % 3), begin, angle);
    traced.curves.push_back(curve);
    cuts.push_back(plane(Vector3d::Unit(axis), 0));
  };
  add(0, 0.3, 2 * kPi);
  add(1, 0.3, 2 * kPi);
  add(2, -0.3, 0.6);
  const ImplicitFunction sphere = [](const Vector3d& x, Vector3d& gradient) {
    gradient = 2 * x;
    return x.squaredNorm() - 1;
  };
  find_nodes(traced, cuts, sphere);
  ASSERT_EQ(traced.node_positions.rows(), 3);  // ± z of the first two, + x of the last two
  EXPECT_TRUE(traced.node_normals.isApprox(traced.node_positions, 1e-12));
  EXPECT_EQ(traced.curves[0].node_ids.size(), 3U);  // the first of them again
  EXPECT_EQ(traced.curves[1].node_ids.size(), 4U);
  EXPECT_EQ(traced.curves[2].node_ids.size(), 1U);
  EXPECT_NEAR(traced.curves[2].node_distances[0], 0.3, 1e-12);
  for (const TracedCurve& curve : traced.curves)
    for (size_t j = 0; j < curve.node_ids.size(); ++j)
      EXPECT_LT((curve.path->at(curve.node_distances[j]).position -
                 traced.node_positions.row(curve.node_ids[j]).transpose())
                    .norm(),
                1e-12);
}

}  // namespace
}  // namespace batten::detail
