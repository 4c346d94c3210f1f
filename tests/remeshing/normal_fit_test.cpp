#include "batten/remeshing/normal_fit.hpp"

#include "remeshing/surfaces.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/measures.hpp"

namespace batten {
namespace {

using fixtures::grid_of;
using fixtures::roof;

struct Fitted {
  TriangleMesh before, after;
  int moves = 0;
};

/// A grid of n × n squares on a shape, fitted to a finer one of m × m.
template <typename Surface>
Fitted fitted(int n, int m, const Surface& surface, const NormalFitOptions& options = {}) {
  const Shape coarse = fixtures::grid(n, n, false, false, surface);
  const Shape fine = fixtures::grid(m, m, false, false, surface);
  HalfedgeMesh mesh(coarse.positions, coarse.triangles);
  FeatureOptions feature_options;
  feature_options.crease_angle = kPi;
  feature_options.corner_angle = radians(40.0);
  const FeatureChains features = mark_features(mesh, feature_options);
  RemeshState state(mesh, features, Eigen::VectorXd::Constant(mesh.vertex_capacity(), 1.0 / n));
  Fitted result;
  result.before.positions = coarse.positions;
  result.before.triangles = coarse.triangles;
  result.moves = fit_normals(
      state, features, fine.positions, fine.triangles,
      sample_reference(coarse.positions, coarse.triangles, fine.positions, fine.triangles), options);
  EXPECT_EQ(state.mesh.breach(), "");
  const HalfedgeMesh::Compact compact = state.mesh.compacted();
  result.after.positions = compact.positions;
  result.after.triangles = compact.triangles;
  return result;
}

// Squares that straddle the ridge have wrong normals, 17° and more on two columns of nine. Vertices on the
// ridge make them right; only near the border, whose vertices may only slide between the border's own, is
// some left.
TEST(FitNormals, FindsARidge) {
  const Fitted fit = fitted(9, 40, roof);
  const TriangleMesh truth = grid_of(40, roof);
  const double before = remesh_measures(truth, fit.before).normal_error,
               after = remesh_measures(truth, fit.after).normal_error;
  EXPECT_GT(before, radians(0.7));
  EXPECT_LT(after, 0.65 * before);
  EXPECT_GT(fit.moves, 5);
}

// The shapes of triangles are kept: the smallest angle not below the bound, the mean where it was asked for.
TEST(FitNormals, KeepsTheAnglesThatWereAskedFor) {
  Random random(5);
  const auto rough = [](double u, double v) {
    return Eigen::Vector3d(u, v, 0.02 * std::sin(23 * u + 7 * v) * std::cos(19 * v));
  };
  NormalFitOptions options;
  options.mean_angle = radians(42.0);
  options.least_angle = radians(30.0);
  const Fitted fit = fitted(14, 60, rough, options);
  const MeshQuality quality = mesh_quality(fit.after.positions, fit.after.triangles);
  EXPECT_GE(quality.mean_min_angle, radians(41.0));
  EXPECT_GE(quality.min_angle, radians(30.0) - 1e-9);
  EXPECT_GT(fit.moves, 0);
}

// A flat surface has nothing to gain by normals, and no round means no move.
TEST(FitNormals, DoesNothingInNoRounds) {
  NormalFitOptions options;
  options.rounds = 0;
  const Fitted fit = fitted(8, 20, roof, options);
  EXPECT_EQ(fit.moves, 0);
  EXPECT_EQ(fit.after.positions, fit.before.positions);
}

}  // namespace
}  // namespace batten
