#include "batten/mesh/predicates.hpp"

#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

// A point exactly on the plane of three others (all coordinates are small integers over a power of two), and
// the nearest doubles on both sides: plain arithmetic cannot tell them apart, exact arithmetic must.
TEST(Orient3d, IsExactWhereRoundingHidesTheSign) {
  const Eigen::Vector3d a(12, 12, 12), b(24, 24, 25), c(12.5, 24, 13);
  for (int i = -8; i <= 8; ++i) {
    // the plane point a + (b − a)/2 + (c − a)/2 is representable; move it by i ulps along z
    Eigen::Vector3d d = a + (b - a) / 2 + (c - a) / 2;
    d.z() += i * std::ldexp(1.0, -48);
    const int expected = (i > 0) - (i < 0);
    const double side = (b - a).cross(c - a).z() > 0 ? 1 : -1;
    EXPECT_EQ(orient3d(a, b, c, d), side * expected) << i;
  }
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, 0}), 0);
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, 1e-300}), 1);
}

// Integers of 18 bits: the determinant fits into 64 bits, where it is exact, and not into the 53 of a double.
// Points rounded to a plane through three others have one of a few units, with either sign or none.
TEST(Orient3d, HasTheSignOfTheDeterminantInIntegers) {
  Random random(21);
  using Integers = Eigen::Matrix<std::int64_t, 3, 1>;
  const auto any = [&] {
    Integers p;
    for (int k = 0; k < 3; ++k) p[k] = static_cast<std::int64_t>(random.below(1 << 18));
    return p;
  };
  int signs[3] = {0, 0, 0};
  for (int i = 0; i < 20000; ++i) {
    const Integers a = any(), b = any(), c = any();
    const double s = random.uniform(), t = random.uniform();
    Integers d;
    for (int k = 0; k < 3; ++k)
      d[k] = a[k] + std::llround(s * static_cast<double>(b[k] - a[k]) + t * static_cast<double>(c[k] - a[k]));
    // Along a line of the plane, where one triple is a combination of the others: exactly in it.
    if (i % 4 == 0) d = b + c - a;
    const Integers u = b - a, v = c - a, w = d - a;
    const std::int64_t determinant = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
                                     u[2] * (v[0] * w[1] - v[1] * w[0]);
    const int expected = (determinant > 0) - (determinant < 0);
    ++signs[expected + 1];
    ASSERT_EQ(orient3d(a.cast<double>(), b.cast<double>(), c.cast<double>(), d.cast<double>()), expected)
        << determinant;
  }
  for (const int n : signs) EXPECT_GT(n, 1000);
}

// 0.1 + k·2⁻⁵³ along a diagonal: the classic grid on which the plain formula gives wrong signs. Swapping two
// points must always turn the sign round, and a cyclic change must keep it.
TEST(Orient2d, IsConsistentOnNearlyCollinearPoints) {
  const Eigen::Vector2d b(12, 12), c(24, 24);
  int zeros = 0;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j) {
      const Eigen::Vector2d a(0.5 + i * std::ldexp(1.0, -53), 0.5 + j * std::ldexp(1.0, -53));
      const int s = orient2d(a, b, c);
      EXPECT_EQ(s, orient2d(b, c, a));
      EXPECT_EQ(s, -orient2d(b, a, c));
      EXPECT_EQ(s, (a.y() > a.x()) - (a.y() < a.x()));  // b and c lie on x = y, left of it is y > x
      zeros += s == 0;
    }
  EXPECT_GE(zeros, 32);
}

// The closed triangle: through its inside, through a side and through a corner, also where the segment ends
// there; past them by the smallest number that makes a difference it is missed.
TEST(SegmentMeetsTriangle, TakesSidesAndCornersForPartsOfIt) {
  const Eigen::Vector3d a(0, 0, 0), b(4, 0, 0), c(0, 4, 0), up(0, 0, 1);
  const auto meets = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    const bool found = segment_meets_triangle(p, q, a, b, c);
    EXPECT_EQ(segment_meets_triangle(q, p, a, b, c), found);
    EXPECT_EQ(segment_meets_triangle(p, q, b, c, a), found);
    EXPECT_EQ(segment_meets_triangle(p, q, a, c, b), found);
    return found;
  };
  const auto through = [&](const Eigen::Vector3d& at) { return meets(at - up, at + 2 * up); };
  EXPECT_TRUE(through({1, 1, 0}));
  EXPECT_TRUE(through({2, 0, 0}));
  EXPECT_TRUE(through({2, 2, 0}));
  EXPECT_TRUE(through(b));
  EXPECT_TRUE(through(a));
  EXPECT_FALSE(through({2, -1e-300, 0}));
  EXPECT_FALSE(through({2, std::nextafter(2, 3), 0}));
  EXPECT_FALSE(through({std::nextafter(4, 5), 0, 0}));
  EXPECT_TRUE(meets({1, 1, 0}, {1, 1, 5}));
  EXPECT_FALSE(meets({1, 1, 1e-300}, {1, 1, 5}));
  // Within the plane: across, touching a corner, inside and beside it.
  EXPECT_TRUE(meets({-1, 1, 0}, {5, 1, 0}));
  EXPECT_TRUE(meets({4, -1, 0}, {4, 1, 0}));
  EXPECT_TRUE(meets({1, 1, 0}, {1.5, 1, 0}));
  EXPECT_TRUE(meets({1, 0, 0}, {2, 0, 0}));
  EXPECT_FALSE(meets({5, 0, 0}, {6, 0, 0}));
  EXPECT_FALSE(meets({3, 3, 0}, {5, 1, 0}));
}

}  // namespace
}  // namespace batten
