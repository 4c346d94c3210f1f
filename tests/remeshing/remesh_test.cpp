#include "batten/remeshing/remesh.hpp"

#include "mesh/shapes.hpp"
#include "mesh/tiles.hpp"
#include "remeshing/surfaces.hpp"
#include "report_gaps.hpp"
#include "threads.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/progress.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/feature_chains.hpp"
#include "batten/remeshing/measures.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using fixtures::cube;

struct Angles {
  double mean = 0, least = 180;
};
/// Of the smallest angles of the triangles, degrees.
Angles smallest_angles(const TriangleMesh& mesh) {
  Angles angles;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    double least = 180;
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = mesh.positions.row(mesh.triangles(f, k));
      const Vector3d a = Vector3d(mesh.positions.row(mesh.triangles(f, (k + 1) % 3))) - p,
                     b = Vector3d(mesh.positions.row(mesh.triangles(f, (k + 2) % 3))) - p;
      least = std::min(least, degrees(std::atan2(a.cross(b).norm(), a.dot(b))));
    }
    angles.mean += least / static_cast<double>(mesh.n_triangles());
    angles.least = std::min(angles.least, least);
  }
  return angles;
}

double volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Vector3d a = mesh.positions.row(mesh.triangles(f, 0)), b = mesh.positions.row(mesh.triangles(f, 1)),
                   c = mesh.positions.row(mesh.triangles(f, 2));
    sum += a.dot(b.cross(c)) / 6;
  }
  return sum;
}

// A cube is its twelve edges: when they are kept, every new triangle lies in a face, so volume and distances
// are exact up to rounding. Both methods, even and adaptive.
TEST(Remesh, KeepsTheCubeExactly) {
  const TriangleMesh input = cube(8);
  const TriangleTree tree(input.positions, input.triangles);
  for (const RemeshMethod method : {RemeshMethod::Adaptive, RemeshMethod::LaplacianFlow})
    for (const double adaptivity : {0.0, 1.0}) {
      RemeshOptions options;
      options.method = method;
      options.adaptivity = adaptivity;
      const RemeshResult result = remesh(input, options);
      EXPECT_NEAR(volume(result.mesh), 1, 1e-9);
      EXPECT_LT(distances(tree.closest(result.mesh.positions)).maxCoeff(), 1e-9);
      EXPECT_EQ(result.report.corners, 8);
      const HalfedgeMesh mesh(result.mesh.positions, result.mesh.triangles);
      EXPECT_EQ(mesh.breach(), "");
      EXPECT_EQ(result.mesh.n_vertices() - result.mesh.n_triangles() / 2, 2);  // Euler, closed
      EXPECT_GE(smallest_angles(result.mesh).mean, 45);
    }
}

// A mesh of N vertices is asked for by number and by the edge of the equilateral triangles it would have.
TEST(Remesh, MeetsTheNumberOfVertices) {
  const TriangleMesh input = cube(10);
  for (const int n : {300, 1000, 3000}) {
    RemeshOptions by_number, by_edge;
    by_number.n_vertices = n;
    by_edge.edge_length = std::sqrt(2 * 6.0 / (std::sqrt(3.0) * n));
    for (const RemeshOptions& options : {by_number, by_edge})
      EXPECT_NEAR(static_cast<double>(remesh(input, options).mesh.n_vertices()), n, 0.06 * n);
  }
}

// The unit must not matter, nor where the shape lies.
TEST(Remesh, ScalesWithTheUnit) {
  const TriangleMesh input = cube(6);
  const RemeshResult expected = remesh(input);
  for (const double scale : {1.0 / 1024, 1024.0}) {  // powers of two: the same roundings
    TriangleMesh scaled = input;
    scaled.positions *= scale;
    const RemeshResult result = remesh(scaled);
    ASSERT_EQ(result.mesh.n_vertices(), expected.mesh.n_vertices());
    EXPECT_LT((result.mesh.positions / scale - expected.mesh.positions).cwiseAbs().maxCoeff(), 1e-3);
  }
}

// A square with a border: the border stays, so the area does, and no vertex leaves the plane.
TEST(Remesh, KeepsTheBorderOfASquare) {
  TriangleMesh square;
  const int n = 9;
  square.positions.resize((n + 1) * (n + 1), 3);
  square.triangles.resize(2 * n * n, 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) square.positions.row(i * (n + 1) + j) << i, j, 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j;
      square.triangles.row(2 * (i * n + j)) << a, a + n + 1, a + n + 2;
      square.triangles.row(2 * (i * n + j) + 1) << a, a + n + 2, a + 1;
    }
  RemeshOptions options;
  options.edge_length = 0.8;
  const RemeshResult result = remesh(square, options);
  double area = 0;
  const HalfedgeMesh mesh(result.mesh.positions, result.mesh.triangles);
  for (int f = 0; f < mesh.face_capacity(); ++f) area += 0.5 * mesh.area_normal(f).z();
  EXPECT_NEAR(area, n * n, 1e-9);
  EXPECT_EQ(result.mesh.positions.col(2).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(result.report.corners, 4);
}

