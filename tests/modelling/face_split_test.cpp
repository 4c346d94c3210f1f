#include "sketch/straight_sides.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/face_split_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

/// Straight sides between corners, sampled for so many splits.
std::vector<Points> split_sides(const std::vector<Vector3d>& corners, int splits) {
  return test::straight_sides(corners, 1 << splits);
}

double twice_area(const FaceSplit& split, const std::array<int, 3>& t) {
  const Eigen::RowVector2d a = split.domain.row(t[0]), b = split.domain.row(t[1]), c = split.domain.row(t[2]);
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// The area of the domain, and that no triangle of it is folded.
double area(const FaceSplit& split) {
  double sum = 0;
  for (const std::array<int, 4>& quad : split.quads)
    for (const std::array<int, 3>& triangle : cut_along_corners(quad)) {
      EXPECT_GT(twice_area(split, triangle), 0);
      sum += twice_area(split, triangle) / 2;
    }
  return sum;
}

const std::vector<Vector3d> kCross = {{1, -1, 0},  {3, -1, 0},  {3, 1, 0},   {1, 1, 0},
                                      {1, 3, 0},   {-1, 3, 0},  {-1, 1, 0},  {-3, 1, 0},
                                      {-3, -1, 0}, {-1, -1, 0}, {-1, -3, 0}, {1, -3, 0}};

TEST(FaceSplit, ConvexFacesMakeFourToTheSplitsQuarterQuadsPerSide) {
  // H 6.4: 16 n quads with three splits.
  for (const int n : {3, 4, 5, 7}) {
    std::vector<Vector3d> corners;
    for (int k = 0; k < n; ++k)
      corners.emplace_back(std::cos(2 * kPi * k / n), std::sin(2 * kPi * k / n), 0.1 * (k % 2));
    for (const int splits : {1, 2, 3, 4}) {
      const FaceSplit split = split_face_into_quads(split_sides(corners, splits), splits);
      EXPECT_EQ(split.quads.size(), static_cast<size_t>(n) << (2 * splits - 2));
      EXPECT_EQ(split.n_pieces, 1);
      EXPECT_EQ(split.n_boundary, n << splits);
      area(split);
    }
  }
}

TEST(FaceSplit, ConcaveCornersAreCutOff) {
  // The top of the cross of H fig. 3.2: a bar and two arms at least, a middle and four arms at most; the area
  // is that of the drawing.
  const FaceSplit cross = split_face_into_quads(split_sides(kCross, 3), 3);
  EXPECT_GE(cross.n_pieces, 3);
  EXPECT_LE(cross.n_pieces, 5);
  EXPECT_TRUE(cross.is_projection);
  EXPECT_NEAR(area(cross), 20, 1e-9);
  // An L: two pieces.
  const FaceSplit corner = split_face_into_quads(
      split_sides({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 2), 2);
  EXPECT_EQ(corner.n_pieces, 2);
  EXPECT_NEAR(area(corner), 5, 1e-9);
}

TEST(FaceSplit, ManyConcaveCornersGiveAValidLayout) {
  // A comb, and a star with deep bays: no triangle may be folded, and the areas are those of the polygons.
  std::vector<Vector3d> comb{{0, 0, 0}, {9, 0, 0}};
  for (int k = 4; k >= 0; --k) {
    comb.emplace_back(2 * k + 1, 3, 0);
    comb.emplace_back(2 * k, 3, 0);
    if (k > 0) {
      comb.emplace_back(2 * k, 1, 0);
      comb.emplace_back(2 * k - 1, 1, 0);
    }
  }
  EXPECT_NEAR(area(split_face_into_quads(split_sides(comb, 3), 3)), 9 + 5 * 2, 1e-9);
  std::vector<Vector3d> star;
  for (int k = 0; k < 14; ++k) {
    const double radius = k % 2 ? 0.3 : 1, turn = kPi * k / 7;
    star.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 0);
  }
  EXPECT_NEAR(area(split_face_into_quads(split_sides(star, 3), 3)), 7 * 0.3 * std::sin(kPi / 7), 1e-9);
}

TEST(FaceSplit, LoopsThatOverlapInTheirPlaneAreLaidOutOnADisc) {
  // Random closed polygons in space, most of them knotted in every projection: the layout is valid all the
  // same.
  Random random(7);
  int discs = 0;
  for (int k = 0; k < 60; ++k) {
    std::vector<Vector3d> corners;
    const int n = 3 + k % 6;
    for (int i = 0; i < n; ++i)
      corners.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const FaceSplit split = split_face_into_quads(split_sides(corners, 2), 2);
    discs += !split.is_projection;
    area(split);
  }
  EXPECT_GT(discs, 5);
  EXPECT_LT(discs, 60);
}

TEST(FaceSplit, HalfTubesAreUnrolledToRectangles) {
  // A half cylinder, radius 1, seen from nowhere without foreshortening: its layout is the rectangle of its
  // sides, however flat.
  for (const double height : {0.1, 0.3, 1.0, 8.0}) {
    std::vector<Points> sides(4, Points(9, 3));
    for (int i = 0; i <= 8; ++i) {
      const double t = i / 8.0, turn = kPi * t;
      sides[0].row(i) << std::cos(turn), std::sin(turn), 0;
      sides[1].row(i) << -1, 0, height * t;
      sides[2].row(i) << -std::cos(turn), std::sin(turn), height;
      sides[3].row(i) << 1, 0, height * (1 - t);
    }
    const double width = 16 * std::sin(kPi / 16);  // of the polygon of eight segments
    const FaceSplit split = split_face_into_quads(sides, 3);
    EXPECT_FALSE(split.is_projection);
    EXPECT_NEAR(area(split), width * height, 1e-9 * width * height);
  }
}

TEST(FaceSplit, FollowsRotationAndScale) {
  // Axes and units play no part: the same quads, and a domain of the same shape.
  Eigen::Matrix3d turn;
  turn = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized());
  std::vector<Vector3d> moved;
  for (const Vector3d& corner : kCross) moved.push_back(1000 * (turn * corner) + Vector3d(5, 6, 7));
  const FaceSplit one = split_face_into_quads(split_sides(kCross, 2), 2),
                  other = split_face_into_quads(split_sides(moved, 2), 2);
  EXPECT_EQ(one.quads.size(), other.quads.size());
  EXPECT_EQ(one.n_pieces, other.n_pieces);
  EXPECT_NEAR(area(other), 1e6 * area(one), 1e-3);
}

