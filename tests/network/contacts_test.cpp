#include "batten/network/contacts.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

/// A network of polylines that share no vertices.
CurveNetwork polylines(const std::vector<std::vector<Vector3d>>& lines) {
  CurveNetwork network;
  std::vector<Vector3d> points;
  for (const std::vector<Vector3d>& line : lines) {
    NetworkCurve curve;
    for (const Vector3d& p : line) {
      curve.vertices.push_back(static_cast<int>(points.size()));
      points.push_back(p);
    }
    network.curves.push_back(curve);
  }
  network.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i)
    network.positions.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  return network;
}

/// From a to b in n steps.
std::vector<Vector3d> line(const Vector3d& a, const Vector3d& b, int n) {
  std::vector<Vector3d> points;
  for (int k = 0; k <= n; ++k) points.push_back(a + (b - a) * k / n);
  return points;
}

// Two straight lines that pass each other at right angles at the height h: one contact, at the known places,
// where h is within the tolerance; none where it is not.
TEST(CurveIndex, FindsWhereLinesPassEachOther) {
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    const double x = 0.1 + 0.8 * random.uniform(), y = 0.1 + 0.8 * random.uniform();
    for (const double h : {0.009, 0.011}) {
      const CurveNetwork network =
          polylines({line({0, y, 0}, {1, y, 0}, 1 + static_cast<int>(random.below(30))),
                     line({x, 0, h}, {x, 1, h}, 1 + static_cast<int>(random.below(30)))});
      const std::vector<Contact> contacts = CurveIndex(network, 0.01).contacts();
      if (h > 0.01) {
        EXPECT_TRUE(contacts.empty());
        continue;
      }
      ASSERT_EQ(contacts.size(), 1u) << i;
      EXPECT_LT((contacts[0].first.point - Vector3d(x, y, 0)).norm(), 1e-9);
      EXPECT_LT((contacts[0].second.point - Vector3d(x, y, h)).norm(), 1e-9);
      EXPECT_NEAR(contacts[0].distance, h, 1e-12);
      EXPECT_FALSE(contacts[0].joined);
    }
  }
}

// Ends beyond the other line: the nearest places are the end and its foot, whichever segment it is.
TEST(CurveIndex, FindsEndsThatStopShortOfALine) {
  for (const double gap : {-0.004, 0.004})
    for (const bool swapped : {false, true}) {
      std::vector<Vector3d> stem = line({0.3, 1, 0}, {0.3, std::abs(gap), 0}, 7);
      for (Vector3d& p : stem) p.y() = std::copysign(p.y(), gap);
      if (swapped) std::reverse(stem.begin(), stem.end());
      const CurveNetwork network = polylines({line({0, 0, 0}, {1, 0, 0}, 3), stem});
      const std::vector<Contact> contacts = CurveIndex(network, 0.005).contacts();
      ASSERT_EQ(contacts.size(), 1u);
      EXPECT_LT((contacts[0].first.point - Vector3d(0.3, 0, 0)).norm(), 1e-12);
      EXPECT_NEAR(contacts[0].distance, std::abs(gap), 1e-12);
      // The same by the search from the end.
      const auto nearest =
          CurveIndex(network, 0.005).nearest_other(1, !swapped, std::numeric_limits<double>::infinity());
      ASSERT_TRUE(nearest.has_value());
      EXPECT_EQ(nearest->curve, 0);
      EXPECT_LT((nearest->point - Vector3d(0.3, 0, 0)).norm(), 1e-12);
    }
}

// Two lines side by side over a known way: its length is told, and at both ends what is within the tolerance
// of the shorter line's end.
TEST(CurveIndex, MeasuresHowLongCurvesStayTogether) {
  const CurveNetwork network =
      polylines({line({0, 0, 0}, {1, 0, 0}, 200), line({0.25, 0.002, 0}, {0.75, 0.002, 0}, 90)});
  const std::vector<Contact> contacts = CurveIndex(network, 0.005).contacts();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].length, 0.5 + 2 * std::sqrt(0.005 * 0.005 - 0.002 * 0.002), 1e-6);
}

// From the end of a curve the nearest other curve is found however far it is, unless it is beyond reach; what
// shares the end's vertex does not count.
TEST(CurveIndex, LooksFromAnEndAsFarAsItIsTold) {
  CurveNetwork network = polylines({line({0, 0, 0}, {1, 0, 0}, 10), line({1, 3, 0}, {2, 3, 0}, 10)});
  const double infinity = std::numeric_limits<double>::infinity();
  const auto far = CurveIndex(network, 1e-3).nearest_other(0, true, infinity);
  ASSERT_TRUE(far.has_value());
  EXPECT_EQ(far->curve, 1);
  EXPECT_LT((far->point - Vector3d(1, 3, 0)).norm(), 1e-12);
  EXPECT_FALSE(CurveIndex(network, 1e-3).nearest_other(0, true, 2.9).has_value());
  EXPECT_TRUE(CurveIndex(network, 1e-3).nearest_other(0, true, 3.1).has_value());
  for (const bool begins_there : {false, true}) {
    CurveNetwork joined = network;
    joined.curves.push_back({"", false, begins_there ? std::vector<int>{10, 5} : std::vector<int>{5, 10}});
    const auto other = CurveIndex(joined, 1e-3).nearest_other(0, true, infinity);
    ASSERT_TRUE(other.has_value());
    EXPECT_EQ(other->curve, 1) << "the third shares the end";
  }
}

