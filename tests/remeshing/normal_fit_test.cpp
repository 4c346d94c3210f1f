#include "batten/remeshing/normal_fit.hpp"

#include "mesh/shapes.hpp"

#include <numeric>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/measures.hpp"

namespace batten {
namespace {

/// A roof: two planes that meet in a ridge along y at x = 0.46.
Eigen::Vector3d roof(double u, double v) {
  return {u, v, 0.15 * std::min(u / 0.46, (1 - u) / 0.54)};
}

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

TriangleMesh grid_of(int m, Eigen::Vector3d (*surface)(double, double)) {
  const Shape shape = fixtures::grid(m, m, false, false, surface);
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
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

// The pieces of every triangle add up to it, have its normal and lie in it; none is larger than asked for.
TEST(AreaSamples, ShareOutTheArea) {
  const TriangleMesh mesh = grid_of(3, roof);
  const std::vector<AreaSample> samples = area_samples(mesh.positions, mesh.triangles, 0.004);
  std::vector<double> area(mesh.n_triangles(), 0.0);
  std::vector<Eigen::Vector3d> centre(mesh.n_triangles(), Eigen::Vector3d::Zero());
  for (const AreaSample& sample : samples) {
    EXPECT_LE(sample.area, 0.004);
    area[sample.triangle] += sample.area;
    centre[sample.triangle] += sample.area * sample.point;
  }
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Eigen::Vector3d a = mesh.positions.row(mesh.triangles(f, 0)),
                          b = mesh.positions.row(mesh.triangles(f, 1)),
                          c = mesh.positions.row(mesh.triangles(f, 2));
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    EXPECT_NEAR(area[f], 0.5 * cross.norm(), 1e-14);
    // Pieces alike, spread evenly: their common centre is the triangle's.
    EXPECT_LT((centre[f] / area[f] - (a + b + c) / 3).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace batten
