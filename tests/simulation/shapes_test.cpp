#include "batten/simulation/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

AnalyticShape shape_of(const std::string& name) {
  return parse_choice<AnalyticShape>(name);
}

/// Segments between nodes, over all curves.
size_t count_segments(const TracedNetwork& traced) {
  size_t n = 0;
  for (const TracedCurve& curve : traced.curves) n += curve.node_ids.size() - 1;
  return n;
}

class EveryShape : public ::testing::TestWithParam<std::string> {};

// The counts follow from the planes (two planes and a closed convex surface meet in two points); those of the
// exact networks in the public data agree: one curve per segment there.
TEST(Shapes, CurvesNodesAndSegmentsAreThoseOfTheDefinition) {
  const std::map<std::string, std::array<size_t, 3>> expected = {
      {"sphere", {3, 6, 12}},  {"sphere6", {6, 24, 48}},    {"ellipsoid", {5, 14, 30}},
      {"torus", {12, 36, 72}}, {"bumpycube", {9, 54, 108}}, {"saddle", {8, 16, 24}},
      {"waves", {10, 25, 40}}, {"dish", {5, 12, 20}},       {"cone", {5, 6, 9}}};
  ASSERT_EQ(expected.size(), choice_words<AnalyticShape>().size());
  for (const auto& [name, counts] : expected) {
    const TracedNetwork traced = trace_shape(shape_of(name));
    EXPECT_EQ(traced.curves.size(), counts[0]) << name;
    EXPECT_EQ(traced.node_positions.rows(), static_cast<Eigen::Index>(counts[1])) << name;
    EXPECT_EQ(count_segments(traced), counts[2]) << name;
  }
}

TEST(Shapes, AliasesNameTheSameShape) {
  EXPECT_EQ(shape_of("sphere3"), AnalyticShape::Sphere);
  EXPECT_EQ(shape_of("ellipsoid5"), AnalyticShape::Ellipsoid);
  EXPECT_EQ(shape_of("bumpy-cube"), AnalyticShape::BumpyCube);
  EXPECT_THROW(shape_of("teapot"), InvalidInput);
}

// Closed forms: circles, the elliptic integral, straight generators, and on the unit square the parabola of
// the saddle's border, z = 0.35 (1 − y²), whose length is sqrt(1 + k²) + asinh(k)/k with k = 0.7.
TEST(Shapes, LengthsOfCurvesAreExact) {
  for (const TracedCurve& curve : trace_shape(AnalyticShape::Sphere).curves)
    EXPECT_NEAR(curve.path->length(), 2 * kPi, 1e-11);
  for (const TracedCurve& curve : trace_shape(AnalyticShape::Sphere6).curves)
    EXPECT_NEAR(curve.path->length(), 2 * kPi * std::sqrt(1 - 0.45 * 0.45), 1e-11);
  const TracedNetwork torus = trace_shape(AnalyticShape::Torus);
  EXPECT_NEAR(torus.curves[0].path->length(), 12 * kPi, 1e-10);
  EXPECT_NEAR(torus.curves[1].path->length(), 4 * kPi, 1e-10);
  EXPECT_NEAR(torus.curves[2].path->length(), 2 * kPi * 5.6, 1e-10);
  EXPECT_NEAR(torus.curves[11].path->length(), 4 * kPi, 1e-10);
  const TracedNetwork cone = trace_shape(AnalyticShape::Cone);
  EXPECT_NEAR(cone.curves[0].path->length(), 2 * kPi * 0.475, 1e-12);
  EXPECT_NEAR(cone.curves[2].path->length(), 1.6 * std::sqrt(1 + 0.0625), 1e-12);
  const TracedNetwork ellipsoid = trace_shape(AnalyticShape::Ellipsoid);
  EXPECT_NEAR(ellipsoid.curves[3].path->length(), 6 * std::comp_ellint_2(std::sqrt(1 - 1 / 2.25)), 1e-10);
  const double k = 0.7;
  EXPECT_NEAR(trace_shape(AnalyticShape::Saddle).curves[1].path->length(),
              std::sqrt(1 + k * k) + std::asinh(k) / k, 1e-11);
}