// Tiles of one sphere, remeshed apart to edges three times as long as those on their borders, and to half of
// them: joined again they are a sphere without cracks, with every border edge where it was.
TEST(Remesh, TilesWithHeldBordersJoinWithoutCracks) {
  const TriangleMesh whole = fixtures::as_mesh(fixtures::sphere(12));
  for (const double edge : {0.05, 0.35}) {
    RemeshOptions options;
    options.edge_length = edge;
    options.hold_border = true;
    TriangleMesh halves[2];
    for (const bool upper : {false, true}) {
      const TriangleMesh half = fixtures::half_at_x0(whole, upper);
      halves[upper ? 1 : 0] = remesh(half, options).mesh;
      EXPECT_EQ(fixtures::border_places(halves[upper ? 1 : 0]), fixtures::border_places(half)) << edge;
      EXPECT_GT(smallest_angles(halves[upper ? 1 : 0]).mean, 40) << edge;
    }
    const TriangleMesh joined = fixtures::joined(halves[0], halves[1]);
    EXPECT_TRUE(fixtures::border_places(joined).empty());
    EXPECT_EQ(joined.n_vertices() * 2, joined.n_triangles() + 4);  // χ = 2
  }
}

// Sizes given per vertex: edges near the fine side are shorter, in the wanted ratio.
TEST(Remesh, FollowsTheSizesGiven) {
  const TriangleMesh input = cube(16);
  RemeshOptions options;
  options.sizes = (0.05 + 0.1 * input.positions.col(0).array()).matrix();
  const RemeshResult result = remesh(input, options);
  double fine = 0, coarse = 0;
  int n_fine = 0, n_coarse = 0;
  for (Eigen::Index f = 0; f < result.mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = result.mesh.positions.row(result.mesh.triangles(f, k)),
                     b = result.mesh.positions.row(result.mesh.triangles(f, (k + 1) % 3));
      if (std::max(a.x(), b.x()) < 0.1) fine += (a - b).norm(), ++n_fine;
      if (std::min(a.x(), b.x()) > 0.9) coarse += (a - b).norm(), ++n_coarse;
    }
  EXPECT_NEAR(fine / n_fine, 0.055, 0.012);
  EXPECT_NEAR(coarse / n_coarse, 0.145, 0.03);
}

TEST(Remesh, RefusesBadInputAndOptions) {
  const TriangleMesh input = cube(3);
  EXPECT_THROW(remesh(TriangleMesh{}), InvalidInput);
  RemeshOptions options;
  options.adaptivity = 2;
  EXPECT_THROW(remesh(input, options), InvalidInput);
  options = {};
  options.edge_length = 0.1;
  options.n_vertices = 100;
  EXPECT_THROW(remesh(input, options), InvalidInput);
  options = {};
  options.sizes = Eigen::VectorXd::Ones(3);
  EXPECT_THROW(remesh(input, options), InvalidInput);
  options.sizes = Eigen::VectorXd::Zero(input.n_vertices());
  EXPECT_THROW(remesh(input, options), InvalidInput);
  TriangleMesh turned = input;
  std::swap(turned.triangles(0, 0), turned.triangles(0, 1));
  EXPECT_THROW(remesh(turned), InvalidInput);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(remesh(input, {}, stop), Cancelled);
}

/// Share of the inner vertices with six edges.
double share_of_six(const TriangleMesh& result) {
  const HalfedgeMesh mesh(result.positions, result.triangles);
  int six = 0, all = 0;
  for (int v = 0; v < mesh.vertex_capacity(); ++v)
    if (mesh.has_vertex(v) && !mesh.is_border_vertex(v)) {
      ++all;
      six += mesh.valence(v) == 6 ? 1 : 0;
    }
  return static_cast<double>(six) / all;
}

