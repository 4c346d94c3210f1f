#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/simulation/mesh_polylines_detail.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten::detail {
namespace {

/// The unit square of n × n cells without the middle ones, seen from above.
TriangleMesh frame(int n) {
  TriangleMesh mesh;
  mesh.positions.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.positions.row(j * (n + 1) + i) << i / static_cast<double>(n), j / static_cast<double>(n), 0;
  std::vector<Eigen::RowVector3i> triangles;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (std::min({i, j, n - 1 - i, n - 1 - j}) > 0) continue;
      const int v = j * (n + 1) + i;
      triangles.emplace_back(v, v + 1, v + n + 2);
      triangles.emplace_back(v, v + n + 2, v + n + 1);
    }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (size_t f = 0; f < triangles.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) = triangles[f];
  return mesh;
}

double area_within(const std::vector<Eigen::Vector3d>& points) {
  double twice = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d& p = points[k];
    const Eigen::Vector3d& q = points[(k + 1) % points.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return twice / 2;
}

TEST(MeshEdgeFaces, AcrossAnEdgeAndBackIsTheSameFace) {
  const TriangleMesh mesh = shape_mesh(AnalyticShape::Torus, 0.1);
  const MeshEdgeFaces faces(mesh);
  for (int f = 0; f < static_cast<int>(mesh.n_triangles()); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles(f, k), b = mesh.triangles(f, (k + 1) % 3);
      const MeshEdge edge(std::min(a, b), std::max(a, b));
      const int beyond = faces.across(edge, f);
      ASSERT_GE(beyond, 0);
      ASSERT_NE(beyond, f);
      EXPECT_EQ(faces.across(edge, beyond), f);
    }
  EXPECT_TRUE(faces.border_loops().empty());
}

// The outer border runs counter-clockwise around the area 1, the inner one clockwise around (1 − 2/n)².
TEST(MeshPolylines, BordersHaveTheSurfaceOnTheirLeft) {
  const TriangleMesh mesh = frame(5);
  const Points normals = vertex_normals(mesh.positions, mesh.triangles);
  const std::vector<MeshPolyline> borders = border_polylines(mesh, normals, MeshEdgeFaces(mesh));
  ASSERT_EQ(borders.size(), 2U);
  std::multiset<double> areas;
  for (const MeshPolyline& border : borders) {
    EXPECT_TRUE(border.closed);
    EXPECT_EQ(border.edges.size(), border.points.size());
    areas.insert(area_within(border.points));
  }
  EXPECT_NEAR(*areas.begin(), -0.36, 1e-12);
  EXPECT_NEAR(*areas.rbegin(), 1, 1e-12);
  EXPECT_NEAR(borders[0].length() + borders[1].length(), 4 + 4 * 0.6, 1e-12);
}

// Two sides of the frame are cut, each from border to border; what a plane cuts of it is known exactly.
TEST(MeshPolylines, SectionsOfAnOpenMeshRunFromBorderToBorder) {
  const TriangleMesh mesh = frame(5);
  const Points normals = vertex_normals(mesh.positions, mesh.triangles);
  const MeshEdgeFaces faces(mesh);
  for (const int axis : {0, 1}) {
    const std::vector<MeshPolyline> sections = plane_sections(mesh, normals, faces, axis, 0.47);
    ASSERT_EQ(sections.size(), 2U);
    for (const MeshPolyline& section : sections) {
      EXPECT_FALSE(section.closed);
      EXPECT_EQ(section.faces.size(), section.n_pieces());
      EXPECT_NEAR(section.length(), 0.2, 1e-12);
    }
  }
  EXPECT_EQ(plane_sections(mesh, normals, faces, 0, 0.13).size(), 1U);
  EXPECT_TRUE(plane_sections(mesh, normals, faces, 0, 1.5).empty());
}

// Every piece of a section lies in its face: both its ends are on edges of that face, and in the plane. Each
// face that the plane cuts is met once.
TEST(MeshPolylines, PiecesOfASectionLieInTheirFaces) {
  const TriangleMesh mesh = shape_mesh(AnalyticShape::Torus, 0.03);
  const double offset = clear_offset(mesh.positions.col(1), 0.7, 12);
  const std::vector<MeshPolyline> sections =
      plane_sections(mesh, mesh.normals, MeshEdgeFaces(mesh), 1, offset);
  ASSERT_EQ(sections.size(), 2U);
  std::multiset<int> met;
  for (const MeshPolyline& section : sections) {
    EXPECT_TRUE(section.closed);
    for (size_t k = 0; k < section.n_pieces(); ++k) {
      EXPECT_NEAR(section.points[k].y(), offset, 1e-12);
      const Eigen::RowVector3i corners = mesh.triangles.row(section.faces[k]);
      for (const MeshEdge& edge : {section.edges[k], section.edges[(k + 1) % section.edges.size()]})
        for (const int v : {edge.first, edge.second}) EXPECT_TRUE((corners.array() == v).any());
      met.insert(section.faces[k]);
    }
  }
  std::multiset<int> cut;
  for (int f = 0; f < static_cast<int>(mesh.n_triangles()); ++f) {
    int below = 0;
    for (int k = 0; k < 3; ++k) below += mesh.positions(mesh.triangles(f, k), 1) < offset ? 1 : 0;
    if (below == 1 || below == 2) cut.insert(f);
  }
  EXPECT_EQ(met, cut);
}

TEST(MeshPolylines, OffsetsKeepClearOfVertices) {
  const Eigen::VectorXd coordinates = Eigen::VectorXd::LinSpaced(11, 0, 1);
  EXPECT_EQ(clear_offset(coordinates, 0.55, 1), 0.55);
  const double moved = clear_offset(coordinates, 0.5, 1);
  EXPECT_GT((coordinates.array() - moved).abs().minCoeff(), 1e-9);
  EXPECT_LT(std::abs(moved - 0.5), 1e-3);
}

}  // namespace
}  // namespace batten::detail
