#include "modelling/sharp_cube.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "batten/modelling/surface_records_detail.hpp"

namespace batten {
namespace {

using namespace strokes;
using detail::FaceSet;
using detail::SurfacePart;
using detail::SurfaceRecords;

/// The sphere of three great circles: eight faces, four around each of six vertices.
class RecordsOfSphere : public testing::Test {
 protected:
  RecordsOfSphere() { records.adopt(mesh); }

  /// A face that shares no vertex with `face`, or one that shares just one, or an edge.
  int face_sharing(int face, int n_vertices) const {
    const std::set<int> own = vertices_of(face);
    for (int f = 0; f < 8; ++f) {
      const std::set<int> other = vertices_of(f);
      if (std::count_if(other.begin(), other.end(), [&](int v) { return own.count(v) > 0; }) == n_vertices)
        return f;
    }
    return -1;
  }
  std::set<int> vertices_of(int face) const {
    std::set<int> vertices;
    for (const int side : mesh.face(face).sides) vertices.insert(mesh.start_of(side));
    return vertices;
  }

  PolylineMesh mesh = ellipsoid(1, 1, 1);
  SurfaceRecords records;
};

// Three splits: 16 quads per side of a face, 8 parts per edge. Vertices: 6, 12 × 7 on edges and 37 in each
// face (its 48 quads, by Euler: V = 48 + 1 + 24 / 2 in all, 24 of them on its boundary).
TEST_F(RecordsOfSphere, HaveTheQuadsOfEveryFace) {
  for (const detail::FaceRecord& face : records.faces) {
    EXPECT_TRUE(face.alive && face.stale);
    EXPECT_EQ(face.quads.size(), 48U);
    EXPECT_EQ(face.inner.size(), 37U);
  }
  EXPECT_EQ(records.positions.size(), 6U + 12 * 7 + 8 * 37);
  EXPECT_TRUE(records.unused.empty());
}

TEST_F(RecordsOfSphere, SetsGrowByFacesThatShareAVertex) {
  FaceSet set = records.set_of({3}, mesh);
  EXPECT_EQ(set.list, std::vector<int>{3});
  EXPECT_TRUE(records.grow(set, mesh));
  EXPECT_EQ(set.list.size(), 7U);
  EXPECT_FALSE(set.has[static_cast<size_t>(face_sharing(3, 0))]) << "the face opposite";
  EXPECT_TRUE(records.grow(set, mesh));
  EXPECT_FALSE(records.grow(set, mesh)) << "all are in it";
}

// Two faces that meet at one vertex only are no surface there: the other two around it are needed. Those with
// a common edge are one, and so are all four.
TEST_F(RecordsOfSphere, FansAreClosedWhereFacesMeetAtOneVertex) {
  FaceSet touching = records.set_of({0, face_sharing(0, 1)}, mesh);
  records.close_fans(touching, mesh);
  EXPECT_EQ(touching.list.size(), 4U);
  EXPECT_TRUE(std::is_sorted(touching.list.begin(), touching.list.end()));
  FaceSet beside = records.set_of({0, face_sharing(0, 2)}, mesh);
  records.close_fans(beside, mesh);
  EXPECT_EQ(beside.list.size(), 2U);
}

TEST_F(RecordsOfSphere, WhatNothingHoldsGoesTogether) {
  const int side = mesh.face(0).sides[0];
  records.edges[static_cast<size_t>(edge_of(side))].drawn = false;
  const FaceSet set = records.set_of({0}, mesh);
  EXPECT_EQ(set.list.size(), 2U);
  EXPECT_TRUE(set.has[static_cast<size_t>(mesh.face_of(opposite_side(side)))]);
}

// One face alone: its 37 inner vertices are complete and free; the 24 around it are held by drawn curves and
// have further faces; none is on a border.
TEST_F(RecordsOfSphere, PartsKnowWhichVerticesAreComplete) {
  const SurfacePart part = records.part(records.set_of({5}, mesh), mesh);
  ASSERT_EQ(part.vertices.size(), 61U);
  EXPECT_EQ(std::count(part.complete.begin(), part.complete.end(), 1), 37);
  EXPECT_EQ(std::count(part.held.begin(), part.held.end(), 1), 24);
  EXPECT_EQ(std::count(part.border.begin(), part.border.end(), 1), 0);
  EXPECT_EQ(std::count(records.local.begin(), records.local.end(), -1),
            static_cast<std::ptrdiff_t>(records.local.size()))
      << "the scratch is left as it was";
  for (size_t v = 0; v < part.vertices.size(); ++v) EXPECT_NE(part.complete[v], part.held[v]) << v;
}

// Places that a curve needed are given back when it is gone, and taken again by the next.
TEST_F(RecordsOfSphere, PlacesAreUsedAgain) {
  const size_t before = records.positions.size();
  PolylineMesh divided = mesh;
  edit(divided, [&](PolylineMesh& m) {
    return insert_curve(m, {arc(kO, (kX + kY).normalized(), kZ, 0, kPi / 2), false}, {.snap = 0.02});
  });
  records.adopt(divided);
  const size_t most = records.positions.size();
  EXPECT_GT(most - records.unused.size(), before);
  records.adopt(mesh);
  EXPECT_EQ(records.positions.size() - records.unused.size(), before);
  records.adopt(divided);
  EXPECT_EQ(records.positions.size(), most);
}

// What did not change stays: only the face that a curve divides is stale afterwards, and its neighbour across
// the edge that got a vertex.
TEST_F(RecordsOfSphere, OnlyTouchedFacesBecomeStale) {
  for (detail::FaceRecord& face : records.faces) face.stale = false;
  records.adopt(mesh);
  for (const detail::FaceRecord& face : records.faces) EXPECT_FALSE(face.stale);
  PolylineMesh divided = mesh;
  edit(divided, [&](PolylineMesh& m) {
    return insert_curve(m, {arc(kO, (kX + kY).normalized(), kZ, 0, kPi / 2), false}, {.snap = 0.02});
  });
  records.adopt(divided);
  EXPECT_EQ(std::count_if(records.faces.begin(), records.faces.end(),
                          [](const detail::FaceRecord& face) { return face.alive && face.stale; }),
            3);
}

}  // namespace
}  // namespace batten
