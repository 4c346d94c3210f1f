#include "batten/modelling/triquadrification.hpp"

#include "modelling/sides_over.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace test;

/// The outline of H fig. 3.2.
const std::vector<Vector2d> kCross{{1, -1}, {3, -1}, {3, 1},   {1, 1},   {1, 3},   {-1, 3},
                                   {-1, 1}, {-3, 1}, {-3, -1}, {-1, -1}, {-1, -3}, {1, -3}};

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double area(const std::vector<Vector2d>& polygon) {
  double sum = 0;
  for (size_t k = 0; k < polygon.size(); ++k) sum += cross(polygon[k], polygon[(k + 1) % polygon.size()]) / 2;
  return sum;
}

/// Whether parts cover a plane polygon without overlap or fold. Parts of positive corners whose areas add up
/// to that of the polygon cover every point as often as the outline winds around it: once.
void expect_fair_division(const std::vector<Vector2d>& corners, const FaceSplit& split, bool convex = true) {
  double sum = 0;
  size_t n_sides = 0;
  for (const std::vector<int>& part : split.parts) {
    std::vector<Vector2d> polygon;
    for (const int c : part) polygon.push_back(corners[static_cast<size_t>(c)]);
    const size_t n = polygon.size();
    ASSERT_TRUE(n == 3 || n == 4);
    n_sides += n - 2;
    EXPECT_GT(area(polygon), 0);
    sum += area(polygon);
    for (size_t k = 0; convex && k < n; ++k) {
      const Vector2d next = polygon[(k + 1) % n] - polygon[k], last = polygon[(k + n - 1) % n] - polygon[k];
      EXPECT_GT(cross(next, last),
                -0.18 * next.norm() * last.norm());  // sin of the 10 degrees that are let be
    }
  }
  EXPECT_EQ(n_sides, corners.size() - 2);
  EXPECT_NEAR(sum, area(corners), 1e-12 * std::abs(sum));
}

TEST(SplitFace, DividesTheCrossIntoFiveSquares) {
  // Whatever its first corner, its place and its orientation in space.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  for (size_t first = 0; first < 12; ++first) {
    std::vector<Vector2d> corners = kCross;
    std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first), corners.end());
    const FaceSplit split = split_face(sides_over(
        [&](const Vector2d& p) { return Vector3d(100 * turn * flat(p) + Vector3d(7, 8, 9)); }, corners));
    EXPECT_EQ(split.cost.flaws, 0);
    EXPECT_EQ(split.parts.size(), 5u);
    EXPECT_LT(split.cost.planarity + split.cost.shape, 1e-6);
    expect_fair_division(corners, split);
  }
}

/// A polygon around the origin with corners at random distances: star-shaped, mostly far from convex.
std::vector<Vector2d> star_polygon(Random& random, int n) {
  std::vector<Vector2d> corners;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * (k + 0.3 * random.uniform()) / n, radius = 0.4 + random.uniform();
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return corners;
}

// Every simple polygon has a triangulation, so the search must find a division without flaws; where the
// greedy one has none it fails to. Both are measured by the same cost.
TEST(SplitFace, OptimalIsSoundOnNonConvexFacesAndNeverWorseThanGreedy) {
  Random random(7);
  int n_faces = 0, greedy_flawed = 0, optimal_flawed = 0, better = 0, both_sound = 0;
  double greedy_cost = 0, optimal_cost = 0;
  for (int n = 5; n <= 16; ++n)
    for (int k = 0; k < 25; ++k) {
      const std::vector<Vector2d> corners = star_polygon(random, n);
      const auto sides = sides_over(flat, corners, 8);
      const FaceSplit optimal = split_face(sides), greedy = split_face(sides, SplitSearch::Greedy);
      ++n_faces;
      optimal_flawed += optimal.cost.flaws > 0;
      greedy_flawed += greedy.cost.flaws > 0;
      if (optimal.cost.flaws == 0) expect_fair_division(corners, optimal);
      EXPECT_TRUE(
          optimal.cost.flaws < greedy.cost.flaws ||
          (optimal.cost.flaws == greedy.cost.flaws && optimal.cost.angle() <= greedy.cost.angle() + 1e-6));
      if (greedy.cost.flaws == 0) {
        ++both_sound;
        greedy_cost += greedy.cost.angle();
        optimal_cost += optimal.cost.angle();
        better += optimal.cost.angle() < 0.99 * greedy.cost.angle();
      }
    }
  std::cout << n_faces << " plane faces: flaws with the greedy search in " << greedy_flawed << ", optimal in "
            << optimal_flawed << "; where both are sound (" << both_sound << ") mean cost "
            << greedy_cost / both_sound << " and " << optimal_cost / both_sound
            << ", the optimal one better in " << better << '\n';
  EXPECT_LE(optimal_flawed, n_faces / 50);  // diagonals within two hundredths of the border count as flaws
  EXPECT_GT(greedy_flawed, 10 * (optimal_flawed + 1));
  EXPECT_GT(better, 0);
}

