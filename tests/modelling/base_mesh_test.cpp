#include "batten/modelling/base_mesh.hpp"

#include "sketch/quadrics.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using namespace strokes;

Eigen::RowVector3d begin_of(const BaseMesh& mesh, int side) {
  const SharedPolyline line = mesh.polyline_of(side);
  return line->front().transpose();
}

Eigen::RowVector3d end_of_side(const BaseMesh& mesh, int side) {
  const SharedPolyline line = mesh.polyline_of(side);
  return line->back().transpose();
}

/// Every face is a closed walk of three or four sides, every edge of a closed surface is walked once each
/// way, and polylines run from vertex to vertex.
void expect_closed_surface(const BaseMesh& mesh) {
  std::vector<int> walks(2 * mesh.edges.size(), 0);
  for (const BaseFace& face : mesh.faces) {
    ASSERT_TRUE(face.sides.size() == 3 || face.sides.size() == 4);
    for (size_t k = 0; k < face.sides.size(); ++k) {
      const int side = face.sides[k], next = face.sides[(k + 1) % face.sides.size()];
      ++walks[static_cast<size_t>(side)];
      EXPECT_LT((end_of_side(mesh, side) - begin_of(mesh, next)).norm(), 1e-12);
    }
  }
  for (const int n : walks) EXPECT_EQ(n, 1);
  for (const BaseEdge& edge : mesh.edges) {
    EXPECT_LT((edge.polyline->front() - mesh.positions[static_cast<size_t>(edge.from)]).norm(), 1e-12);
    EXPECT_LT((edge.polyline->back() - mesh.positions[static_cast<size_t>(edge.to)]).norm(), 1e-12);
  }
}

int euler(const BaseMesh& mesh) {
  return static_cast<int>(mesh.positions.size()) - static_cast<int>(mesh.edges.size()) +
         static_cast<int>(mesh.faces.size());
}

// Faces of three sides stay what they are: the octants of a sphere.
TEST(Triquadrified, KeepsTrianglesWhole) {
  const BaseMesh mesh = triquadrified(three_great_circles());
  EXPECT_EQ(mesh.positions.size(), 6u);
  EXPECT_EQ(mesh.edges.size(), 12u);
  EXPECT_EQ(mesh.faces.size(), 8u);
  EXPECT_EQ(mesh.n_divided, 0);
  EXPECT_EQ(mesh.n_diagonals, 0);
  EXPECT_EQ(euler(mesh), 2);
  expect_closed_surface(mesh);
  for (const std::vector<int>& pieces : mesh.edges_of_edge) EXPECT_LE(pieces.size(), 1u);
  for (const BaseEdge& edge : mesh.edges) EXPECT_TRUE(edge.drawn);
}

// A side walked backwards is the same line turned round.
TEST(BaseMesh, SidesRunBothWaysAlongOneLine) {
  const BaseMesh mesh = triquadrified(three_great_circles());
  for (int e = 0; e < static_cast<int>(mesh.edges.size()); ++e) {
    const SharedPolyline forwards = mesh.polyline_of(side_of(e, false)),
                         backwards = mesh.polyline_of(side_of(e, true));
    EXPECT_EQ(forwards->points(), Points(backwards->points().colwise().reverse()));
  }
}

// Two discs on one circle: the edges of faces with two sides are halved first, so that each has four.
TEST(Triquadrified, HalvesTheEdgesOfFacesWithTwoSides) {
  const PolylineMesh lens =
      model({{circle(kO, kX, kY), {}}, {{arc(kO, kX, 0.3 * kZ, 0, kPi), false}, {.into = Into::Opening}}});
  const BaseMesh mesh = triquadrified(lens);
  expect_closed_surface(mesh);
  EXPECT_EQ(euler(mesh), 2);
  for (size_t e = 0; e < mesh.edges_of_edge.size(); ++e) {
    if (!lens.edge(static_cast<int>(e)).alive) continue;
    double length = 0;
    for (const int piece : mesh.edges_of_edge[e])
      length += mesh.edges[static_cast<size_t>(piece)].polyline->length();
    EXPECT_NEAR(length, lens.edge(static_cast<int>(e)).polyline->length(), 1e-9) << e;
  }
}

TEST(Triquadrified, RefusesAModelWithoutFaces) {
  EXPECT_THROW(triquadrified(PolylineMesh()), InvalidInput);
}

}  // namespace
}  // namespace batten
