#include "batten/remeshing/connectivity.hpp"

#include "remeshing/surfaces.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using fixtures::cube;

/// The unit cube with its edges marked, and one wanted length everywhere.
RemeshState marked_cube(int n, double size) {
  const TriangleMesh input = cube(n);
  HalfedgeMesh mesh(input.positions, input.triangles);
  FeatureOptions options;
  options.crease_angle = radians(30.0);
  options.corner_angle = radians(40.0);
  static FeatureChains features;  // the state refers to it
  features = mark_features(mesh, options);
  return {mesh, features, Eigen::VectorXd::Constant(mesh.vertex_capacity(), size)};
}

template <typename Visit>
void for_each_edge(const RemeshState& state, const Visit& visit) {
  for (int h = 0; h < state.mesh.halfedge_capacity(); ++h)
    if (state.mesh.has_halfedge(h) && state.mesh.is_representative(h)) visit(h);
}

double longest(const RemeshState& state) {
  double found = 0;
  for_each_edge(state,
                [&](int h) { found = std::max(found, state.edge_length(h) / state.wanted_length(h)); });
  return found;
}

/// The mesh is sound, all of it lies on the cube, and the marked edges are the twelve of the cube.
void expect_cube(const RemeshState& state) {
  EXPECT_EQ(state.mesh.breach(), "");
  double area = 0, marked = 0;
  for (int f = 0; f < state.mesh.face_capacity(); ++f)
    if (state.mesh.has_face(f)) area += 0.5 * state.mesh.area_normal(f).norm();
  for_each_edge(state, [&](int h) { marked += state.mesh.is_marked(h) ? state.edge_length(h) : 0; });
  EXPECT_NEAR(area, 6, 1e-9);
  EXPECT_NEAR(marked, 12, 1e-9);
}

double valence_excess(const RemeshState& state) {
  double sum = 0;
  for (int v = 0; v < state.mesh.vertex_capacity(); ++v)
    if (state.mesh.has_vertex(v) && state.is_free(v)) sum += std::pow(state.mesh.valence(v) - 6, 2);
  return sum;
}

