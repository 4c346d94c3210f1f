#include "batten/mesh/triangle_mesh.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/quality.hpp"

namespace batten {
namespace {

PolygonMesh one_polygon(const Points& corners) {
  PolygonMesh mesh;
  mesh.positions = corners;
  for (int i = 0; i < corners.rows(); ++i) mesh.corners.push_back(i);
  mesh.offsets.push_back(static_cast<int>(corners.rows()));
  return mesh;
}

/// The area vector ½ Σ p_i × p_{i+1}: what every triangulation that stays inside must keep.
Eigen::RowVector3d area_vector(const Points& p) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::RowVector3d a = p.row(i), b = p.row((i + 1) % p.rows());
    sum += a.cross(b) / 2;
  }
  return sum;
}

/// A star-shaped polygon with alternating radii, tilted in space.
Points star(int n, double inner, double scale, const Eigen::Vector3d& offset) {
  Points points(n, 3);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  for (int i = 0; i < n; ++i) {
    const double r = i % 2 == 0 ? 1 : inner, angle = 2 * kPi * i / n;
    points.row(i) =
        (offset + scale * turn * Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0)).transpose();
  }
  return points;
}

// In a plane the areas of the triangles sum to the area of the polygon only if none is folded or outside.
TEST(Triangulated, KeepsTheAreaOfNonConvexPolygonsAtAnyScale) {
  for (const double scale : {1.0, 1e-3, 1e3})
    for (const double inner : {0.2, 0.05, 0.9})
      for (const int n : {4, 6, 10, 60}) {
        const Points corners = star(n, inner, scale, scale * Eigen::Vector3d(5, -3, 2));
        const TriangleMesh mesh = triangulated(one_polygon(corners));
        ASSERT_EQ(mesh.n_triangles(), n - 2);
        EXPECT_NEAR(surface_area(mesh.positions, mesh.triangles), area_vector(corners).norm(),
                    1e-12 * scale * scale);
      }
}

// A comb: most convex corners are blocked by the teeth, and ears become free only late.
TEST(Triangulated, CutsACombWithBlockedEars) {
  const int teeth = 200;
  Points corners(2 * teeth + 2, 3);
  for (int i = 0; i < 2 * teeth; ++i) corners.row(i) << i, (i % 2 == 0 ? 10 : 0.001 * i), 0;
  corners.row(2 * teeth) << 2 * teeth, -1, 0;
  corners.row(2 * teeth + 1) << -1, -1, 0;
  const TriangleMesh mesh = triangulated(one_polygon(corners));
  EXPECT_NEAR(surface_area(mesh.positions, mesh.triangles), area_vector(corners).norm(), 1e-9);
}

// Cut along the short diagonal the smallest angle of this kite is larger.
TEST(Triangulated, ChoosesTheBetterDiagonalOfAQuad) {
  const TriangleMesh mesh =
      triangulated(one_polygon((Points(4, 3) << -3, 0, 0, 0, -1, 0, 3, 0, 0, 0, 1, 0).finished()));
  for (int f = 0; f < 2; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_FALSE(mesh.triangles(f, k) == 0 && mesh.triangles(f, (k + 1) % 3) == 2);
  const MeshQuality quality = mesh_quality(mesh.positions, mesh.triangles);
  EXPECT_NEAR(quality.max_angle, kPi - 2 * std::atan(1.0 / 3) > 2 * std::atan(1.0 / 3) ? std::atan2(3, 1) : 0,
              1e-12);
}

// One diagonal leaves an equilateral triangle and a sliver, the other two of middling shape: the worse of
// both counts, so the other is cut.
TEST(Triangulated, JudgesADiagonalByTheWorseOfItsTriangles) {
  const Points quad = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 0.5, 0.866, 0, 0.207, 0.458, 0).finished();
  for (int first = 0; first < 4; ++first) {
    Points turned(4, 3);
    for (int k = 0; k < 4; ++k) turned.row(k) = quad.row((first + k) % 4);
    const TriangleMesh mesh = triangulated(one_polygon(turned));
    for (int f = 0; f < 2; ++f) {
      int of_diagonal = 0;
      for (int k = 0; k < 3; ++k) of_diagonal += (mesh.triangles(f, k) + first) % 2 == 1 ? 1 : 0;
      EXPECT_EQ(of_diagonal, 2) << "both triangles hold corners 1 and 3";
    }
  }
}

// Without a valid ear the polygon crosses itself; the work must end and give n − 2 triangles all the same.
TEST(Triangulated, EndsOnCrossingAndCollapsedPolygons) {
  Random random(4);
  Points crossing(300, 3);
  for (int i = 0; i < 300; ++i) crossing.row(i) = random.normal3().transpose();
  EXPECT_EQ(triangulated(one_polygon(crossing)).n_triangles(), 298);
  EXPECT_EQ(triangulated(one_polygon(Points::Zero(9, 3))).n_triangles(), 7);
  Points line(7, 3);
  for (int i = 0; i < 7; ++i) line.row(i) << i, 2 * i, 0;
  EXPECT_EQ(triangulated(one_polygon(line)).n_triangles(), 5);
}

TEST(Triangulated, NamesTheFaceThatIsWrong) {
  PolygonMesh mesh = one_polygon(Points::Random(5, 3));
  mesh.corners[3] = 5;
  EXPECT_THROW(triangulated(mesh), InvalidInput);
  mesh = one_polygon(Points::Random(2, 3));
  EXPECT_THROW(triangulated(mesh), InvalidInput);
  // Ears take quadratic time: a polygon of ten thousand corners is cut, a longer one is no face.
  Points round(10001, 3);
  for (Eigen::Index i = 0; i < round.rows(); ++i)
    round.row(i) << std::cos(2 * kPi * i / 10001.0), std::sin(2 * kPi * i / 10001.0), 0;
  EXPECT_EQ(triangulated(one_polygon(round.topRows(10000))).n_triangles(), 9998);
  EXPECT_THROW(triangulated(one_polygon(round)), InvalidInput);
}

}  // namespace
}  // namespace batten
