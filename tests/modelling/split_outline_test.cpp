#include "sketch/strokes.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/modelling/split_outline_detail.hpp"

namespace batten {
namespace {

using detail::SplitOutline;
using namespace strokes;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<SharedPolyline> sides_of(const std::vector<Vector3d>& corners) {
  std::vector<SharedPolyline> sides;
  for (size_t k = 0; k < corners.size(); ++k)
    sides.push_back(std::make_shared<Polyline>(polygon({corners[k], corners[(k + 1) % corners.size()]})));
  return sides;
}

/// The letter L, with the reflex corner (1, 1) as number 3.
std::vector<SharedPolyline> letter() {
  return sides_of({kO, 2 * kX, 2 * kX + kY, kX + kY, kX + 2 * kY, 2 * kY});
}

TEST(SplitOutline, KnowsReflexCornersAndDiagonalsThatLeaveTheFace) {
  const SplitOutline l(letter());
  EXPECT_TRUE(l.is_simple());
  EXPECT_TRUE(l.has_reflex_corner());
  EXPECT_EQ(l.flaws_of_diagonal(0, 3), 0) << "inside";
  EXPECT_EQ(l.flaws_of_diagonal(0, 1), 0) << "a side";
  EXPECT_EQ(l.flaws_of_diagonal(2, 4), 3) << "outside, over the bay";
  EXPECT_FALSE(SplitOutline(sides_of({kO, kX, kX + kY, kY})).has_reflex_corner());
}

// A square has four right angles, as a regular part of four corners has, and lies in the plane of its face.
// Half of it has angles of 90, 45 and 45 degrees instead of 60 each: (30 + 15 + 15) / 3 = 20.
TEST(SplitOutline, PartsCostWhatTheirAnglesMiss) {
  const SplitOutline square(sides_of({kO, kX, kX + kY, kY}));
  const std::array<int, 4> whole{0, 1, 2, 3};
  EXPECT_EQ(square.cost_of_part(whole.data(), 4).flaws, 0);
  EXPECT_NEAR(square.cost_of_part(whole.data(), 4).angle(), 0, 1e-9);
  const std::array<int, 3> half{0, 1, 2}, turned{2, 1, 0};
  EXPECT_NEAR(square.cost_of_part(half.data(), 3).shape, radians(20.0), 1e-9);
  EXPECT_GE(square.cost_of_part(turned.data(), 3).flaws, 2) << "turned over";
}

// Heights come back where the outline lies on a quadric: z = x² − y² over a square.
TEST(SplitOutline, LiftsDiagonalsOntoTheQuadricOfTheOutline) {
  std::vector<SharedPolyline> sides;
  const std::array<Vector2d, 4> corners{Vector2d(1, 1), Vector2d(-1, 1), Vector2d(-1, -1), Vector2d(1, -1)};
  for (size_t k = 0; k < 4; ++k) {
    Points points(41, 3);
    for (int i = 0; i <= 40; ++i) {
      const Vector2d q = corners[k] + i / 40.0 * (corners[(k + 1) % 4] - corners[k]);
      points.row(i) << q.x(), q.y(), 0.3 * (q.x() * q.x() - q.y() * q.y());
    }
    sides.push_back(std::make_shared<Polyline>(points));
  }
  const SplitOutline saddle(sides);
  const Points line = saddle.lifted(saddle.flat({1, 0, 0}), saddle.flat({-1, 0, 0}), 8);
  ASSERT_EQ(line.rows(), 9);
  for (int k = 0; k <= 8; ++k) EXPECT_NEAR(line(k, 2), 0.3 * line(k, 0) * line(k, 0), 2e-3) << k;
}

TEST(SplitOutline, CurvesLeaveTheFaceOverTheBay) {
  const SplitOutline l(letter());
  EXPECT_FALSE(l.leaves(polygon({kO, kX + kY})));
  EXPECT_TRUE(l.leaves(polygon({2 * kX + kY, kX + 2 * kY})));
}

}  // namespace
}  // namespace batten
