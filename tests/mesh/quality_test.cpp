#include "batten/mesh/quality.hpp"

#include "mesh/shapes.hpp"

#include <cmath>
#include <filesystem>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {
namespace {

const Triangles kOne = (Triangles(1, 3) << 0, 1, 2).finished();

// Equilateral and right isosceles triangles, whose measures are known: R/(2r) of the latter is (1 + √2)/2.
TEST(MeshQuality, IsExactOnKnownTriangles) {
  for (const double scale : {1.0, 1e-3, 1e3}) {
    const Points equilateral =
        scale * (Points(3, 3) << 0, 0, 5, 1, 0, 5, 0.5, std::sqrt(3.0) / 2, 5).finished();
    const MeshQuality a = mesh_quality(equilateral, kOne);
    EXPECT_NEAR(a.min_angle, kPi / 3, 1e-12);
    EXPECT_NEAR(a.max_angle, kPi / 3, 1e-12);
    EXPECT_NEAR(a.max_aspect, 1, 1e-12);
    EXPECT_NEAR(a.mean_edge, scale, 1e-12 * scale);
    const MeshQuality b = mesh_quality(scale * (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished(), kOne);
    EXPECT_NEAR(b.min_angle, kPi / 4, 1e-12);
    EXPECT_NEAR(b.max_angle, kPi / 2, 1e-12);
    EXPECT_NEAR(b.max_aspect, (1 + std::sqrt(2.0)) / 2, 1e-12);
    EXPECT_NEAR(b.max_edge, std::sqrt(2.0) * scale, 1e-12 * scale);
  }
  EXPECT_EQ(mesh_quality(Points(0, 3), Triangles(0, 3)).worst_triangle, -1);
}

// Triangles of apex 18° and 22° over one side, and two of 45°: one of four has an angle below 20°.
TEST(MeshQuality, CountsSlivers) {
  const auto apex = [](double angle) { return 0.5 / std::tan(radians(angle) / 2); };
  Points positions(6, 3);
  positions << 0, 0, 0, 1, 0, 0, 0.5, apex(18), 0, 0.5, apex(22), 0, 0, 1, 0, 1, 1, 0;
  Triangles triangles(4, 3);
  triangles << 0, 1, 2, 0, 1, 3, 0, 1, 4, 1, 5, 4;
  EXPECT_EQ(mesh_quality(positions, triangles).slivers, 0.25);
}

// The grid's inner vertices all have six edges. Turning one diagonal between inner vertices gives two of
// them five edges and two seven: four of the 4 × 4 inside a grid of 5 × 5 cells.
TEST(RegularShare, CountsInnerVerticesOfSixEdges) {
  Shape shape =
      fixtures::grid(5, 5, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  EXPECT_EQ(regular_share(shape.triangles, shape.positions.rows()), 1);
  const int cell = 2 * (2 * 5 + 2);  // cell (2, 2) of 5 × 5: its corners are (2, 2) to (3, 3) of 4 × 4 inside
  const int a = shape.triangles(cell, 0), b = shape.triangles(cell, 1), c = shape.triangles(cell, 2),
            d = shape.triangles(cell + 1, 2);
  shape.triangles.row(cell) << a, b, d;
  shape.triangles.row(cell + 1) << b, c, d;
  EXPECT_EQ(regular_share(shape.triangles, shape.positions.rows()), 12.0 / 16);
  EXPECT_EQ(regular_share(Triangles(0, 3), 0), 0);
  EXPECT_EQ(regular_share(kOne, 3), 0);
}

TEST(DegenerateTriangles, AreFoundByShapeNotBySize) {
  const Points thin = (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0.5, 1e-10, 0).finished();
  EXPECT_EQ(degenerate_triangles(thin, kOne).size(), 1u);
  const Points fair = (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0.5, 1e-8, 0).finished();
  EXPECT_TRUE(degenerate_triangles(fair, kOne).empty());
  EXPECT_TRUE(
      degenerate_triangles(1e-12 * (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished(), kOne).empty());
  EXPECT_EQ(degenerate_triangles(Points::Ones(3, 3), kOne).size(), 1u);
}

// The angle-weighted normal of a cube's corner is its diagonal however the faces are cut; the faces give the
// axes.
TEST(VertexNormals, OfACubePointAlongTheDiagonals) {
  Points corners(8, 3);
  for (int i = 0; i < 8; ++i) corners.row(i) << (i & 1 ? 1 : -1), (i & 2 ? 1 : -1), (i & 4 ? 1 : -1);
  Triangles cube(12, 3);
  cube << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7,
      1, 7, 5;
  const Points normals = vertex_normals(corners, cube);
  for (int i = 0; i < 8; ++i) EXPECT_LT((normals.row(i) - corners.row(i).normalized()).norm(), 1e-15);
  EXPECT_NEAR(surface_area(corners, cube), 24, 1e-12);
  EXPECT_NEAR(enclosed_volume(corners, cube), 8, 1e-12);
  EXPECT_LT((face_normals(corners, cube).row(0) - Eigen::RowVector3d(0, 0, -1)).norm(), 1e-15);
  const Points far = corners.rowwise() + Eigen::RowVector3d(1e6, -1e6, 1e6);
  EXPECT_NEAR(enclosed_volume(far, cube), 8, 1e-8);
}

// One triangle turned by 30° about an edge, one turned over, one without area: (30° + 180°) / 2.
TEST(MeanNormalAngle, LeavesOutTrianglesWithoutArea) {
  Points a(5, 3);
  a << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 2, 0, 0;
  Triangles triangles(3, 3);
  triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  Points b = a;
  b.row(2) << 0, std::cos(kPi / 6), std::sin(kPi / 6);
  b.row(3) << 0.5, 3, 0;
  EXPECT_NEAR(mean_normal_angle(a, b, triangles), radians(105.0), 1e-14);
  EXPECT_EQ(mean_normal_angle(a, a, triangles), 0);
  EXPECT_EQ(mean_normal_angle(a, b, triangles.bottomRows(1)), 0);
}

// Normals of a sphere are its points; the mesh errs by the square of the edge length.
TEST(VertexNormals, ConvergeOnASphere) {
  double previous = 1;
  for (const int n : {8, 16, 32}) {
    const Shape sphere = fixtures::sphere(n);
    // Inside the octahedron's faces, where every vertex has all its triangles.
    const Points normals = vertex_normals(sphere.positions, sphere.triangles);
    double sum = 0;
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
      sum += (normals.row(v) - sphere.positions.row(v)).norm();
    const double mean = sum / static_cast<double>(normals.rows());
    EXPECT_LT(mean, 0.7 * previous) << n;
    previous = mean;
  }
}

TEST(FoldedTriangles, AreThoseAgainstTheirNormals) {
  Shape shape =
      fixtures::grid(3, 3, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  Points up = Points::Zero(16, 3);
  up.col(2).setOnes();
  EXPECT_TRUE(folded_triangles(shape.positions, shape.triangles, up).empty());
  EXPECT_TRUE(folded_edges(shape.positions, shape.triangles, 0.01).empty());
  shape.positions.row(5) << 0.9, 0.9, 0;  // an inside vertex pulled over its neighbours
  const auto folded = folded_triangles(shape.positions, shape.triangles, up);
  const auto edges = folded_edges(shape.positions, shape.triangles, 3.0);
  EXPECT_FALSE(folded.empty());
  EXPECT_FALSE(edges.empty());
  for (const int f : folded) EXPECT_LT(face_normals(shape.positions, shape.triangles)(f, 2), 0);
}

// The dihedral turn of a roof of slope 45° is 90°.
TEST(FoldedEdges, MeasureTheTurnOfTheNormal) {
  const Points roof = (Points(4, 3) << 0, 0, 1, 0, 1, 1, -1, 0, 0, 1, 0, 0).finished();
  const Triangles both = (Triangles(2, 3) << 0, 1, 2, 1, 0, 3).finished();
  EXPECT_EQ(folded_edges(roof, both, radians(89.9)).size(), 1u);
  EXPECT_TRUE(folded_edges(roof, both, radians(90.1)).empty());
}

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

TEST(SelfIntersections, FindCrossingTouchingOverlappingAndEqualTriangles) {
  const auto pairs_of = [](const Points& second, const Triangles& triangles) {
    Points all(3 + second.rows(), 3);
    all << 0, 0, 0, 4, 0, 0, 0, 4, 0, second;
    return self_intersections(all, triangles).size();
  };
  const Triangles apart = (Triangles(2, 3) << 0, 1, 2, 3, 4, 5).finished();
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, -1, 1, 1, 1, 5, 5, 1).finished(), apart), 1u);  // pierced
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 1, 1, 1, 5, 5, 1).finished(), apart),
            1u);  // touched by a corner
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 1e-300, 1, 1, 1, 5, 5, 1).finished(), apart), 0u);  // just not
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 9, 9, 0, 9, 8, 0).finished(), apart),
            1u);  // overlap in a plane
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 1.5, 1, 0, 1, 1.5, 0).finished(), apart), 1u);  // inside it
  EXPECT_EQ(pairs_of((Points(3, 3) << 3, 3, 0, 9, 9, 0, 9, 8, 0).finished(), apart), 0u);      // beside it
  EXPECT_EQ(pairs_of((Points(3, 3) << 0, 0, 0, 4, 0, 0, 0, 4, 0).finished(), apart), 1u);  // equal, unwelded
  EXPECT_EQ(pairs_of((Points(3, 3) << 4, 0, 0, 0, 0, 0, 1, -3, 0).finished(), apart),
            0u);  // neighbours, unwelded
  EXPECT_EQ(pairs_of((Points(3, 3) << 1, 1, 0, 2, 1, 0, 3, 1, 0).finished(), apart), 0u);  // without area
  // sharing vertex 0: one beside, one that pierces
  const Triangles vertex = (Triangles(2, 3) << 0, 1, 2, 0, 3, 4).finished();
  EXPECT_EQ(pairs_of((Points(2, 3) << -4, 0, 0, 0, -4, 0).finished(), vertex), 0u);
  EXPECT_EQ(pairs_of((Points(2, 3) << 1, 1, 1, 1, 1, -1).finished(), vertex), 1u);
  // sharing the edge 0–1: a roof is fine, a fold onto the other is not
  const Triangles edge = (Triangles(2, 3) << 0, 1, 2, 1, 0, 3).finished();
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, 1, 1e-12).finished(), edge), 0u);
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, 1, 0).finished(), edge), 1u);
  EXPECT_EQ(pairs_of((Points(1, 3) << 1, -1, 0).finished(), edge), 0u);
}