// A curve is always near itself where it goes on; only a place that is much further along it counts.
TEST(CurveIndex, TakesALaterPartOfTheSameCurveForAnother) {
  std::vector<Vector3d> hook = line({0, 0, 0}, {1, 0, 0}, 50);
  for (const Vector3d& p : line({1, 0.1, 0}, {0.2, 0.1, 0}, 40)) hook.push_back(p);
  const CurveNetwork network = polylines({hook});
  const auto nearest = CurveIndex(network, 1e-3).nearest_other(0, true, 1);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_LT((nearest->point - Vector3d(0.2, 0, 0)).norm(), 1e-9);
}

// Arc lengths of a circle's polygon, and no contact of a closed curve with itself at its seam.
TEST(CurveIndex, ClosedCurvesDoNotMeetThemselvesAtTheirSeam) {
  std::vector<Vector3d> circle;
  const int n = 720;
  for (int k = 0; k < n; ++k) circle.emplace_back(std::cos(2 * kPi * k / n), std::sin(2 * kPi * k / n), 0);
  CurveNetwork network = polylines({circle});
  network.curves[0].vertices.push_back(0);
  const CurveIndex index(network, 0.05);
  EXPECT_TRUE(index.contacts().empty());
  EXPECT_NEAR(index.length(0), 2 * n * std::sin(kPi / n), 1e-12);
  EXPECT_NEAR(index.arc(0, n / 2), n * std::sin(kPi / n), 1e-12);
}

// A vertex that two curves share joins them wherever it is among their samples: nothing is left to mend.
TEST(CurveIndex, KnowsASharedVertexBetweenDenseSamples) {
  CurveNetwork network =
      polylines({line({0, 0, 0}, {1, 0, 0}, 200), line({0.5, -0.5, 0}, {0.5, 0.5, 0}, 200)});
  network.curves[1].vertices[100] = 100;
  const std::vector<Contact> contacts = CurveIndex(network, 0.03).contacts();
  EXPECT_FALSE(contacts.empty());
  for (const Contact& contact : contacts) EXPECT_TRUE(contact.joined) << contact.first.point.transpose();
}

// The search goes over thinned edges, here 5 mm beside the curve; what it finds is on the curve itself.
TEST(CurveIndex, FindsThePlaceOnTheCurveAndNotOnTheThinnedOne) {
  std::vector<Vector3d> half;
  for (int k = 0; k <= 2000; ++k) half.emplace_back(std::cos(kPi * k / 2000), std::sin(kPi * k / 2000), 0);
  const Vector3d p(std::cos(0.9), std::sin(0.9), 0), t(-p.y(), p.x(), 0);
  const Vector3d oblique = 0.5 * t + std::sqrt(0.75) * p, up(0, 0, 0.003);  // at 60 degrees
  const CurveNetwork network = polylines({half, line(p - 0.5 * oblique + up, p + 0.5 * oblique + up, 1000)});
  const std::vector<Contact> contacts = CurveIndex(network, 0.2).contacts();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].first.point - p).norm(), 2e-4);
  EXPECT_NEAR(contacts[0].distance, 0.003, 1e-5);
}

// Lines that cross at right angles are within the tolerance of each other for twice that length, whether
// their edges are longer or shorter than it.
TEST(CurveIndex, LongEdgesThatCrossAreNearEachOtherOnlyAtTheCrossing) {
  for (const int n : {1, 7, 200}) {
    const CurveNetwork network =
        polylines({line({0, 0, 0}, {1, 0, 0}, n), line({0.5, -0.5, 0}, {0.5, 0.5, 0}, n)});
    const std::vector<Contact> contacts = CurveIndex(network, 0.01).contacts();
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].length, 0.02, 1e-6) << n;
  }
}

// Of two places equally far from an end the one on the first curve, however the search comes by.
TEST(CurveIndex, TakesTheFirstOfTwoPlacesEquallyFar) {
  for (const double side : {1.0, -1.0}) {
    const CurveNetwork network =
        polylines({line({0, 0, 0}, {1, 0, 0}, 4), line({0, side, 0}, {2, side, 0}, 8),
                   line({0, -side, 0}, {2, -side, 0}, 8)});
    const auto nearest = CurveIndex(network, 1e-3).nearest_other(0, true, 10);
    ASSERT_TRUE(nearest.has_value());
    EXPECT_EQ(nearest->curve, 1);
    EXPECT_EQ(nearest->point, Vector3d(1, side, 0));
  }
}

}  // namespace
}  // namespace batten::detail
