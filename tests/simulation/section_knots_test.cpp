#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/simulation/section_knots_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

Vector3d on_circle(double angle) {
  return {std::cos(angle), std::sin(angle), 0};
}

/// A polyline around the unit circle, all of it or the first part.
MeshPolyline arc(int n, double angle) {
  MeshPolyline line;
  line.closed = angle == 2 * kPi;
  for (int k = 0; k < n + (line.closed ? 0 : 1); ++k) {
    line.points.push_back(on_circle(angle * k / n));
    line.normals.push_back(line.points.back());
  }
  return line;
}

TEST(SectionKnots, AreEvenBetweenCrossingsWhichAreAllAmongThem) {
  const MeshPolyline line = arc(360, 2 * kPi);
  const std::vector<MeshCrossing> crossings = {{on_circle(0.3), on_circle(0.3)},
                                               {on_circle(2.1), on_circle(2.1)}};
  const auto place_of = [](double angle, int node) {
    const double piece = angle * 180 / kPi;
    return CrossingPlace{static_cast<size_t>(piece), piece - std::floor(piece), node};
  };
  const SectionKnots knots = place_knots(line, {place_of(0.3, 0), place_of(2.1, 1)}, crossings, 0.1);
  // 1.8 and 2π − 1.8 at 0.1 make 18 and 45 pieces.
  ASSERT_EQ(knots.points.size(), 63U);
  EXPECT_EQ(knots.nodes[0], 0);
  EXPECT_EQ(knots.nodes[18], 1);
  EXPECT_EQ(std::count(knots.nodes.begin(), knots.nodes.end(), -1), 61);
  EXPECT_EQ(knots.points[18], crossings[1].position);
  for (size_t i = 0; i < knots.points.size(); ++i) {
    const double angle = i < 18 ? 0.3 + 0.1 * static_cast<double>(i)
                                : 2.1 + (2 * kPi - 1.8) / 45 * (static_cast<double>(i) - 18);
    EXPECT_LT((knots.points[i] - on_circle(angle)).norm(), 2e-4) << i;
  }
}

TEST(SectionKnots, OpenLinesKeepTheirEndsAndClosedOnesThreeKnots) {
  const MeshPolyline open = arc(90, kPi / 2);
  const SectionKnots few = place_knots(open, {}, {}, 10);
  ASSERT_EQ(few.points.size(), 2U);
  EXPECT_LT((few.points[0] - open.points.front()).norm(), 1e-12);
  EXPECT_LT((few.points[1] - open.points.back()).norm(), 1e-12);
  EXPECT_EQ(place_knots(arc(360, 2 * kPi), {}, {}, 10).points.size(), 3U);
}

// Two great circles, through the poles and along the equator, whose normals lean by 0.2 and by −0.1: at both
// crossings the normal that is at right angles to both curves is that of the sphere, and the curves take it
// over. The turns between them are interpolated, so that the lean goes everywhere.
TEST(SectionKnots, NormalsAgreeWhereCurvesCross) {
  constexpr int kKnots = 24;
  std::vector<SectionKnots> knots(2);
  std::vector<std::shared_ptr<SplineCurve>> curves;
  for (int c = 0; c < 2; ++c) {
    for (int i = 0; i < kKnots; ++i) {
      const Vector3d flat = on_circle(2 * kPi * i / kKnots);
      const Vector3d p = c == 0 ? flat : Vector3d(flat.x(), 0, flat.y());
      const Vector3d axis = c == 0 ? Vector3d::UnitZ() : Vector3d::UnitY();
      const double lean = c == 0 ? 0.2 : -0.1;
      knots[static_cast<size_t>(c)].points.push_back(p);
      knots[static_cast<size_t>(c)].normals.emplace_back(std::cos(lean) * p + std::sin(lean) * axis);
      knots[static_cast<size_t>(c)].nodes.push_back(i == 0 ? 0 : i == kKnots / 2 ? 1 : -1);
    }
    curves.push_back(std::make_shared<SplineCurve>(knots[static_cast<size_t>(c)].points, true));
  }
  std::vector<MeshCrossing> crossings = {{Vector3d::UnitX(), Vector3d(1, 0.1, 0.1).normalized()},
                                         {-Vector3d::UnitX(), Vector3d(-1, 0.1, 0.1).normalized()}};
  std::vector<std::string> warnings;
  set_consistent_normals(curves, knots, crossings, warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_LT((crossings[0].normal - Vector3d::UnitX()).norm(), 1e-6);
  EXPECT_LT((crossings[1].normal + Vector3d::UnitX()).norm(), 1e-6);
  for (const auto& curve : curves)
    for (int i = 0; i < kKnots; ++i) {
      const CurvePoint p = curve->at(curve->distance_of_knot(static_cast<size_t>(i)));
      EXPECT_LT((p.normal - p.position).norm(), 1e-6) << i;
    }
}

TEST(SectionKnots, FlatCrossingsAreCounted) {
  std::vector<SectionKnots> knots(2);
  std::vector<std::shared_ptr<SplineCurve>> curves;
  for (int c = 0; c < 2; ++c) {
    const Vector3d along = on_circle(c == 0 ? 0 : radians(14));
    SectionKnots& mine = knots[static_cast<size_t>(c)];
    mine.points = {-along, Vector3d::Zero(), along};
    mine.normals.assign(3, Vector3d::UnitZ());
    mine.nodes = {-1, 0, -1};
    curves.push_back(std::make_shared<SplineCurve>(mine.points, false));
  }
  std::vector<MeshCrossing> crossings = {{Vector3d::Zero(), Vector3d::UnitZ()}};
  std::vector<std::string> warnings;
  set_consistent_normals(curves, knots, crossings, warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].find("1 of 1 crossings are flatter than 15 degrees"), 0U) << warnings[0];
}

}  // namespace
}  // namespace batten::detail
