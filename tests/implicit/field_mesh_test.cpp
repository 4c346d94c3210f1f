#include "batten/implicit/field_mesh.hpp"

#include "implicit/strokes.hpp"
#include "sanitizers.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {
namespace {

TEST(FieldMesh, IsClosedWithVerticesAlongTheStrokes) {
  const StrokeSamples samples = stroke_samples(test::sphere_strokes(3, 0.15, 0), 0.02);
  StrokeFieldOptions options;
  options.most_sites = test::repeated(200, 60);
  const StrokeField field = stroke_field(samples, options).field;
  LevelSetOptions level;
  level.edge_length = test::repeated(0.06, 0.15);
  const double edge = level.edge_length;
  const TriangleMesh mesh = field_mesh(field, samples, level);
  EXPECT_TRUE(mesh_topology(mesh.triangles, mesh.n_vertices()).is_watertight());
  const std::vector<ClosestPoint> closest =
      TriangleTree(mesh.positions, mesh.triangles).closest(samples.positions);
  int at_vertices = 0;
  for (Eigen::Index i = 0; i < samples.positions.rows(); ++i) {
    EXPECT_LT(closest[static_cast<std::size_t>(i)].squared_distance, 0.01 * edge * edge);
    at_vertices += (mesh.positions.rowwise() - samples.positions.row(i)).rowwise().norm().minCoeff() < 1e-12;
  }
  // One for every 0.8 edges of the strokes, and those that the spread leaves out near crossings.
  EXPECT_GT(at_vertices, samples.positions.rows() * 0.02 / edge * 0.7);
  level.edge_length = 0;
  EXPECT_THROW(field_mesh(field, samples, level), InvalidInput);
  level.edge_length = 1e-5;
  EXPECT_THROW(field_mesh(field, samples, level), InvalidInput);
}

}  // namespace
}  // namespace batten
