#include "batten/mesh/welding.hpp"

#include "mesh/broken_shapes.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {
namespace {

using fixtures::beside;
using fixtures::box;
using fixtures::soup_of;

MeshTopology topology_after(const TriangleMesh& mesh, const VertexWelding& welding) {
  return mesh_topology(welded_triangles(mesh.triangles, welding), mesh.n_vertices());
}

TEST(WeldBorders, MakesASoupTheClosedMeshItCameFrom) {
  const TriangleMesh cube = box(4), soup = soup_of(cube);
  const VertexWelding welding = weld_borders(soup.positions, soup.triangles);
  EXPECT_EQ(welding.n_welded, soup.n_vertices() - cube.n_vertices());
  EXPECT_TRUE(topology_after(soup, welding).is_watertight());
  EXPECT_TRUE(is_triangle_soup(soup.triangles, welding));
}

// The tolerance follows the scatter of the vertices, whatever the size of the mesh.
TEST(WeldBorders, FindsTheToleranceFromTheMesh) {
  for (const double size : {1e-9, 1.0, 1e12})
    for (const double jitter : {1e-8, 1e-6, 1e-5}) {
      const TriangleMesh cube = box(4, {0, 0, 0}, size), soup = soup_of(cube, jitter * size);
      const VertexWelding welding = weld_borders(soup.positions, soup.triangles);
      EXPECT_TRUE(topology_after(soup, welding).is_watertight()) << size << ' ' << jitter;
      EXPECT_EQ(welding.n_welded, soup.n_vertices() - cube.n_vertices()) << size << ' ' << jitter;
      EXPECT_LT(welding.tolerance, 1e3 * jitter * size);
    }
}

// Two sheets a hair apart are two sheets: welding their outlines would fold them onto each other.
TEST(WeldBorders, LeavesParallelSheetsApart) {
  TriangleMesh lower = fixtures::as_mesh(
      fixtures::grid(5, 5, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }));
  TriangleMesh upper = lower;
  upper.positions.col(2).setConstant(1e-5);
  const TriangleMesh both = beside(lower, upper);
  EXPECT_EQ(weld_borders(both.positions, both.triangles).n_welded, 0);
}

// A closed mesh has no border, however small its edges are.
TEST(WeldBorders, NeverTouchesWhatIsClosed) {
  const TriangleMesh both = beside(box(3), box(3));
  EXPECT_EQ(weld_borders(both.positions, both.triangles).n_welded, 0);
  EXPECT_EQ(weld_borders(both.positions, both.triangles, 10).n_welded, 0);
}

// Along a line of open vertices, each nearer to the next than the tolerance, nothing moves further than it.
TEST(WeldBorders, MovesNothingFurtherThanTheTolerance) {
  const int n = 40;
  TriangleMesh comb;
  comb.positions.resize(3 * n, 3);
  comb.triangles.resize(n, 3);
  for (int i = 0; i < n; ++i) {
    comb.positions.row(3 * i) << 0.06 * i, 0, 0;
    comb.positions.row(3 * i + 1) << 100, i, 5;
    comb.positions.row(3 * i + 2) << 100, i, 7;
    comb.triangles.row(i) << 3 * i, 3 * i + 1, 3 * i + 2;
  }
  const VertexWelding welding = weld_borders(comb.positions, comb.triangles, 0.1);
  EXPECT_GT(welding.n_welded, 10);
  for (Eigen::Index v = 0; v < comb.n_vertices(); ++v) {
    const int to = welding.vertex_of[static_cast<size_t>(v)];
    EXPECT_EQ(welding.vertex_of[at(to)], to);
    EXPECT_LE((comb.positions.row(v) - comb.positions.row(to)).norm(), 0.1);
  }
}

TEST(WeldBorders, RefusesANegativeTolerance) {
  const TriangleMesh soup = soup_of(box(1));
  EXPECT_THROW(weld_borders(soup.positions, soup.triangles, -1), InvalidInput);
}

TEST(IsTriangleSoup, IsFalseForMeshesWithBorders) {
  const TriangleMesh sheet = fixtures::as_mesh(
      fixtures::grid(2, 1, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }));
  EXPECT_FALSE(is_triangle_soup(sheet.triangles, weld_borders(sheet.positions, sheet.triangles)));
}

TEST(PlacesOfVertices, AreTheLowestAtEachPlace) {
  Points positions(4, 3);
  positions << 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, -0.0, 0;
  EXPECT_EQ(places_of_vertices(positions), (std::vector<int>{0, 1, 0, 1}));
}

}  // namespace
}  // namespace batten