/// The sides of a face of height 1 that goes so far around a tube of radius 1.
std::vector<Points> sides_around_a_tube(double angle, int splits) {
  const int m = 1 << splits;
  const std::vector<Eigen::Vector2d> corners{{0, 0}, {angle, 0}, {angle, 1}, {0, 1}};
  std::vector<Points> sides;
  for (size_t k = 0; k < 4; ++k) {
    Points side(m + 1, 3);
    for (int i = 0; i <= m; ++i) {
      const Eigen::Vector2d p = corners[k] + (corners[(k + 1) % 4] - corners[k]) * i / m;
      side.row(i) << std::cos(p.x()), std::sin(p.x()), p.y();
    }
    sides.push_back(side);
  }
  return sides;
}

// Half a cylinder between two half circles has its rectangle, as ever.
TEST(FaceSplit, PlainHalfTubesAreNotUnrolled) {
  EXPECT_FALSE(split_face_into_quads(sides_around_a_tube(kPi, 3), 3).is_unrolled);
}

// A face that goes nine tenths around a tube and comes near to itself there: no convex polygon keeps its ends
// as near, and its own plane folds it. Unrolled it is the rectangle of 1.8 π times the height.
TEST(FaceSplit, UnrollsAFaceThatNearlyClosesAroundATube) {
  const double width = 1.8 * kPi;
  const FaceSplit split = split_face_into_quads(sides_around_a_tube(width, 4), 4);
  EXPECT_TRUE(split.is_unrolled);
  double twice_area = 0;
  for (int i = 0; i < split.n_boundary; ++i) {
    const Eigen::RowVector2d a = split.domain.row(i), b = split.domain.row((i + 1) % split.n_boundary);
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_NEAR(twice_area / 2, width, 0.01 * width);  // chords are a little shorter than their arcs
}

}  // namespace
}  // namespace batten::detail