double least_angle(const RemeshState& state) {
  double least = kPi;
  for (int h = 0; h < state.mesh.halfedge_capacity(); ++h) {
    if (!state.mesh.has_halfedge(h)) continue;
    const Eigen::Vector3d p = state.mesh.position(state.mesh.from(h)),
                          a = state.mesh.position(state.mesh.to(h)) - p,
                          b = state.mesh.position(state.mesh.tip(h)) - p;
    least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return least;
}

TEST(RemeshState, SplitsEveryEdgeThatIsTooLong) {
  RemeshState state = marked_cube(4, 0.1);
  ASSERT_GT(longest(state), 3);
  // Halves may be too long again: every pass leaves less to do.
  double before = longest(state);
  while (state.split_long_edges(4.0 / 3) > 0) {
    EXPECT_LT(longest(state), before);
    before = longest(state);
  }
  EXPECT_LE(longest(state), 4.0 / 3);
  expect_cube(state);
  // Vertices on the edges of the cube know it, and where.
  int on_chains = 0;
  for (int v = 0; v < state.mesh.vertex_capacity(); ++v) {
    if (!state.mesh.has_vertex(v) || state.chain[v] < 0) continue;
    ++on_chains;
    const Eigen::Vector3d p = state.mesh.position(v);
    int on_sides = 0;
    for (int k = 0; k < 3; ++k) on_sides += std::min(p[k], 1 - p[k]) < 1e-12 ? 1 : 0;
    EXPECT_GE(on_sides, 2) << v;
  }
  EXPECT_GE(on_chains, 12 * 6);
}

// One call leaves no edge that is too long, of a cube in twelve triangles; lines alone leave those across the
// faces.
TEST(RemeshState, RefinesUntilNoEdgeIsTooLong) {
  RemeshState state = marked_cube(1, 0.05);
  EXPECT_EQ(state.refine(4.0 / 3, true, radians(0.1)), 12 * 15);  // halves, quarters, 1/8, 1/16 < 4/3 · 0.05
  EXPECT_GT(longest(state), 20);
  expect_cube(state);
  state.flip_flat_pieces(radians(0.1));
  state.refine(4.0 / 3, false, radians(0.1));
  EXPECT_LE(longest(state), 4.0 / 3);
  expect_cube(state);
}

// Afterwards angles opposite to an edge in a plane sum to at most π (the definition of Delaunay), and edges
// of the cube are where they were.
TEST(RemeshState, FlipsFlatPiecesToDelaunay) {
  RemeshState state = marked_cube(1, 0.1);
  state.refine(4.0 / 3, true, radians(0.1));
  const auto opposite_angles = [&] {
    double most = 0;
    for_each_edge(state, [&](int h) {
      if (state.mesh.is_marked(h)) return;
      double sum = 0;
      for (const int g : {h, state.mesh.opposite(h)}) {
        const Eigen::Vector3d tip = state.mesh.position(state.mesh.tip(g)),
                              a = state.mesh.position(state.mesh.from(g)) - tip,
                              b = state.mesh.position(state.mesh.to(g)) - tip;
        sum += std::atan2(a.cross(b).norm(), a.dot(b));
      }
      most = std::max(most, sum);
    });
    return most;
  };
  ASSERT_GT(opposite_angles(), kPi + 0.1);
  EXPECT_GT(state.flip_flat_pieces(radians(0.1)), 0);
  EXPECT_LE(opposite_angles(), kPi + 2e-6);
  EXPECT_EQ(state.flip_flat_pieces(radians(0.1)), 0);
  expect_cube(state);
}

TEST(RemeshState, CollapsesShortEdgesAndKeepsTheFeatures) {
  RemeshState state = marked_cube(12, 0.25);
  const int before = state.mesh.n_vertices();
  EXPECT_GT(state.collapse_short_edges(0.8, 4.0 / 3), 0);
  EXPECT_LT(state.mesh.n_vertices(), before / 2);
  EXPECT_LE(longest(state), 4.0 / 3 + 1e-9);
  expect_cube(state);
  EXPECT_EQ(std::count_if(state.corner.begin(), state.corner.end(), [](int c) { return c >= 0; }), 8);
}

TEST(RemeshState, FlipsTowardsSixEdgesAndTowardsLargerAngles) {
  RemeshState state = marked_cube(6, 1.0 / 6);
  // Disturbed first: random turns of edges within the flat faces.
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const int h = static_cast<int>(random.below(state.mesh.halfedge_capacity()));
    if (!state.mesh.has_halfedge(h) || !state.mesh.can_flip(h)) continue;
    state.mesh.flip(h);
    for (const int g : {h, state.mesh.opposite(h)})  // back where a face would have no area or turn over
      if (state.mesh.area_normal(state.mesh.face(g)).norm() < 1e-3) {
        state.mesh.flip(h);
        break;
      }
  }
  ASSERT_EQ(state.mesh.breach(), "");
  const double excess = valence_excess(state);
  EXPECT_GT(state.flip_for_valence(radians(20.0), radians(1.0)), 0);
  EXPECT_LT(valence_excess(state), 0.7 * excess);
  const double angle = least_angle(state);
  while (state.flip_for_angles(radians(20.0)) > 0) {
  }
  EXPECT_GE(least_angle(state), angle);
  EXPECT_EQ(state.mesh.breach(), "");
}

// Along a chain of even wanted lengths the vertices end up evenly spaced.
TEST(RemeshState, RelaxesChainsToEvenSpacing) {
  RemeshState state = marked_cube(5, 0.2);
  Random random(8);
  for (int v = 0; v < state.mesh.vertex_capacity(); ++v)
    if (state.mesh.has_vertex(v) && state.chain[v] >= 0) state.place[v] += 0.08 * (random.uniform() - 0.5);
  for (int round = 0; round < 200; ++round) state.relax_chains(0.5);
  for_each_edge(state, [&](int h) {
    if (state.mesh.is_marked(h)) {
      EXPECT_NEAR(state.edge_length(h), 0.2, 1e-9);
    }
  });
  expect_cube(state);
}

}  // namespace
}  // namespace batten
