#include "batten/operators/intrinsic.hpp"

#include "operators/sample_meshes.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

using samples::square;

TEST(IntrinsicDelaunay, LeavesNoNegativeWeightAndKeepsTheArea) {
  // A stretched grid: diagonals opposite obtuse angles.
  TriangleMesh mesh = square(10, 0.5);
  mesh.positions.col(0) *= 4;
  const EdgeLengths lengths = edge_lengths(mesh.positions, mesh.triangles);
  const IntrinsicTriangulation flipped = intrinsic_delaunay(mesh.triangles, lengths);
  EXPECT_GT(flipped.flips, 10);
  const SparseMatrix K = cotangent_stiffness(flipped.triangles, flipped.lengths, mesh.n_vertices());
  const std::vector<char> border = border_vertices(mesh.triangles, mesh.n_vertices());
  for (Eigen::Index column = 0; column < K.outerSize(); ++column)
    for (SparseMatrix::InnerIterator e(K, column); e; ++e)
      if (e.row() != column && !(border[e.row()] && border[column])) {
        EXPECT_LE(e.value(), 1e-8);
      }
  EXPECT_NEAR(lumped_mass(flipped.triangles, flipped.lengths, mesh.n_vertices()).sum(), 4, 1e-12);
  // In the plane the flipped edges are straight: their lengths are distances of the vertices.
  EXPECT_LT((edge_lengths(mesh.positions, flipped.triangles) - flipped.lengths).norm(), 1e-11);
}

// On a tetrahedron all vertices are joined, so that a flip would join two of them twice: none is made,
// however obtuse the angles at 2 and 3 are, which lie opposite the long edge 0-1.
TEST(IntrinsicDelaunay, MakesNoDoubleEdges) {
  const Points positions = (Points(4, 3) << -2, 0, 0, 2, 0, 0, 0, 0.5, 0.1, 0, -0.5, 0.1).finished();
  const Triangles triangles = (Triangles(4, 3) << 2, 0, 1, 3, 1, 0, 2, 1, 3, 2, 3, 0).finished();
  const EdgeLengths lengths = edge_lengths(positions, triangles);
  const SparseMatrix K = cotangent_stiffness(triangles, lengths, 4);
  ASSERT_GT(K.coeff(0, 1), 0.1);  // a negative weight: the edge is not Delaunay
  const IntrinsicTriangulation result = intrinsic_delaunay(triangles, lengths);
  EXPECT_EQ(result.flips, 0);
  EXPECT_EQ(result.triangles, triangles);
}

TEST(OppositeHalfEdges, FindsBordersAndRefusesThreeTrianglesAtAnEdge) {
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 2, 1, 3;
  const std::vector<int> opposite = opposite_half_edges(triangles);
  EXPECT_EQ(opposite[0], 5);  // 1-2 of the first lies against 2-1 of the second
  EXPECT_EQ(opposite[5], 0);
  EXPECT_EQ(std::count(opposite.begin(), opposite.end(), -1), 4);
  Triangles three(3, 3);
  three << 0, 1, 2, 2, 1, 3, 2, 1, 4;
  EXPECT_THROW(opposite_half_edges(three), InvalidInput);
}

}  // namespace
}  // namespace batten
