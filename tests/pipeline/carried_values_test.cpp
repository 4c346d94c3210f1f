#include "batten/pipeline/carried_values.hpp"

#include "mesh/shapes.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/pipeline/remeshed_mesh.hpp"
#include "batten/pipeline/simplified_mesh.hpp"

namespace batten {
namespace {

/// A flat square of n × n cells with an amount that is linear, a label that jumps at x = 1/2, and colours.
TriangleMesh valued_square(int n) {
  TriangleMesh mesh = fixtures::as_mesh(
      fixtures::grid(n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }));
  const Eigen::ArrayXd x = mesh.positions.col(0), y = mesh.positions.col(1);
  mesh.vertex_values["heat"] = 3 * x - 2 * y + 0.125;
  mesh.vertex_values["part"] = (x < 0.5).select(Eigen::ArrayXd::Constant(x.size(), 7), 4000);
  mesh.vertex_values["red"] = (255 * x).round();
  mesh.vertex_values["green"] = (255 * y).round();
  mesh.vertex_values["blue"] = Eigen::VectorXd::Zero(x.size());
  mesh.normals = Points::Zero(mesh.n_vertices(), 3);
  mesh.normals.col(2).setOnes();
  return mesh;
}

/// Linear amounts come out exactly wherever the new vertices lie; labels are one of the two, on their side;
/// colours are whole and as near as the steps between two vertices allow.
void expect_carried(const TriangleMesh& mesh, double cell) {
  ASSERT_GT(mesh.n_vertices(), 3);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    const double x = mesh.positions(v, 0), y = mesh.positions(v, 1);
    EXPECT_NEAR(mesh.vertex_values.at("heat")(v), 3 * x - 2 * y + 0.125, 1e-6);
    const double part = mesh.vertex_values.at("part")(v);
    EXPECT_TRUE(part == 7 || part == 4000) << part;
    if (std::abs(x - 0.5) > cell) {
      EXPECT_EQ(part, x < 0.5 ? 7 : 4000);
    }
    const double red = mesh.vertex_values.at("red")(v);
    EXPECT_EQ(red, std::round(red));
    EXPECT_NEAR(red, 255 * x, 1.01);
    EXPECT_EQ(mesh.vertex_values.at("blue")(v), 0);
    EXPECT_NEAR(mesh.normals(v, 2), 1, 1e-9);
  }
}

TEST(ValueKind, IsToldByNameAndNumbers) {
  EXPECT_EQ(value_kind("red", Eigen::Vector2d(0, 255)), ValueKind::Channel);
  EXPECT_EQ(value_kind("red", Eigen::Vector2d(0, 256)), ValueKind::Label);
  EXPECT_EQ(value_kind("red", Eigen::Vector2d(0, 0.5)), ValueKind::Amount);
  EXPECT_EQ(value_kind("part", Eigen::Vector2d(0, 255)), ValueKind::Label);
  EXPECT_EQ(value_kind("part", Eigen::Vector2d(1, std::numeric_limits<double>::quiet_NaN())),
            ValueKind::Amount);
}

TEST(CarryValues, GivesAMeshItsOwnValuesBack) {
  const TriangleMesh from = valued_square(9);
  TriangleMesh to;
  to.positions = from.positions;
  to.triangles = from.triangles;
  to.vertex_values["heat"] = Eigen::VectorXd::Zero(to.n_vertices());  // stays
  carry_values(from, to);
  for (const char* name : {"part", "red", "green", "blue"})
    EXPECT_EQ(to.vertex_values.at(name), from.vertex_values.at(name)) << name;
  EXPECT_EQ(to.vertex_values.at("heat").norm(), 0);
  EXPECT_EQ(to.normals, from.normals);
}

TEST(CarryValues, SimplifyAndRemeshCarryThem) {
  const TriangleMesh square = valued_square(20);
  SimplifiedMeshOptions fewer;
  fewer.simplify.remove = 0.7;
  fewer.simplify.hold_border = true;
  const SimplifiedMesh simplified = simplified_mesh(square, fewer);
  expect_carried(simplified.simplified.mesh, 0.05);
  EXPECT_TRUE(simplified.warnings.empty());
  RemeshedMeshOptions other;
  other.remesh.edge_length = 0.07;
  const RemeshedMesh remeshed = remeshed_mesh(square, other);
  expect_carried(remeshed.mesh, 0.05);
  EXPECT_TRUE(remeshed.warnings.empty());
}

}  // namespace
}  // namespace batten
