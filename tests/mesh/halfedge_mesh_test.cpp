#include "batten/mesh/halfedge_mesh.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

struct Arrays {
  Points positions;
  Triangles triangles;
};

/// A grid of n × m cells over the unit square; glued to a torus when `closed`.
Arrays grid(int n, int m, bool closed) {
  const int nu = closed ? n : n + 1, nv = closed ? m : m + 1;
  Arrays mesh;
  mesh.positions.resize(nu * nv, 3);
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) mesh.positions.row(i * nv + j) << i / double(n), j / double(m), 0;
  mesh.triangles.resize(2 * n * m, 3);
  int t = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const int a = i * nv + j, b = (i + 1) % nu * nv + j, c = (i + 1) % nu * nv + (j + 1) % nv,
                d = i * nv + (j + 1) % nv;
      mesh.triangles.row(t++) << a, b, c;
      mesh.triangles.row(t++) << a, c, d;
    }
  return mesh;
}

Arrays tetrahedron_arrays() {
  Arrays mesh;
  mesh.positions.resize(4, 3);
  mesh.positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  return mesh;
}

int edges(const HalfedgeMesh& mesh) {
  int n = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.has_halfedge(h) && mesh.is_representative(h)) ++n;
  return n;
}

int euler(const HalfedgeMesh& mesh) {
  return mesh.n_vertices() - edges(mesh) + mesh.n_faces();
}

int border_edges(const HalfedgeMesh& mesh) {
  int n = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.has_halfedge(h) && mesh.is_border_edge(h)) ++n;
  return n;
}

double area(const HalfedgeMesh& mesh) {
  double sum = 0;
  for (int f = 0; f < mesh.face_capacity(); ++f)
    if (mesh.has_face(f)) sum += 0.5 * mesh.area_normal(f).z();
  return sum;
}