/// All divisions of a polygon of corners, each once: the part at the side from the last to the first corner
/// and the divisions of what it leaves.
void all_divisions(const std::vector<int>& corners, const std::vector<std::vector<int>>& so_far,
                   std::vector<std::vector<std::vector<int>>>& found, std::vector<std::vector<int>> rest) {
  if (corners.size() < 3) {
    if (rest.empty()) {
      found.push_back(so_far);
    } else {
      const std::vector<int> next = rest.back();
      rest.pop_back();
      all_divisions(next, so_far, found, rest);
    }
    return;
  }
  const auto range = [&](size_t from, size_t to) {
    return std::vector<int>(corners.begin() + static_cast<std::ptrdiff_t>(from),
                            corners.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  };
  const size_t last = corners.size() - 1;
  for (size_t k = 1; k < last; ++k) {
    auto parts = so_far;
    parts.push_back({corners[0], corners[k], corners[last]});
    auto more = rest;
    more.push_back(range(k, last));
    all_divisions(range(0, k), parts, found, more);
    for (size_t l = k + 1; l < last; ++l) {
      parts = so_far;
      parts.push_back({corners[0], corners[k], corners[l], corners[last]});
      more = rest;
      more.push_back(range(k, l));
      more.push_back(range(l, last));
      all_divisions(range(0, k), parts, found, more);
    }
  }
}

// A second implementation: every division is listed and measured. Their number for polygons divided into
// triangles and quads is 1, 3, 10, 38, 154 for 3 to 7 corners (OEIS A001002).
TEST(SplitFace, FindsTheBestOfAllDivisions) {
  Random random(11);
  const int expected[] = {1, 3, 10, 38, 154};
  for (int n = 3; n <= 7; ++n)
    for (int k = 0; k < 5; ++k) {
      const std::vector<Vector2d> corners = star_polygon(random, n);
      const double a = random.normal(), b = random.normal();
      const auto sides = sides_over(
          [&](const Vector2d& p) { return Vector3d(p.x(), p.y(), a * p.x() * p.y() + b * p.y() * p.y()); },
          corners);
      std::vector<int> all(static_cast<size_t>(n));
      for (int c = 0; c < n; ++c) all[static_cast<size_t>(c)] = c;
      std::vector<std::vector<std::vector<int>>> divisions;
      all_divisions(all, {}, divisions, {});
      ASSERT_EQ(divisions.size(), static_cast<size_t>(expected[n - 3]));
      SplitCost best;
      bool found = false;
      for (const auto& parts : divisions) {
        const SplitCost cost = cost_of_split(sides, parts);
        if (!found || cost.flaws < best.flaws || (cost.flaws == best.flaws && cost.angle() < best.angle())) {
          best = cost;
          found = true;
        }
      }
      const FaceSplit split = split_face(sides);
      EXPECT_EQ(split.cost.flaws, best.flaws) << n;
      EXPECT_NEAR(split.cost.angle(), best.angle(), 1e-7) << n;
    }
}

TEST(SplitFace, KeepsQuadsWholeButForReflexCorners) {
  EXPECT_EQ(split_face(sides_over(flat, {{0, 0}, {1, 0}, {1.2, 1}, {0, 1.5}})).parts.size(), 1u);
  // An arrow: only the diagonal from its reflex corner 3 leaves two triangles.
  const FaceSplit arrow = split_face(sides_over(flat, {{0, 0}, {1, 0}, {0, 1}, {0.2, 0.2}}));
  ASSERT_EQ(arrow.parts.size(), 2u);
  EXPECT_EQ(arrow.cost.flaws, 0);
  for (const auto& part : arrow.parts)
    EXPECT_TRUE(std::count(part.begin(), part.end(), 1) && std::count(part.begin(), part.end(), 3));
  // Half a tube is bent by 180 degrees: its sides leave the corners along the mean normal.
  const FaceSplit tube = split_face(
      sides_over([](const Vector2d& p) { return Vector3d(-std::cos(p.x()), p.y(), std::sin(p.x())); },
                 {{0, 0}, {kPi, 0}, {kPi, 2}, {0, 2}}));
  EXPECT_EQ(tube.parts.size(), 1u);
  EXPECT_THROW(split_face(sides_over(flat, {{0, 0}, {1, 0}})), InvalidInput);
}

TEST(SplitFace, CutsFacesOfVeryManySidesDownFirst) {
  std::vector<Vector2d> corners;
  for (int k = 0; k < 90; ++k) corners.emplace_back(std::cos(2 * kPi * k / 90), std::sin(2 * kPi * k / 90));
  expect_fair_division(corners, split_face(sides_over(flat, corners, 4)));
}

TEST(DiagonalsOfSplit, AreThoseOfThePartsAndRunFromCornerToCorner) {
  const auto sides = sides_over(flat, kCross);
  const FaceSplit split = split_face(sides);
  const std::vector<Diagonal> diagonals = diagonals_of_split(sides, split).diagonals;
  ASSERT_EQ(diagonals.size(), 4u);
  std::set<std::pair<int, int>> ends;
  for (const Diagonal& diagonal : diagonals) {
    ends.insert({diagonal.from, diagonal.to});
    EXPECT_EQ(diagonal.polyline->front(), sides[static_cast<size_t>(diagonal.from)]->front());
    EXPECT_EQ(diagonal.polyline->back(), sides[static_cast<size_t>(diagonal.to)]->front());
    // Straight across the arms: the Coons patch of any four corners of a cross leaves it.
    EXPECT_NEAR(diagonal.polyline->length(), 2, 1e-9);
  }
  EXPECT_EQ(ends, (std::set<std::pair<int, int>>{{0, 3}, {3, 6}, {6, 9}, {0, 9}}));
}

// A quadric is what the fall-back fits to the border, so its diagonals lie on it; those of a Coons patch lie
// on a surface of translation.
TEST(DiagonalsOfSplit, FollowTheBendOfTheFace) {
  const auto quadric = [](const Vector2d& p) {
    return Vector3d(p.x(), p.y(), 0.1 * p.x() * p.x() - 0.07 * p.x() * p.y());
  };
  for (const auto& corners :
       {kCross, std::vector<Vector2d>{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}}) {
    const auto sides = sides_over(quadric, corners, 400);
    for (const Diagonal& diagonal : diagonals_of_split(sides, split_face(sides)).diagonals)
      for (Eigen::Index i = 0; i < diagonal.polyline->n_points(); ++i) {
        const Vector3d p = diagonal.polyline->points().row(i);
        EXPECT_NEAR(p.z(), quadric(p.head<2>()).z(), 2e-3);
      }
  }
  // A pentagon on the unit sphere, about 50 degrees wide: the diagonals stay near it, straight ones sag.
  const auto sphere = [](const Vector2d& p) { return Vector3d(p.x(), p.y(), 1).normalized(); };
  std::vector<Vector2d> pentagon;
  for (int k = 0; k < 5; ++k)
    pentagon.emplace_back(0.5 * std::cos(0.4 * kPi * k), 0.5 * std::sin(0.4 * kPi * k));
  const auto sides = sides_over(sphere, pentagon);
  double sag = 0, straight = 0;
  for (const Diagonal& diagonal : diagonals_of_split(sides, split_face(sides)).diagonals) {
    const Vector3d middle = diagonal.polyline->at(diagonal.polyline->length() / 2);
    sag = std::max(sag, std::abs(middle.norm() - 1));
    straight =
        std::max(straight, 1 - (0.5 * (diagonal.polyline->front() + diagonal.polyline->back())).norm());
  }
  std::cout << "a pentagon on a sphere: diagonals within " << sag << " of the radius, straight ones "
            << straight << '\n';
  EXPECT_LT(sag, 0.36 * straight);
}

}  // namespace
}  // namespace batten
