#include "batten/mesh/adjacency.hpp"

#include "mesh/shapes.hpp"

#include <algorithm>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

Triangles tetrahedron() {
  return (Triangles(4, 3) << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3).finished();
}

Shape torus(int n, int m) {
  return fixtures::grid(n, m, true, true, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
}

Shape open_grid(int n, int m) {
  return fixtures::grid(n, m, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
}

// Every edge of a closed mesh has two sides, so E = 3 F / 2; each side belongs to the edge it is listed
// under.
TEST(MeshEdges, ListsEverySideOnceUnderItsEdge) {
  const Shape shape = torus(7, 5);
  const MeshEdges edges = mesh_edges(shape.triangles, shape.positions.rows());
  EXPECT_EQ(edges.n_edges(), 3 * shape.triangles.rows() / 2);
  std::set<int> seen(edges.sides.begin(), edges.sides.end());
  EXPECT_EQ(seen.size(), static_cast<size_t>(3 * shape.triangles.rows()));
  for (Eigen::Index f = 0; f < shape.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int e = edges.of_triangle(f, k);
      EXPECT_EQ(edges.vertices(e, 0), std::min(shape.triangles(f, k), shape.triangles(f, (k + 1) % 3)));
      EXPECT_EQ(edges.vertices(e, 1), std::max(shape.triangles(f, k), shape.triangles(f, (k + 1) % 3)));
      EXPECT_EQ(edges.n_triangles(e), 2);
    }
}

// Known surfaces: χ = 2 − 2 g − b for each component.
TEST(MeshTopology, KnowsSphereTorusDiscAndAnnulus) {
  const MeshTopology sphere = mesh_topology(tetrahedron(), 4);
  EXPECT_EQ(sphere.euler_characteristic, 2);
  EXPECT_EQ(sphere.genus(), 0);
  EXPECT_TRUE(sphere.is_watertight());
  const Shape t = torus(6, 4);
  const MeshTopology torus_topology = mesh_topology(t.triangles, t.positions.rows());
  EXPECT_EQ(torus_topology.euler_characteristic, 0);
  EXPECT_EQ(torus_topology.genus(), 1);
  const Shape g = open_grid(4, 3);
  const MeshTopology disc = mesh_topology(g.triangles, g.positions.rows());
  EXPECT_EQ(disc.n_boundary_loops, 1);
  EXPECT_EQ(disc.n_boundary_edges, 14);
  EXPECT_EQ(disc.genus(), 0);
  EXPECT_FALSE(disc.is_watertight());
  const Shape a =
      fixtures::grid(6, 2, true, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  const MeshTopology annulus = mesh_topology(a.triangles, a.positions.rows());
  EXPECT_EQ(annulus.n_boundary_loops, 2);
  EXPECT_EQ(annulus.euler_characteristic, 0);
  EXPECT_EQ(annulus.genus(), 0);
  EXPECT_TRUE(annulus.problems.empty());
}

TEST(MeshTopology, TwoComponentsAndUnusedVerticesAreCounted) {
  Triangles both(8, 3);
  both << tetrahedron(), tetrahedron().array() + 5;
  const MeshTopology topology = mesh_topology(both, 12);
  EXPECT_EQ(topology.n_components, 2);
  EXPECT_EQ(topology.n_unused_vertices, 4);
  EXPECT_EQ(topology.euler_characteristic, 4);
  EXPECT_EQ(topology.genus(), 0);
}

TEST(MeshTopology, NamesThePlaceOfEveryDefect) {
  // three triangles on the edge 0–1
  const MeshTopology fin = mesh_topology((Triangles(3, 3) << 0, 1, 2, 1, 0, 3, 0, 1, 4).finished(), 5);
  ASSERT_EQ(fin.non_manifold_edges.size(), 1u);
  EXPECT_FALSE(fin.genus().has_value());
  ASSERT_EQ(fin.problems.size(), 1u);
  EXPECT_NE(fin.problems[0].find("vertices 0 and 1"), std::string::npos);
  // two tetrahedra joined at vertex 0
  Triangles joined(8, 3);
  Triangles second = tetrahedron().array() + 3;
  joined << tetrahedron(), second;
  joined = (joined.array() == 3).select(0, joined);
  joined.topRows(4) = tetrahedron();
  const MeshTopology pinched = mesh_topology(joined, 7);
  EXPECT_EQ(pinched.non_manifold_vertices, std::vector<int>{0});
  EXPECT_FALSE(pinched.is_manifold());
  // one face of a tetrahedron turned over
  Triangles turned = tetrahedron();
  std::swap(turned(2, 0), turned(2, 1));
  const MeshTopology inconsistent = mesh_topology(turned, 4);
  EXPECT_EQ(inconsistent.inconsistent_edges.size(), 3u);
  EXPECT_FALSE(inconsistent.is_oriented());
  // a triangle with a repeated vertex
  const MeshTopology collapsed = mesh_topology((Triangles(1, 3) << 0, 1, 1).finished(), 2);
  EXPECT_EQ(collapsed.collapsed_triangles, std::vector<int>{0});
}

TEST(MeshTopology, RefusesIndicesOutOfRange) {
  EXPECT_THROW(mesh_topology((Triangles(1, 3) << 0, 1, 3).finished(), 3), InvalidInput);
  EXPECT_THROW(mesh_edges((Triangles(1, 3) << 0, -1, 2).finished(), 3), InvalidInput);
  EXPECT_EQ(mesh_topology(Triangles(0, 3), 0).n_components, 0);
}

// Renumbering triangles and vertices changes no count.
TEST(MeshTopology, DoesNotDependOnTheOrder) {
  Shape shape = open_grid(5, 5);
  Random random(8);
  std::vector<int> order(static_cast<size_t>(shape.positions.rows()));
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  Triangles renumbered = shape.triangles.colwise().reverse();
  for (Eigen::Index f = 0; f < renumbered.rows(); ++f)
    for (int k = 0; k < 3; ++k) renumbered(f, k) = order[static_cast<size_t>(renumbered(f, k))];
  const MeshTopology a = mesh_topology(shape.triangles, 36), b = mesh_topology(renumbered, 36);
  EXPECT_EQ(a.n_edges, b.n_edges);
  EXPECT_EQ(a.n_boundary_loops, b.n_boundary_loops);
  EXPECT_EQ(a.genus(), b.genus());
}

// Around an inside vertex of the grid the ring has six neighbours, each joined to the next by a triangle.
TEST(OneRings, RunCounterClockwiseAndCloseInside) {
  const Shape shape = open_grid(4, 4);
  const OneRings rings = one_rings(shape.triangles, shape.positions.rows());
  for (int v = 0; v < 25; ++v) {
    const bool inside = v % 5 > 0 && v % 5 < 4 && v / 5 > 0 && v / 5 < 4;
    EXPECT_EQ(rings.is_closed[static_cast<size_t>(v)] != 0, inside);
    const int begin = rings.offsets[static_cast<size_t>(v)], n = rings.valence(v);
    if (inside) {
      EXPECT_EQ(n, 6);
    }
    for (int k = 0; k + (inside ? 0 : 1) < n; ++k) {
      const Eigen::RowVector3d p = shape.positions.row(v);
      const Eigen::RowVector3d a = shape.positions.row(rings.vertices[static_cast<size_t>(begin + k)]) - p;
      const Eigen::RowVector3d b =
          shape.positions.row(rings.vertices[static_cast<size_t>(begin + (k + 1) % n)]) - p;
      EXPECT_GT(a.cross(b)(2), 0);
    }
  }
}

TEST(OneRings, NameTheVertexWithTwoFans) {
  EXPECT_THROW(one_rings((Triangles(2, 3) << 0, 1, 2, 0, 3, 4).finished(), 5), InvalidInput);
  EXPECT_THROW(one_rings((Triangles(2, 3) << 0, 1, 2, 0, 1, 3).finished(), 4), InvalidInput);
}

// The border of a grid is one loop; with the surface to the left it runs counter-clockwise, so its area is
// +1.
TEST(BoundaryLoops, KeepTheSurfaceToTheLeft) {
  const Shape shape = open_grid(6, 3);
  const auto loops = boundary_loops(shape.triangles, mesh_edges(shape.triangles, shape.positions.rows()));
  ASSERT_EQ(loops.size(), 1u);
  ASSERT_EQ(loops[0].size(), 18u);
  double area = 0;
  for (size_t k = 0; k < 18; ++k) {
    const Eigen::RowVector3d a = shape.positions.row(loops[0][k]),
                             b = shape.positions.row(loops[0][(k + 1) % 18]);
    area += a.cross(b)(2) / 2;
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

// Two triangles that touch at a vertex: two loops of three, not one of six.
TEST(BoundaryLoops, KeepToTheirFanWhereTheBorderTouchesItself) {
  const Triangles bow = (Triangles(2, 3) << 0, 1, 2, 0, 3, 4).finished();
  const auto loops = boundary_loops(bow, mesh_edges(bow, 5));
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[0].size(), 3u);
  EXPECT_EQ(loops[1].size(), 3u);
}

// Three pages of a book: the border of each ends at the back on both sides and is no part of another's.
TEST(BoundaryLoops, EndAtAnEdgeOfThreeTriangles) {
  const Triangles book = (Triangles(3, 3) << 0, 1, 2, 0, 1, 3, 0, 1, 4).finished();
  const auto loops = boundary_loops(book, mesh_edges(book, 5));
  ASSERT_EQ(loops.size(), 3u);
  for (size_t page = 0; page < 3; ++page)
    EXPECT_EQ(loops[page], (std::vector<int>{1, static_cast<int>(page) + 2, 0})) << page;
}

}  // namespace
}  // namespace batten
