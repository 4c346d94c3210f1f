#include "batten/mesh/shape.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

// A triangle and a small far one: the share of samples is the share of the area, its centroid the mean.
TEST(SampleUniformly, IsUniformByArea) {
  Shape shape;
  shape.positions.resize(6, 3);
  shape.positions << 0, 0, 0, 3, 0, 0, 0, 3, 0, 100, 0, 0, 101, 0, 0, 100, 1, 0;
  shape.triangles.resize(2, 3);
  shape.triangles << 0, 1, 2, 3, 4, 5;
  Random random(3);
  const int n = 100000;
  const Points samples = sample_uniformly(shape, n, random);
  double in_first = 0, x = 0, y = 0;
  for (int i = 0; i < n; ++i) {
    if (samples(i, 0) > 50) continue;
    ++in_first;
    x += samples(i, 0);
    y += samples(i, 1);
  }
  EXPECT_NEAR(in_first / n, 0.9, 4 * std::sqrt(0.09 / n));
  EXPECT_NEAR(x / in_first, 1, 4 * std::sqrt(0.5 / in_first));
  EXPECT_NEAR(y / in_first, 1, 4 * std::sqrt(0.5 / in_first));
}

TEST(SampleUniformly, IsUniformByLengthOnCurves) {
  Shape shape;
  shape.positions.resize(3, 3);
  shape.positions << 0, 0, 0, 1, 0, 0, 1, 3, 0;
  shape.segments.resize(2, 2);
  shape.segments << 0, 1, 1, 2;
  Random random(3);
  const int n = 100000;
  const Points samples = sample_uniformly(shape, n, random);
  EXPECT_NEAR((samples.col(1).array() > 0).cast<double>().mean(), 0.75, 4 * std::sqrt(0.1875 / n));
}

TEST(Shape, UsesOnlyVerticesOfElements) {
  Shape shape = fixtures::sphere(2);
  shape.positions.conservativeResize(shape.positions.rows() + 1, 3);
  shape.positions.bottomRows(1).setConstant(100);
  EXPECT_NEAR(diameter(shape), std::sqrt(12.0), 1e-14);
  EXPECT_EQ(used_vertices(shape).size(), static_cast<std::size_t>(shape.positions.rows() - 1));
}

TEST(Shape, RefusesWhatHasNoExtent) {
  Shape nothing;
  EXPECT_THROW(ShapeTree{nothing}, InvalidInput);
  Shape point;
  point.positions = Points::Zero(3, 3);
  point.triangles.resize(1, 3);
  point.triangles << 0, 1, 2;
  Random random(1);
  EXPECT_THROW(sample_uniformly(point, 10, random), InvalidInput);
}

}  // namespace
}  // namespace batten