std::string message_of(const Points& positions, const Triangles& triangles) {
  try {
    HalfedgeMesh mesh(positions, triangles);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return {};
}

// Counted by hand: a 3 × 2 grid has 12 vertices, 12 faces, 23 edges, 10 of them on the border.
TEST(HalfedgeMesh, CountsOfAGridAreThoseOfItsCells) {
  const Arrays arrays = grid(3, 2, false);
  const HalfedgeMesh mesh(arrays.positions, arrays.triangles);
  EXPECT_EQ(mesh.breach(), "");
  EXPECT_EQ(mesh.n_vertices(), 12);
  EXPECT_EQ(mesh.n_faces(), 12);
  EXPECT_EQ(edges(mesh), 23);
  EXPECT_EQ(border_edges(mesh), 10);
  EXPECT_EQ(mesh.valence(4), 6);  // the inner vertex (1, 1)
  EXPECT_EQ(mesh.valence(0), 3);
  EXPECT_FALSE(mesh.is_border_vertex(4));
  EXPECT_TRUE(mesh.is_border_vertex(0));
  EXPECT_NE(mesh.find(0, 4), HalfedgeMesh::kNone);
  EXPECT_EQ(mesh.find(0, 5), HalfedgeMesh::kNone);
}

// A mesh that nobody edited comes back as it went in.
TEST(HalfedgeMesh, CompactedUntouchedMeshIsTheInput) {
  const Arrays arrays = grid(4, 3, false);
  const auto compact = HalfedgeMesh(arrays.positions, arrays.triangles).compacted();
  EXPECT_EQ(compact.positions, arrays.positions);
  EXPECT_EQ(compact.triangles, arrays.triangles);
}

// Each operation keeps the Euler characteristic: of a disc 1, of a torus 0. Splits add a vertex and two
// faces (one on the border), collapses take them away, flips change neither. The marked edges stay a closed
// curve of the same kind.
TEST(HalfedgeMesh, RandomOperationsKeepAManifoldOfTheSameTopology) {
  for (const bool closed : {false, true}) {
    const Arrays arrays = grid(7, 6, closed);
    HalfedgeMesh mesh(arrays.positions, arrays.triangles);
    const int characteristic = euler(mesh);
    EXPECT_EQ(characteristic, closed ? 0 : 1);
    Random random(closed ? 1 : 2);
    int collapses = 0, flips = 0, splits = 0;
    for (int step = 0; step < 4000; ++step) {
      const int h = static_cast<int>(random.below(mesh.halfedge_capacity()));
      if (!mesh.has_halfedge(h)) continue;
      const int faces = mesh.n_faces(), vertices = mesh.n_vertices();
      const int sides = mesh.is_border_edge(h) ? 1 : 2;
      switch (random.below(3)) {
        case 0:
          if (!mesh.can_collapse(h)) break;
          mesh.collapse(h);
          ++collapses;
          EXPECT_EQ(mesh.n_faces(), faces - sides);
          EXPECT_EQ(mesh.n_vertices(), vertices - 1);
          break;
        case 1:
          if (!mesh.can_flip(h)) break;
          mesh.flip(h);
          ++flips;
          EXPECT_EQ(mesh.n_faces(), faces);
          break;
        default:
          if (faces > 300) break;
          mesh.split_edge(h, 0.5 * (mesh.position(mesh.from(h)) + mesh.position(mesh.to(h))));
          ++splits;
          EXPECT_EQ(mesh.n_faces(), faces + sides);
          EXPECT_EQ(mesh.n_vertices(), vertices + 1);
      }
      ASSERT_EQ(mesh.breach(), "") << "after step " << step;
      ASSERT_EQ(euler(mesh), characteristic);
    }
    EXPECT_GT(collapses, 100);
    EXPECT_GT(flips, 100);
    EXPECT_GT(splits, 100);
  }
}

// Collapsing until the link condition allows no more leaves the smallest meshes of their kind.
TEST(HalfedgeMesh, CollapsesEndAtTheSmallestMeshes) {
  const auto shrink = [](const Arrays& arrays) {
    HalfedgeMesh mesh(arrays.positions, arrays.triangles);
    for (bool changed = true; changed;) {
      changed = false;
      for (int h = 0; h < mesh.halfedge_capacity(); ++h)
        if (mesh.has_halfedge(h) && mesh.can_collapse(h)) {
          mesh.collapse(h);
          changed = true;
        }
    }
    EXPECT_EQ(mesh.breach(), "");
    return mesh;
  };
  EXPECT_EQ(shrink(grid(5, 4, false)).n_faces(), 1);     // a disc: one triangle
  EXPECT_EQ(shrink(tetrahedron_arrays()).n_faces(), 4);  // a sphere: the tetrahedron itself
  EXPECT_EQ(euler(shrink(grid(6, 5, true))), 0);
}

// A split halves the two areas and undoing it by a collapse brings the triangles back.
TEST(HalfedgeMesh, CollapseUndoesASplit) {
  const Arrays arrays = grid(3, 3, false);
  for (int h = 0; h < 3 * arrays.triangles.rows(); ++h) {
    HalfedgeMesh mesh(arrays.positions, arrays.triangles);
    const int v = mesh.from(h);
    const int m = mesh.split_edge(h, 0.3 * mesh.position(v) + 0.7 * mesh.position(mesh.to(h)));
    EXPECT_EQ(mesh.source_vertex(m), HalfedgeMesh::kNone);
    EXPECT_NEAR(area(mesh), 1, 1e-14);
    // On the border only the half-edge v → m exists: then m stays and stands for v below.
    const int back = mesh.is_border_edge(h) ? mesh.find(v, m) : mesh.find(m, v);
    ASSERT_NE(back, HalfedgeMesh::kNone);
    ASSERT_TRUE(mesh.can_collapse(back));
    mesh.collapse(back);
    EXPECT_EQ(mesh.breach(), "");
    std::set<std::set<int>> before, after;
    for (Eigen::Index f = 0; f < arrays.triangles.rows(); ++f)
      before.insert({arrays.triangles(f, 0), arrays.triangles(f, 1), arrays.triangles(f, 2)});
    const auto compact = mesh.compacted();
    for (Eigen::Index f = 0; f < compact.triangles.rows(); ++f) {
      std::set<int> corners;
      for (int k = 0; k < 3; ++k) {
        const int corner = compact.vertices[compact.triangles(f, k)];
        corners.insert(corner == m ? v : corner);
      }
      after.insert(corners);
    }
    EXPECT_EQ(before, after);
  }
}

// Two flips of one edge exchange its two faces: the set of triangles is the same again.
TEST(HalfedgeMesh, TwoFlipsOfAnEdgeRestoreTheTriangles) {
  const Arrays arrays = grid(3, 3, false);
  const auto corner_sets = [](const HalfedgeMesh& mesh) {
    std::set<std::set<int>> sets;
    for (int f = 0; f < mesh.face_capacity(); ++f)
      sets.insert({mesh.from(3 * f), mesh.from(3 * f + 1), mesh.from(3 * f + 2)});
    return sets;
  };
  HalfedgeMesh mesh(arrays.positions, arrays.triangles);
  const auto before = corner_sets(mesh);
  int flipped = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.can_flip(h)) continue;
    const int w = mesh.tip(h), x = mesh.tip(mesh.opposite(h));
    mesh.flip(h);
    EXPECT_EQ((std::set{mesh.from(h), mesh.to(h)}), (std::set{w, x}));
    EXPECT_NE(corner_sets(mesh), before);
    ASSERT_TRUE(mesh.can_flip(h));
    mesh.flip(h);
    EXPECT_EQ(corner_sets(mesh), before);
    ++flipped;
  }
  EXPECT_GT(flipped, 0);
}

