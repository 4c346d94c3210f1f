#include "batten/mesh/predicates.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace batten
