#include "subdivision/cages.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/isolated_limit_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten::detail {
namespace {

// At one argument three times the weights are the uniform cubic basis; exchanging arguments changes nothing,
// and each enters linearly.
TEST(IsolatedLimit, PolarWeightsAreSymmetricAndLinearInEveryArgument) {
  const double t = 0.3, s = 1 - t;
  const Eigen::RowVector4d expected(s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                    (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6);
  EXPECT_LT((polar_weights({t, t, t}) - expected).norm(), 1e-15);
  EXPECT_LT((polar_weights({0.1, 0.7, -2}) - polar_weights({-2, 0.1, 0.7})).norm(), 1e-14);
  const Eigen::RowVector4d between =
      0.25 * polar_weights({0.1, 0.7, -2}) + 0.75 * polar_weights({0.1, 3, -2});
  EXPECT_LT((polar_weights({0.1, 0.25 * 0.7 + 0.75 * 3, -2}) - between).norm(), 1e-14);
}

/// A cage and its limit surface down to a depth of 2 + kSampledHalvings.
struct Limit {
  explicit Limit(const ControlCage& of)
      : cage(of),
        topology(cage_topology(cage.mesh)),
        sharpness(edge_sharpness(cage, topology)),
        cells(limit_cells(cage, topology, kLeastIsolation + kSampledHalvings, false)),
        isolated(cage, topology, cells, sharpness, kLeastIsolation) {}

  ControlCage cage;
  CageTopology topology;
  std::vector<double> sharpness;
  LimitCells cells;
  IsolatedLimit isolated;
};

// Every vertex of a cube has three edges, every vertex of a torus four.
TEST(IsolatedLimit, CornersAreIrregularWhereValencesAreNotFour) {
  const Limit cube(cages::cube()), torus(cages::torus(6, 5));
  for (int f = 0; f < 6; ++f)
    EXPECT_EQ(cube.isolated.irregular(f), (std::array<bool, 4>{true, true, true, true}));
  for (int f = 0; f < 30; ++f)
    EXPECT_EQ(torus.isolated.irregular(f), (std::array<bool, 4>{false, false, false, false}));
}

// The limit points of the vertices of the refined cage, which OpenSubdiv computes by other means, lie at
// halves of the parameters of their faces.
TEST(IsolatedLimit, IsTheLimitSurfaceOfTheRefinedCage) {
  const Limit cube(cages::cube());
  const SubdividedSurface fine = subdivide(cages::cube(), {.levels = 1, .limit = true});
  for (int f = 0; f < 6; ++f)
    for (int k = 0; k < 4; ++k) {
      const auto uv = on_patch_side(k, 0.5);
      const Eigen::RowVector3d point = cube.isolated.exact(f, uv[0], uv[1]);
      EXPECT_LT((fine.limit_positions.rowwise() - point).rowwise().norm().minCoeff(), 1e-9);
    }
}

// Side k of a face runs from corner k to the next; an edge has the same points seen from both its faces.
TEST(IsolatedLimit, BothSidesOfAnEdgeAreOneCurve) {
  const Limit cube(cages::cube());
  for (int e = 0; e < static_cast<int>(cube.topology.edges.size()); ++e) {
    const auto one = cube.isolated.side_of(e, 0), two = cube.isolated.side_of(e, 1);
    for (const double t : {0.3, 0.5, 0.6}) {
      const auto a = on_patch_side(one.side, one.forward ? t : 1 - t);
      const auto b = on_patch_side(two.side, two.forward ? t : 1 - t);
      EXPECT_LT(
          (cube.isolated.exact(one.face, a[0], a[1]) - cube.isolated.exact(two.face, b[0], b[1])).norm(),
          1e-12);
    }
    EXPECT_TRUE(cube.isolated.irregular_end(one, 0));
  }
}

TEST(IsolatedLimit, SharpEdgesTakeTheTangentPlaneAwayWhereTwoMeet) {
  const Limit cube(cages::cube_with_sharp_edges());
  for (int v = 0; v < 8; ++v) {
    const auto ends_here = [v](const SharpEdge& edge) { return edge.from == v || edge.to == v; };
    const auto n = std::count_if(cube.cage.sharp_edges.begin(), cube.cage.sharp_edges.end(), ends_here);
    EXPECT_EQ(cube.isolated.has_plane(v), n < 2) << v;
  }
}

}  // namespace
}  // namespace batten::detail
