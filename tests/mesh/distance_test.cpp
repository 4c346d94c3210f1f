#include "batten/mesh/distance.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

Points random_points(Random& random, Eigen::Index n, double size) {
  Points points(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) points.row(i) = size * random.normal3();
  return points;
}

Triangles random_triangles(Random& random, Eigen::Index m, int n_vertices) {
  Triangles triangles(m, 3);
  for (Eigen::Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) triangles(t, k) = static_cast<int>(random.below(n_vertices));
  return triangles;
}

// The nearest point of a triangle is the unconstrained nearest point of its plane when that lies inside, else
// the nearest of the three edges: a second way without the regions of the first.
double distance_by_cases(const Vector3d& q, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const auto to_segment = [&](const Vector3d& p, const Vector3d& r) {
    const double t = std::min(1.0, std::max(0.0, (r - p).dot(q - p) / (r - p).squaredNorm()));
    return (p + t * (r - p) - q).norm();
  };
  const double edges = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  const auto inside = [&](const Vector3d& p, const Vector3d& r) { return (r - p).cross(q - p).dot(n) >= 0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(n.normalized().dot(q - a));
  return edges;
}

TEST(Distance, PointToTriangleAgreesWithPlaneAndEdges) {
  Random random(11);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d a = random.normal3(), b = random.normal3(), c = random.normal3(), q = 2 * random.normal3();
    const ClosestPoint found = closest_point_on_triangle(q, a, b, c);
    ASSERT_NEAR(std::sqrt(found.squared_distance), distance_by_cases(q, a, b, c), 1e-12) << i;
    const Vector3d p = found.weights[0] * a + found.weights[1] * b + found.weights[2] * c;
    ASSERT_LT((p - found.point).norm(), 1e-14);
    ASSERT_GE(found.weights.minCoeff(), 0);
    ASSERT_NEAR(found.weights.sum(), 1, 1e-14);
  }
}

// A triangle without area is its longest edge; a segment without length is its end.
TEST(Distance, DegenerateElementsCountAsWhatIsLeftOfThem) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(3, 0, 0);
  for (const auto& [p, q, r] : {std::tuple(a, b, c), std::tuple(a, c, b), std::tuple(b, a, c),
                                std::tuple(b, c, a), std::tuple(c, a, b), std::tuple(c, b, a)}) {
    for (const double x : {0.5, 2.5}) {  // on the shorter edges one each
      const ClosestPoint found = closest_point_on_triangle({x, 1, 0}, p, q, r);
      EXPECT_NEAR(found.squared_distance, 1, 1e-15);
      EXPECT_NEAR((found.point - Vector3d(x, 0, 0)).norm(), 0, 1e-15);
    }
  }
  EXPECT_EQ(closest_point_on_triangle({0, 2, 0}, a, a, a).squared_distance, 4);
  EXPECT_EQ(closest_point_on_segment({0, 2, 0}, a, a).squared_distance, 4);
  EXPECT_EQ(closest_point_on_segment({0.25, 2, 0}, a, b).weights, Vector3d(0.75, 0.25, 0));
}

// Brute force over all elements, on a soup of long triangles that overlap (the worst case of a hierarchy).
TEST(TriangleTree, AgreesWithBruteForceOnASoupInOrderOfVisitAndInBatches) {
  Random random(5);
  const Points positions = random_points(random, 300, 1.0);
  const Triangles triangles = random_triangles(random, 700, 300);
  const Points queries = random_points(random, 400, 1.5);
  const TriangleTree tree(positions, triangles);
  const std::vector<ClosestPoint> batch = tree.closest(queries);
  for (Eigen::Index i = 0; i < queries.rows(); ++i) {
    ClosestPoint best;
    best.squared_distance = std::numeric_limits<double>::infinity();
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
      ClosestPoint found =
          closest_point_on_triangle(queries.row(i), positions.row(triangles(t, 0)),
                                    positions.row(triangles(t, 1)), positions.row(triangles(t, 2)));
      found.element = t;
      if (found.squared_distance < best.squared_distance) best = found;
    }
    const ClosestPoint single = tree.closest(Vector3d(queries.row(i)));
    for (const ClosestPoint& found : {single, batch[i]}) {
      EXPECT_EQ(found.squared_distance, best.squared_distance);
      EXPECT_EQ(found.element, best.element);
      EXPECT_EQ(found.point, best.point);
    }
  }
}