// The acceptance on fandisk at the mean edge length of the input. Bounds of vertices, distance and normals
// are what MeshLab's isotropic remeshing reaches on the same input (distances over the diameter).
TEST(Remesh, BeatsIsotropicRemeshingOnFandisk) {
  const std::string path = BATTEN_SHARED_DATA "/meshes/fandisk.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh input = read_mesh(path);
  const RemeshResult result = remesh(input);
  const Angles angles = smallest_angles(result.mesh);
  EXPECT_GE(angles.mean, 49);
  EXPECT_GE(share_of_six(result.mesh), 0.80);
  EXPECT_LE(result.mesh.n_vertices(), 6060);
  const RemeshMeasures measures = remesh_measures(input, result.mesh);
  EXPECT_LE(degrees(measures.normal_error), 0.29);
  EXPECT_LE(degrees(remesh_measures(result.mesh, input).normal_error), 0.29);
  const double diameter = bounding_box_diagonal(input.positions);
  const TriangleTree before(input.positions, input.triangles),
      after(result.mesh.positions, result.mesh.triangles);
  const auto rms = [&](const TriangleMesh& from, const TriangleTree& to) {
    double squares = 0, area = 0;
    for (const AreaSample& sample :
         area_samples(from.positions, from.triangles, 1e-5 * diameter * diameter)) {
      squares += sample.area * to.closest(sample.point).squared_distance;
      area += sample.area;
    }
    return std::sqrt(squares / area) / diameter;
  };
  EXPECT_LE(rms(input, after), 6.7e-5);
  EXPECT_LE(rms(result.mesh, before), 6.7e-5);
  // H, table 2.3: ahead of the Laplacian flow in what the flow disturbs, curvature and distance.
  RemeshOptions options;
  options.method = RemeshMethod::LaplacianFlow;
  const RemeshMeasures flow = remesh_measures(input, remesh(input, options).mesh);
  EXPECT_LT(measures.curvature_change, flow.curvature_change);
  EXPECT_LT(measures.mean_distance, flow.mean_distance);
  EXPECT_LT(measures.edge_variance_change, flow.edge_variance_change);
}

// No face is thin unless kept edges force it: all three corners of such a face lie on them.
TEST(Remesh, HasThinFacesOnlyBetweenKeptEdges) {
  const std::string path = BATTEN_SHARED_DATA "/meshes/fandisk.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const RemeshResult result = remesh(read_mesh(path));
  HalfedgeMesh mesh(result.mesh.positions, result.mesh.triangles);
  FeatureOptions options;
  options.crease_angle = radians(30.0);
  options.corner_angle = radians(40.0);
  options.fade = 0.5;
  mark_features(mesh, options);
  std::vector<char> kept(mesh.vertex_capacity(), 0);
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h) && mesh.is_marked(h)) kept[mesh.from(h)] = kept[mesh.to(h)] = 1;
  for (Eigen::Index f = 0; f < result.mesh.n_triangles(); ++f) {
    TriangleMesh face;
    face.positions = result.mesh.positions;
    face.triangles = result.mesh.triangles.row(f);
    if (smallest_angles(face).least >= 20) continue;
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(kept[result.mesh.triangles(f, k)]) << f;
  }
}

// More vertices than one block of fit_normals() holds, so that there are blocks side by side and vertices
// between.
TEST(Remesh, GivesTheSameBitsOnAnyNumberOfThreads) {
  const TriangleMesh input = cube(45);
  ASSERT_GT(input.n_vertices(), 2 * 4096);
  RemeshOptions options;
  options.max_iterations = 2;
  const auto remeshed = [&](int threads) {
    const test::Threads here(threads);
    return remesh(input, options);
  };
  const RemeshResult one = remeshed(1);
  EXPECT_EQ(one.report.solves.unconverged, 0);
  EXPECT_GT(one.report.solves.residual, 0);
  EXPECT_LE(one.report.solves.residual, 1e-4);  // the tolerance of its solves
  for (const int threads : {2, 3}) {
    const RemeshResult other = remeshed(threads);
    EXPECT_EQ(other.mesh.positions, one.mesh.positions) << threads;
    EXPECT_EQ(other.mesh.triangles, one.mesh.triangles) << threads;
  }
}

// A mesh of 100,000 vertices takes some 6 s, one of 12,000 an eighth of that, in the same shares.
TEST(Remesh, ReportsOftenAndStopsWhereItIsTold) {
  const TriangleMesh input = cube(45);
  const test::Threads one_thread(1);  // all the work is on the thread whose time is measured
  const test::ReportGaps gaps([&](const Progress& progress) { remesh(input, {}, progress); });
  EXPECT_LT(gaps.largest_share(), 0.2) << "before " << gaps.before();
  EXPECT_GT(gaps.reports(), 100);
  for (const int stop_at : {1, 10, gaps.reports() / 2, gaps.reports()}) {
    int reports = 0;
    const Progress stop([&](std::string_view, double) { return ++reports < stop_at; });
    EXPECT_THROW(remesh(input, {}, stop), Cancelled) << stop_at;
  }
}

}  // namespace
}  // namespace batten