TEST(Shapes, DiametersAreThoseOfTheBoundingBox) {
  EXPECT_NEAR(trace_shape(AnalyticShape::Sphere).diameter, 2 * std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(trace_shape(AnalyticShape::Torus).diameter, std::sqrt(144.0 + 144 + 16), 1e-12);
  EXPECT_NEAR(trace_shape(AnalyticShape::Cone).diameter, std::sqrt(2 * 0.95 * 0.95 + 1.6 * 1.6), 1e-12);
  EXPECT_NEAR(trace_shape(AnalyticShape::Saddle).diameter, std::sqrt(8 + 0.49), 1e-12);
}

TEST_P(EveryShape, PointsLieOnTheSurfaceWithTheirFrames) {
  const AnalyticShape shape = shape_of(GetParam());
  const TracedNetwork traced = trace_shape(shape);
  const ImplicitFunction surface = shape_function(shape);
  Random random(1);
  for (const TracedCurve& curve : traced.curves) {
    const double length = curve.path->length();
    for (int i = 0; i < 30; ++i) {
      const double s = random.uniform(0, length);
      const CurvePoint p = curve.path->at(s);
      Vector3d gradient;
      EXPECT_LT(std::abs(surface(p.position, gradient)), 1e-12 * traced.diameter);
      EXPECT_LT((p.normal - gradient.normalized()).norm(), 1e-12);
      EXPECT_NEAR(p.tangent.norm(), 1, 1e-14);
      EXPECT_LT(std::abs(p.tangent.dot(p.normal)), 1e-13);
      // Arc length and tangent are derivative and integral of each other: the chord over ±e is 2 e t + O(e³).
      const double e = 1e-4 * length;
      if (s < e || s > length - e) continue;
      const Vector3d chord = curve.path->at(s + e).position - curve.path->at(s - e).position;
      EXPECT_LT((chord / (2 * e) - p.tangent).norm(), 1e-4);
    }
  }
}

TEST_P(EveryShape, CurvesPassThroughTheirNodes) {
  const AnalyticShape shape = shape_of(GetParam());
  const TracedNetwork traced = trace_shape(shape);
  const ImplicitFunction surface = shape_function(shape);
  std::vector<std::set<const TracedCurve*>> curves_at(static_cast<size_t>(traced.node_positions.rows()));
  for (const TracedCurve& curve : traced.curves) {
    ASSERT_EQ(curve.node_ids.size(), curve.node_distances.size());
    EXPECT_TRUE(std::is_sorted(curve.node_distances.begin(), curve.node_distances.end()));
    if (curve.closed) {
      EXPECT_EQ(curve.node_ids.front(), curve.node_ids.back());
      EXPECT_EQ(curve.node_distances.front(), 0);
      EXPECT_EQ(curve.node_distances.back(), curve.path->length());
    }
    for (size_t j = 0; j < curve.node_ids.size(); ++j) {
      const CurvePoint p = curve.path->at(curve.node_distances[j]);
      EXPECT_LT((p.position - traced.node_positions.row(curve.node_ids[j]).transpose()).norm(),
                1e-11 * traced.diameter);
      EXPECT_LT((p.normal - traced.node_normals.row(curve.node_ids[j]).transpose()).norm(), 1e-10);
      curves_at[static_cast<size_t>(curve.node_ids[j])].insert(&curve);
    }
  }
  for (const auto& curves : curves_at) EXPECT_GE(curves.size(), 2U) << "a node joins two curves";
}

// Seen from outside the surface lies to the left of its border: N × t points into it.
TEST_P(EveryShape, BordersRunWithTheSurfaceOnTheirLeft) {
  const AnalyticShape shape = shape_of(GetParam());
  const TracedNetwork traced = trace_shape(shape);
  for (const TracedCurve& curve : traced.curves) {
    if (!curve.boundary) continue;
    const CurvePoint p = curve.path->at(0.3 * curve.path->length());
    const Vector3d inward = p.normal.cross(p.tangent);
    if (shape == AnalyticShape::Cone)
      EXPECT_GT(inward.z() * (0.9 - p.position.z()), 0);
    else
      EXPECT_LT(inward.head<2>().dot(p.position.head<2>()), 0);
  }
}

TEST_P(EveryShape, MeshesAreOrientedManifoldsOnTheSurface) {
  const AnalyticShape shape = shape_of(GetParam());
  const TriangleMesh mesh = shape_mesh(shape, 0.05);
  const ImplicitFunction surface = shape_function(shape);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    Vector3d gradient;
    ASSERT_LT(std::abs(surface(mesh.positions.row(v), gradient)), 1e-12);
    ASSERT_LT((mesh.normals.row(v).transpose() - gradient.normalized()).norm(), 1e-12);
  }
  std::map<std::pair<int, int>, int> half_edges;
  double longest = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::RowVector3i t = mesh.triangles.row(f);
    const Vector3d a = mesh.positions.row(t[0]);
    const Vector3d b = mesh.positions.row(t[1]);
    const Vector3d c = mesh.positions.row(t[2]);
    const Vector3d face_normal = (b - a).cross(c - a);
    ASSERT_GT(face_normal.dot(mesh.normals.row(t[0]).transpose()), 0)
        << "counter-clockwise seen from outside";
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(++half_edges[std::make_pair(t[k], t[(k + 1) % 3])], 1) << "no half-edge twice";
      longest = std::max(longest, (mesh.positions.row(t[k]) - mesh.positions.row(t[(k + 1) % 3])).norm());
    }
  }
  EXPECT_LT(longest, 0.1 * trace_shape(shape).diameter);
  long border = 0;
  for (const auto& [edge, count] : half_edges)
    border += half_edges.count({edge.second, edge.first}) == 0 ? 1 : 0;
  const long edges = (static_cast<long>(half_edges.size()) + border) / 2;
  const long euler = static_cast<long>(mesh.n_vertices()) - edges + static_cast<long>(mesh.n_triangles());
  // Sphere 2, torus and cylinder 0, disc 1.
  const bool disc =
      shape == AnalyticShape::Saddle || shape == AnalyticShape::Waves || shape == AnalyticShape::Dish;
  const bool ring = shape == AnalyticShape::Torus || shape == AnalyticShape::Cone;
  EXPECT_EQ(euler, disc ? 1 : ring ? 0 : 2);
  EXPECT_EQ(border > 0, disc || shape == AnalyticShape::Cone);
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape, ::testing::ValuesIn(choice_words<AnalyticShape>()),
                         [](const auto& shape) { return shape.param; });

TEST(Shapes, MeshesRefuseEdgesOutOfRange) {
  EXPECT_THROW(shape_mesh(AnalyticShape::Sphere, 0), InvalidInput);
  EXPECT_THROW(shape_mesh(AnalyticShape::Sphere, 0.3), InvalidInput);
  EXPECT_THROW(shape_mesh(AnalyticShape::Sphere, NAN), InvalidInput);
  EXPECT_THROW(shape_mesh(AnalyticShape::Torus, 1e-6), InvalidInput);  // 10 billion triangles
}

}  // namespace
}  // namespace batten
