#include "batten/modelling/soundness.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

/// Two unit squares in the plane z = 0, side by side, of two triangles each; one face of the model each.
TriangleMesh two_squares() {
  TriangleMesh mesh;
  mesh.positions.resize(6, 3);
  mesh.positions << 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4;
  mesh.normals = Points::Zero(6, 3);
  mesh.normals.col(2).setOnes();
  return mesh;
}

TEST(TurnedTriangles, AreThoseAgainstTheNormalsButForCreases) {
  TriangleMesh mesh = two_squares();
  EXPECT_TRUE(turned_triangles(mesh, std::vector<char>(6, 0)).empty());
  mesh.triangles.row(2) << 2, 1, 5;
  EXPECT_EQ(turned_triangles(mesh, std::vector<char>(6, 0)), std::vector<int>{2});
  // All its vertices on creases: their normals are means of both sides and say nothing.
  EXPECT_TRUE(turned_triangles(mesh, {0, 1, 1, 0, 0, 1}).empty());
}

TEST(SurfaceSoundness, NamesTheFacesThatCrossOrHoldTurnedTriangles) {
  TriangleMesh mesh = two_squares();
  EXPECT_TRUE(surface_soundness(mesh, {}, {7, 7, 9, 9}).is_sound());
  const SurfaceSoundness turned = surface_soundness(mesh, {3}, {7, 7, 9, 9});
  EXPECT_EQ(turned.broken_faces, std::vector<int>{9});
  EXPECT_NE(turned.sentence().find("f9"), std::string::npos);
  // A fifth triangle that goes upright through the first one, of face 11.
  mesh.positions.conservativeResize(9, 3);
  mesh.positions.bottomRows(3) << 0.6, 0.1, -1, 0.6, 0.3, -1, 0.6, 0.2, 1;
  mesh.triangles.conservativeResize(5, 3);
  mesh.triangles.row(4) << 6, 7, 8;
  const SurfaceSoundness crossing = surface_soundness(mesh, {}, {7, 7, 9, 9, 11});
  EXPECT_EQ(crossing.crossing_pairs, 1u);
  EXPECT_EQ(crossing.broken_faces, (std::vector<int>{7, 11}));
}

}  // namespace
}  // namespace batten
