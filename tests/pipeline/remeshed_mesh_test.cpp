#include "batten/pipeline/remeshed_mesh.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

TriangleMesh torus() {
  return fixtures::as_mesh(fixtures::grid(24, 12, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.7 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b));
  }));
}

TEST(RemeshedMesh, IsThatOfTheRoomBelowWithItsMeasures) {
  const TriangleMesh mesh = torus();
  RemeshedMeshOptions options;
  options.remesh.max_iterations = 2;
  const RemeshedMesh remeshed = remeshed_mesh(mesh, options);
  const RemeshResult below = remesh(mesh, options.remesh);
  EXPECT_EQ(remeshed.mesh.positions, below.mesh.positions);
  EXPECT_EQ(remeshed.mesh.triangles, below.mesh.triangles);
  EXPECT_EQ(remeshed.report.iterations, below.report.iterations);
  EXPECT_EQ(remeshed.measures.normal_error,
            remesh_measures(mesh, below.mesh, options.remesh.keep_edges).normal_error);
  EXPECT_EQ(remeshed.quality.min_angle, mesh_quality(below.mesh.positions, below.mesh.triangles).min_angle);
  EXPECT_TRUE(remeshed.warnings.empty());
}

TEST(RemeshedMesh, RelativeEdgeLengthsAreOfTheDiameter) {
  const TriangleMesh mesh = torus();
  RemeshedMeshOptions relative, absolute;
  relative.remesh.max_iterations = absolute.remesh.max_iterations = 1;
  relative.remesh.adaptivity = absolute.remesh.adaptivity = 0;
  relative.edge_length = Length{0.04, Length::Kind::Relative};
  absolute.edge_length = Length{0.04 * bounding_box_diagonal(mesh.positions), Length::Kind::Plain};
  const RemeshedMesh by_part = remeshed_mesh(mesh, relative);
  EXPECT_EQ(by_part.mesh.positions, remeshed_mesh(mesh, absolute).mesh.positions);
  EXPECT_NEAR(by_part.quality.mean_edge, absolute.edge_length->value, 0.1 * absolute.edge_length->value);
}

TEST(RemeshedMesh, BadOptionsAreNamedAndWorkIsCancelled) {
  const auto names = [](const RemeshedMeshOptions& options, const std::string& field) {
    EXPECT_NE(options.problem().value_or("").find(field), std::string::npos)
        << options.problem().value_or("none");
    EXPECT_THROW(remeshed_mesh(torus(), options), InvalidInput);
  };
  RemeshedMeshOptions options;
  EXPECT_FALSE(options.problem().has_value());
  options.edge_length = Length{0, Length::Kind::Plain};
  names(options, "edge_length");
  options.edge_length = Length{1, Length::Kind::Plain};
  options.remesh.n_vertices = 100;
  names(options, "not both");
  options = {};
  options.remesh.adaptivity = 2;
  names(options, "adaptivity");
  options = {};
  options.remesh.sizes = Eigen::VectorXd::Zero(torus().n_vertices());
  names(options, "size at vertex 0");
  EXPECT_THROW(remeshed_mesh({}), InvalidInput);
  EXPECT_THROW(remeshed_mesh(torus(), {}, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

}  // namespace
}  // namespace batten