// The marked border of a square stays the square's border: every border edge marked, no inner one.
TEST(HalfedgeMesh, MarksFollowTheOperations) {
  const Arrays arrays = grid(6, 6, false);
  HalfedgeMesh mesh(arrays.positions, arrays.triangles);
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_border_edge(h)) mesh.set_marked(h, true);
  Random random(5);
  for (int step = 0; step < 3000; ++step) {
    const int h = static_cast<int>(random.below(mesh.halfedge_capacity()));
    if (!mesh.has_halfedge(h)) continue;
    const auto kind = random.below(3);
    if (kind == 0 && mesh.n_faces() > 20 && mesh.can_collapse(h) &&
        (mesh.is_border_edge(h) || !mesh.is_border_vertex(mesh.from(h)))) {
      mesh.collapse(h);
    } else if (kind == 1 && mesh.can_flip(h)) {
      mesh.flip(h);
    } else if (kind == 2 && mesh.n_faces() < 300) {
      mesh.split_edge(h, Vector3d::Zero());
    }
  }
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.has_halfedge(h)) {
      EXPECT_EQ(mesh.is_marked(h), mesh.is_border_edge(h));
    }
}

// An edge inside between two vertices of the border: without it the strip would hang together in a point.
TEST(HalfedgeMesh, EdgesAcrossAStripAreNotCollapsed) {
  const Arrays strip = grid(4, 1, false);
  const HalfedgeMesh mesh(strip.positions, strip.triangles);
  int across = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (!mesh.is_border_edge(h)) {
      EXPECT_FALSE(mesh.can_collapse(h)) << mesh.from(h) << " to " << mesh.to(h);
      ++across;
    }
  EXPECT_EQ(across, 2 * 7);
}

// Two edges that a collapse lays upon each other are one that is marked where one of them was.
TEST(HalfedgeMesh, ACollapseKeepsTheMarksOfBothEdgesThatBecomeOne) {
  const Arrays arrays = grid(4, 4, false);
  for (const bool beside_start : {false, true})
    for (const bool other_face : {false, true}) {
      HalfedgeMesh mesh(arrays.positions, arrays.triangles);
      const int h = mesh.find(12, 13);  // inside, from the middle of 5 × 5 vertices to its neighbour
      ASSERT_TRUE(mesh.can_collapse(h));
      const int side = other_face ? mesh.opposite(h) : h;
      // Of the two edges from the tip of a face that fall together, one runs to each end of h.
      const int edge = beside_start != other_face ? HalfedgeMesh::prev(side) : HalfedgeMesh::next(side);
      const int tip = mesh.tip(side);
      mesh.set_marked(edge, true);
      mesh.collapse(h);
      EXPECT_EQ(mesh.breach(), "");
      const int joint = mesh.find(13, tip);
      ASSERT_NE(joint, HalfedgeMesh::kNone);
      EXPECT_TRUE(mesh.is_marked(joint)) << beside_start << other_face;
    }
}

TEST(HalfedgeMesh, BadInputIsRefusedWithThePlace) {
  Arrays arrays = grid(2, 2, false);
  arrays.triangles(3, 1) = 99;
  EXPECT_NE(message_of(arrays.positions, arrays.triangles).find("face 3"), std::string::npos);
  arrays = grid(2, 2, false);
  arrays.triangles(3, 1) = arrays.triangles(3, 0);
  EXPECT_NE(message_of(arrays.positions, arrays.triangles).find("face 3"), std::string::npos);
  arrays = grid(2, 2, false);
  std::swap(arrays.triangles(3, 1), arrays.triangles(3, 0));  // turned inside out
  EXPECT_NE(message_of(arrays.positions, arrays.triangles).find("edge from vertex"), std::string::npos);
  arrays = grid(2, 2, false);
  arrays.positions(4, 2) = std::numeric_limits<double>::infinity();
  EXPECT_NE(message_of(arrays.positions, arrays.triangles).find("vertex 4"), std::string::npos);
}

// Two triangles that touch in a point: refused with the vertex named, or given a vertex each.
TEST(HalfedgeMesh, FansThatMeetInAPointAreRefusedOrSplit) {
  Points positions(5, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0;
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 0, 3, 4;
  EXPECT_NE(message_of(positions, triangles).find("vertex 0"), std::string::npos);
  const HalfedgeMesh mesh(positions, triangles, NonManifoldVertices::Split);
  EXPECT_EQ(mesh.breach(), "");
  EXPECT_EQ(mesh.n_vertices(), 6);
  EXPECT_EQ(mesh.source_vertex(5), 0);
  EXPECT_EQ(mesh.position(5), mesh.position(0));
}

TEST(HalfedgeMesh, AnEmptyMeshIsAMesh) {
  const HalfedgeMesh mesh(Points(0, 3), Triangles(0, 3));
  EXPECT_EQ(mesh.n_faces(), 0);
  EXPECT_EQ(mesh.compacted().triangles.rows(), 0);
}

}  // namespace
}  // namespace batten
