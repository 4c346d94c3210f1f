#include "batten/mesh/quality.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"

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
  // A third triangle at an edge: its two ends are no longer inside a surface.
  Triangles fin(shape.triangles.rows() + 1, 3);
  fin << shape.triangles, b, d, static_cast<int>(shape.positions.rows());
  EXPECT_EQ(regular_share(fin, shape.positions.rows() + 1), 12.0 / 14) << "both had five edges or seven";
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

}  // namespace
}  // namespace batten