// Ties: a query above a vertex that many triangles share must give the lowest index however it is asked.
TEST(TriangleTree, GivesTheLowestElementAmongEqualOnes) {
  const int n = 12;
  Points positions(n + 1, 3);
  Triangles triangles(n, 3);
  positions.row(n) << 0, 0, 0;
  for (int i = 0; i < n; ++i) {
    positions.row(i) << std::cos(0.5 * i), std::sin(0.5 * i), 0;
    triangles.row(n - 1 - i) << n, i, (i + 1) % n;
  }
  const TriangleTree tree(positions, triangles);
  Points queries(50, 3);
  for (int i = 0; i < 50; ++i) queries.row(i) << 0, 0, 0.1 * i;
  for (const ClosestPoint& found : tree.closest(queries)) {
    EXPECT_EQ(found.element, 0);
    EXPECT_EQ(found.weights, Vector3d(1, 0, 0));
  }
}

TEST(SegmentTree, AgreesWithBruteForce) {
  Random random(6);
  const Points positions = random_points(random, 500, 1.0);
  Segments segments(499, 2);
  for (int s = 0; s < 499; ++s) segments.row(s) << s, s + 1;
  const Points queries = random_points(random, 500, 1.0);
  const SegmentTree tree(positions, segments);
  const std::vector<ClosestPoint> batch = tree.closest(queries);
  for (Eigen::Index i = 0; i < queries.rows(); ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (int s = 0; s < 499; ++s)
      best = std::min(
          best,
          closest_point_on_segment(queries.row(i), positions.row(s), positions.row(s + 1)).squared_distance);
    EXPECT_EQ(batch[i].squared_distance, best);
    EXPECT_EQ(tree.closest(Vector3d(queries.row(i))).squared_distance, best);
  }
}

// All centres in one place: the split must still end, and end shallow enough for the stack.
TEST(TriangleTree, SurvivesElementsThatCannotBeSeparated) {
  const int n = 5000;
  Points positions(3, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  Triangles same(n, 3);
  for (int t = 0; t < n; ++t) same.row(t) << 0, 1, 2;
  EXPECT_NEAR(TriangleTree(positions, same).closest(Vector3d(0.2, 0.2, 2)).squared_distance, 4, 1e-15);
  // Sizes that halve: the surface area heuristic would cut off one element at a time.
  Points line(1000, 3);
  Segments segments(999, 2);
  for (int i = 0; i < 1000; ++i) line.row(i) << std::ldexp(1.0, -i), 0, 0;
  for (int s = 0; s < 999; ++s) segments.row(s) << s, s + 1;
  EXPECT_EQ(SegmentTree(line, segments).closest(Vector3d(-3, 4, 0)).squared_distance, 25);
}

TEST(TriangleTree, ScaleAndPositionDoNotMatter) {
  Random random(8);
  const Points positions = random_points(random, 100, 1.0);
  const Triangles triangles = random_triangles(random, 200, 100);
  const Points queries = random_points(random, 100, 1.0);
  const Eigen::VectorXd unit = distances(TriangleTree(positions, triangles).closest(queries));
  for (const double scale : {1e-3, 1e3, 0x1p-200, 0x1p200}) {
    const Eigen::VectorXd scaled =
        distances(TriangleTree(scale * positions, triangles).closest(Points(scale * queries)));
    EXPECT_LT((scaled / scale - unit).lpNorm<Eigen::Infinity>(), 1e-12) << scale;
  }
}

TEST(TriangleTree, RefusesWhatItCannotMeasureAndNamesIt) {
  Points positions(3, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  EXPECT_THROW(TriangleTree(positions, Triangles(0, 3)), InvalidInput);
  EXPECT_THROW(TriangleTree(positions, triangles).closest(Vector3d(0, NAN, 0)), InvalidInput);
  EXPECT_THROW(TriangleTree(positions, triangles).closest(Points(positions * NAN)), InvalidInput);
  EXPECT_TRUE(TriangleTree(positions, triangles).closest(Points(0, 3)).empty());
  triangles(0, 1) = 3;
  try {
    TriangleTree tree(positions, triangles);
    FAIL() << "an index out of range was accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("triangle 0 names vertex 3"), std::string::npos) << error.what();
  }
  triangles(0, 1) = 1;
  positions(2, 0) = INFINITY;
  EXPECT_THROW(TriangleTree(positions, triangles), InvalidInput);
}

}  // namespace
}  // namespace batten