// Two spheres that overlap cross; apart they do not; the surface of one alone never does.
TEST(SelfIntersections, OfTwoSpheresDependOnTheirDistance) {
  const Shape one = fixtures::sphere(12);
  EXPECT_TRUE(self_intersections(one.positions, one.triangles).empty());
  for (const double distance : {1.5, 2.1}) {
    const Shape other = fixtures::sphere(12, 1, {distance, 0.01, 0.02});
    Points all(one.positions.rows() * 2, 3);
    all << one.positions, other.positions;
    Triangles both(one.triangles.rows() * 2, 3);
    both << one.triangles, other.triangles.array() + static_cast<int>(one.positions.rows());
    EXPECT_EQ(self_intersections(all, both).empty(), distance > 2) << distance;
    if (distance < 2) {
      EXPECT_EQ(self_intersections(all, both, 5).size(), 5u);
    }
  }
}

// A second implementation: all pairs, without the hierarchy of boxes, on random triangles.
TEST(SelfIntersections, AgreeWithTheTestOfAllPairs) {
  Random random(12);
  Points points(300, 3);
  for (int v = 0; v < 300; ++v) points.row(v) = random.normal3().transpose();
  Triangles triangles(100, 3);
  for (int f = 0; f < 100; ++f) triangles.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  const auto p = [&](int f, int k) { return Eigen::Vector3d(points.row(triangles(f, k % 3))); };
  std::vector<std::pair<int, int>> expected;
  for (int f = 0; f < 100; ++f)
    for (int g = f + 1; g < 100; ++g) {
      bool meet = false;
      for (int k = 0; k < 3; ++k)
        meet = meet || segment_meets_triangle(p(f, k), p(f, k + 1), p(g, 0), p(g, 1), p(g, 2)) ||
               segment_meets_triangle(p(g, k), p(g, k + 1), p(f, 0), p(f, 1), p(f, 2));
      if (meet) expected.emplace_back(f, g);
    }
  EXPECT_GT(expected.size(), 50u);
  EXPECT_EQ(self_intersections(points, triangles, 100000), expected);
}

}  // namespace
}  // namespace batten
