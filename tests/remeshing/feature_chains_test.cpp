#include "batten/remeshing/feature_chains.hpp"

#include "remeshing/surfaces.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

using fixtures::cube;

// The features of a cube: twelve chains between eight corners, of length 1; a closed circle gets two corners.
TEST(FeatureChains, FindsTheEdgesOfACube) {
  const TriangleMesh input = cube(5);
  HalfedgeMesh mesh(input.positions, input.triangles);
  FeatureOptions options;
  options.crease_angle = radians(30.0);
  options.corner_angle = radians(40.0);
  const FeatureChains features = mark_features(mesh, options);
  ASSERT_EQ(features.chains.size(), 12u);
  for (const FeatureChain& chain : features.chains) {
    EXPECT_EQ(chain.vertices.size(), 6u);
    EXPECT_NEAR(chain.length(), 1, 1e-14);
    EXPECT_LT((chain.at(0.3) - (0.7 * chain.points.front() + 0.3 * chain.points.back())).norm(), 1e-14);
  }
  EXPECT_EQ(std::count(features.is_corner.begin(), features.is_corner.end(), 1), 8);
}

// A crease of a strip that fades from 60° to nothing: it is kept while it is above 30° and then followed to
// half of that, where an even bend beside it would be as sharp.
TEST(FeatureChains, FollowsACreaseThatFades) {
  const int n = 24;
  TriangleMesh strip;
  strip.positions.resize(3 * (n + 1), 3);
  strip.triangles.resize(4 * n, 3);
  for (int i = 0; i <= n; ++i) {
    const double half = radians(60.0) / 2 * (1 - i / double(n));
    for (int j = 0; j < 3; ++j)
      strip.positions.row(3 * i + j) << 0.2 * i, (j - 1) * std::cos(half), std::abs(j - 1) * std::sin(half);
    if (i == n) continue;
    for (int j = 0; j < 2; ++j) {
      const int a = 3 * i + j;
      strip.triangles.row(4 * i + 2 * j) << a, a + 3, a + 4;
      strip.triangles.row(4 * i + 2 * j + 1) << a, a + 4, a + 1;
    }
  }
  const auto crease_edges = [&](double fade) {
    HalfedgeMesh mesh(strip.positions, strip.triangles);
    FeatureOptions options;
    options.crease_angle = radians(30.0);
    options.corner_angle = radians(40.0);
    options.fade = fade;
    mark_features(mesh, options);
    int count = 0;
    for (int h = 0; h < mesh.halfedge_capacity(); ++h)
      count += mesh.is_representative(h) && mesh.is_marked(h) && !mesh.is_border_edge(h) ? 1 : 0;
    return count;
  };
  EXPECT_NEAR(crease_edges(1), n / 2, 1);
  EXPECT_NEAR(crease_edges(0.5), 3 * n / 4, 1);
}

}  // namespace
}  // namespace batten
