#include "batten/simulation/mesh_sections.hpp"

#include <cmath>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

MeshSectionOptions one_plane() {
  MeshSectionOptions options;
  options.planes = 1;
  return options;
}

// Three planes through the middle of a sphere are three great circles with six nodes. The mesh lies below the
// sphere by at most e²/8 = 2e-4 for edges of 0.04, and splines through its points follow as closely.
TEST(TraceMesh, SectionsOfASphereAreGreatCircles) {
  const TracedNetwork traced = trace_mesh(shape_mesh(AnalyticShape::Sphere, 0.01), one_plane());
  ASSERT_EQ(traced.curves.size(), 3U);
  ASSERT_EQ(traced.node_positions.rows(), 6);
  EXPECT_TRUE(traced.warnings.empty());
  for (const TracedCurve& curve : traced.curves) {
    EXPECT_TRUE(curve.closed);
    EXPECT_EQ(curve.node_ids.size(), 5U);
    EXPECT_NEAR(curve.path->length(), 2 * kPi, 2e-3);
    for (int i = 0; i < 100; ++i) {
      const CurvePoint p = curve.path->at(curve.path->length() * i / 100);
      EXPECT_NEAR(p.position.norm(), 1, 5e-4);
      EXPECT_GT(p.normal.dot(p.position), 0.999);
    }
  }
}

class TracedMesh : public testing::TestWithParam<std::string> {
 protected:
  static TracedNetwork trace() {
    const auto shape = parse_choice<AnalyticShape>(GetParam());
    TriangleMesh mesh = shape_mesh(shape, 0.02);
    // A position in which the planes are no symmetry planes of the shape.
    mesh.positions = mesh.positions * so3_exp({0.3, 0.5, -0.2}).transpose();
    return trace_mesh(mesh);
  }
};

// Arc length, tangent, frame and nodes fit each other, as on the shapes given by formulas.
TEST_P(TracedMesh, CurvesAreSmoothAndPassThroughTheirNodes) {
  const TracedNetwork traced = trace();
  for (const TracedCurve& curve : traced.curves) {
    const double length = curve.path->length();
    CurvePoint before = curve.path->at(0);
    constexpr int kPieces = 400;
    for (int i = 1; i <= kPieces; ++i) {
      const CurvePoint p = curve.path->at(length * i / kPieces);
      ASSERT_NEAR(p.tangent.norm(), 1, 1e-12);
      ASSERT_NEAR(p.normal.norm(), 1, 1e-12);
      ASSERT_LT(std::abs(p.tangent.dot(p.normal)), 1e-12);
      ASSERT_LE((p.position - before.position).norm(), length / kPieces * (1 + 1e-9));
      ASSERT_GT(p.normal.dot(before.normal), 0.8);
      before = p;
    }
    for (size_t j = 0; j < curve.node_ids.size(); ++j) {
      const CurvePoint p = curve.path->at(curve.node_distances[j]);
      EXPECT_LT((p.position - traced.node_positions.row(curve.node_ids[j]).transpose()).norm(), 1e-9);
      EXPECT_LT((p.normal - traced.node_normals.row(curve.node_ids[j]).transpose()).norm(), 1e-6);
    }
  }
}

TEST_P(TracedMesh, GivesAScanThatIsAcceptedAndIntegratesToTheNodes) {
  const TracedNetwork traced = trace();
  SimulateOptions options;
  options.step = 0.002;
  options.jitter = 0;
  options.dwell = 1;
  const SimulatedScan simulated = simulate_scan(traced, options);
  EXPECT_NO_THROW(check_scan(simulated.scan));
  for (const ScanCurve& curve : simulated.scan.curves)
    for (size_t j = 0; j + 1 < curve.node_ids.size(); ++j) {
      Vector3d x = traced.node_positions.row(curve.node_ids[j]);
      for (int i = curve.node_readings[j]; i < curve.node_readings[j + 1]; ++i)
        x += (curve.distances[i + 1] - curve.distances[i]) / 2 *
             (curve.tangents.row(i) + curve.tangents.row(i + 1)).transpose();
      EXPECT_LT((x - traced.node_positions.row(curve.node_ids[j + 1]).transpose()).norm(),
                1e-3 * traced.diameter);
    }
}

TEST_P(TracedMesh, BordersOfOpenMeshesAreBoundaryCurves) {
  int borders = 0;
  for (const TracedCurve& curve : trace().curves) borders += curve.boundary ? 1 : 0;
  const std::string& name = GetParam();
  EXPECT_EQ(borders, name == "cone" ? 2 : name == "waves" || name == "dish" || name == "saddle" ? 1 : 0);
}

INSTANTIATE_TEST_SUITE_P(TraceMesh, TracedMesh,
                         testing::Values("ellipsoid", "torus", "bumpycube", "waves", "cone"),
                         [](const auto& shape) { return shape.param; });

TEST(TraceMesh, LeavesOutWhatIsNotConnectedAndSaysSo) {
  TriangleMesh mesh = shape_mesh(AnalyticShape::Sphere, 0.05);
  const auto n = mesh.n_vertices();
  const auto m = mesh.n_triangles();
  TriangleMesh two = mesh;
  two.positions.conservativeResize(2 * n, 3);
  two.positions.bottomRows(n) = (0.5 * mesh.positions).rowwise() + Eigen::RowVector3d(9, 0.1, 0.1);
  two.triangles.conservativeResize(2 * m, 3);
  two.triangles.bottomRows(m) = mesh.triangles.array() + static_cast<int>(n);
  MeshSectionOptions options;
  options.planes = 9;
  const TracedNetwork traced = trace_mesh(two, options);
  EXPECT_FALSE(traced.warnings.empty());
  for (const TracedCurve& curve : traced.curves) EXPECT_LT(curve.path->at(0).position.x(), 2);
}

TEST(TraceMesh, RefusesWhatCannotBeScanned) {
  const TriangleMesh sphere = shape_mesh(AnalyticShape::Sphere, 0.1);
  EXPECT_THROW(trace_mesh(TriangleMesh()), InvalidInput);
  for (const auto& change : {std::pair("", 3), std::pair("x", 3), std::pair("xx", 3), std::pair("xw", 3),
                             std::pair("xy", 0), std::pair("xy", 101)}) {
    MeshSectionOptions options;
    options.axes = change.first;
    options.planes = change.second;
    EXPECT_THROW(trace_mesh(sphere, options), InvalidInput) << change.first << change.second;
  }
  TriangleMesh flipped = sphere;
  std::swap(flipped.triangles(7, 0), flipped.triangles(7, 1));
  EXPECT_THROW(trace_mesh(flipped), InvalidInput);
  TriangleMesh broken = sphere;
  broken.triangles(3, 1) = 99999;
  EXPECT_THROW(trace_mesh(broken), InvalidInput);
}

}  // namespace
}  // namespace batten
