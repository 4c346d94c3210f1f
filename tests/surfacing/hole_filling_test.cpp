#include "batten/surfacing/hole_filling.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/mesh/welding.hpp"

namespace batten {
namespace {

/// The unit sphere, welded, without the triangles that lie within `angle` radians of a pole.
TriangleMesh sphere_with_hole(int n, double angle) {
  const TriangleMesh whole = fixtures::as_mesh(fixtures::sphere(n));
  const VertexWelding welding = weld_borders(whole.positions, whole.triangles, 1e-9);
  TriangleMesh mesh;
  mesh.positions = whole.positions;
  mesh.triangles = welded_triangles(whole.triangles, welding);
  const Eigen::RowVector3d pole = Eigen::RowVector3d(0.3, 0.5, 0.8).normalized();
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    double least = 1;
    for (int k = 0; k < 3; ++k) least = std::min(least, mesh.positions.row(mesh.triangles(f, k)).dot(pole));
    if (least < std::cos(angle)) mesh.triangles.row(kept++) = mesh.triangles.row(f).eval();
  }
  mesh.triangles.conservativeResize(kept, 3);
  return mesh;
}

int n_open_loops(const TriangleMesh& mesh) {
  return mesh_topology(mesh.triangles, mesh.n_vertices()).n_boundary_loops;
}

// A sphere is fair: what fills a hole in it is the missing piece, and normals go on across the rim.
TEST(FilledMesh, MakesASphereWholeAgain) {
  for (const double angle : {0.2, 0.5, 0.9}) {
    const TriangleMesh open = sphere_with_hole(16, angle);
    ASSERT_EQ(n_open_loops(open), 1);
    const FilledMesh filled = filled_mesh(open);
    ASSERT_EQ(filled.holes.size(), 1u);
    EXPECT_TRUE(filled.holes[0].fair);
    const TriangleMesh& mesh = filled.mesh;
    EXPECT_TRUE(mesh_topology(mesh.triangles, mesh.n_vertices()).is_watertight());
    EXPECT_TRUE(self_intersections(mesh.positions, mesh.triangles).empty());
    // The triangles themselves miss the sphere by h²/8 of their edges, 0.1 long: 0.001.
    double furthest = 0;
    for (Eigen::Index v = open.n_vertices(); v < mesh.n_vertices(); ++v)
      furthest = std::max(furthest, std::abs(mesh.positions.row(v).norm() - 1));
    EXPECT_LT(furthest, 0.003) << angle;
    const Points normals = vertex_normals(mesh.positions, mesh.triangles);
    for (const int v : filled.holes[0].rim)
      EXPECT_GT(normals.row(v).dot(mesh.positions.row(v)), std::cos(0.07)) << angle;
  }
}

TEST(FilledMesh, KeepsWhatWasGivenAndInterpolatesValues) {
  TriangleMesh open = sphere_with_hole(8, 0.7);
  open.vertex_values["one"] = Eigen::VectorXd::Ones(open.n_vertices());
  open.normals = vertex_normals(open.positions, open.triangles);
  const TriangleMesh mesh = filled_mesh(open).mesh;
  EXPECT_EQ(mesh.positions.topRows(open.n_vertices()), open.positions);
  EXPECT_EQ(mesh.triangles.topRows(open.n_triangles()), open.triangles);
  ASSERT_EQ(mesh.vertex_values.at("one").size(), mesh.n_vertices());
  EXPECT_LT((mesh.vertex_values.at("one").array() - 1).abs().maxCoeff(), 1e-12);
  ASSERT_EQ(mesh.normals.rows(), mesh.n_vertices());
  for (Eigen::Index v = open.n_vertices(); v < mesh.n_vertices(); ++v)
    EXPECT_GT(mesh.normals.row(v).dot(mesh.positions.row(v)), 0.9);
}

TEST(FilledMesh, FillsUpToTheNumberOfEdgesAndLeavesWhatItIsToldTo) {
  const TriangleMesh open = sphere_with_hole(8, 0.7);
  const auto n = static_cast<int>(filled_mesh(open).holes[0].rim.size());
  HoleFillingOptions options;
  options.most_edges = n - 1;
  EXPECT_EQ(filled_mesh(open, options).n_filled(), 0);
  options.most_edges = n;
  EXPECT_EQ(filled_mesh(open, options).n_filled(), 1);
  options.left_open.assign(static_cast<size_t>(open.n_vertices()), 0);
  options.left_open[at(filled_mesh(open).holes[0].rim[2])] = 1;
  EXPECT_EQ(filled_mesh(open, options).n_filled(), 0);
  EXPECT_EQ(filled_mesh(open, options).mesh.triangles, open.triangles);
  options.most_edges = 2;
  EXPECT_EQ(options.problem(open.n_vertices()), "most_edges must be at least 3, got 2");
  EXPECT_THROW(filled_mesh(open, options), InvalidInput);
  options.most_edges = 3;
  EXPECT_EQ(options.problem(open.n_vertices()), std::nullopt);
  EXPECT_NE(options.problem(open.n_vertices() + 1).value_or("").find("left_open must"), std::string::npos);
  options.left_open.pop_back();
  EXPECT_THROW(filled_mesh(open, options), InvalidInput);
}

// Where the rim has an ear of one triangle, whose other two vertices the mesh joins already, an inner edge
// between them would have four triangles.
TEST(FilledMesh, StaysManifoldOverEveryRim) {
  const TriangleMesh whole = sphere_with_hole(6, 1e-9);
  for (Eigen::Index first = 0; first < whole.n_triangles(); first += 7) {
    TriangleMesh open = whole;  // a triangle and all that touch one of its corners
    Eigen::Index kept = 0;
    for (Eigen::Index f = 0; f < whole.n_triangles(); ++f) {
      bool touches = f == first;
      for (int k = 0; k < 3; ++k) touches = touches || whole.triangles(f, k) == whole.triangles(first, 0);
      if (!touches && f % 11 != 3) open.triangles.row(kept++) = whole.triangles.row(f);
    }
    open.triangles.conservativeResize(kept, 3);
    if (!mesh_topology(open.triangles, open.n_vertices()).is_manifold()) continue;
    const FilledMesh filled = filled_mesh(open);
    EXPECT_EQ(filled.n_filled(), static_cast<int>(filled.holes.size()));
    const MeshTopology topology = mesh_topology(filled.mesh.triangles, filled.mesh.n_vertices());
    EXPECT_TRUE(topology.is_watertight()) << first;
    EXPECT_EQ(topology.euler_characteristic, 2) << first;
  }
}

TEST(FilledMesh, Cancels) {
  EXPECT_THROW(
      filled_mesh(sphere_with_hole(6, 0.7), {}, Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace batten
