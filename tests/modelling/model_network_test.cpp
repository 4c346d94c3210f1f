#include "batten/modelling/model_network.hpp"

#include "modelling/sharp_cube.hpp"

#include <cmath>
#include <iostream>
#include <map>

#include <gtest/gtest.h>

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

TEST(NetworkOfModel, NormalsAreFiniteWhereTheSheetTurnsBack) {
  // A disc closed by a second face upon it: at its rim the normals of both sides cancel.
  const PolylineMesh mesh =
      model({{circle(kO, kX, kY), {}}, {{arc(kO, kX, 0.02 * kZ, 0, kPi), false}, {.into = Into::Opening}}});
  const CurveNetwork network =
      network_of_model(mesh, diffusion_surface(mesh, {.splits = 2, .rounds = 0})).network;
  EXPECT_TRUE(network.normals.allFinite());
  EXPECT_LT((network.normals.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-9);
}

TEST(NetworkOfModel, SharpEdgesHaveANormalForEachSide) {
  // All edges sharp: the six squares are filled apart, each exactly flat, and welded into a closed cube.
  PolylineMesh mesh = cube();
  for (int c = 0; c < mesh.n_curves(); ++c)
    if (!mesh.edges_of_curve(c).empty())
      edit(mesh, [&](PolylineMesh& m) { return set_curve_sharpness(m, c, 1); });
  const DiffusionSurface surface = diffusion_surface(mesh);
  const ModelNetwork model = network_of_model(mesh, surface);
  EXPECT_EQ(model.network.curves.size(), 24u);
  for (Eigen::Index v = 0; v < model.network.normals.rows(); ++v)
    EXPECT_GT(model.network.normals.row(v).cwiseAbs().maxCoeff(), 1 - 1e-6) << v;
  const FilledModel filled = fill_model(mesh, surface);
  EXPECT_TRUE(filled.turned.empty());
  for (Eigen::Index v = 0; v < filled.mesh.n_vertices(); ++v) {
    const Eigen::RowVector3d p = filled.mesh.positions.row(v);
    EXPECT_LT(p.cwiseMin((1 - p.array()).matrix()).cwiseAbs().minCoeff(), 1e-6) << v;
  }
  // Closed, of genus 0: every edge has two triangles, V − E + F = 2.
  EXPECT_EQ(2 * filled.mesh.n_vertices(), filled.mesh.n_triangles() + 4);
  std::map<std::pair<int, int>, int> walks;
  for (Eigen::Index t = 0; t < filled.mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k) ++walks[{filled.mesh.triangles(t, k), filled.mesh.triangles(t, (k + 1) % 3)}];
  for (const auto& [edge, count] : walks) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(walks.count({edge.second, edge.first}), 1u);
  }
}

TEST(NetworkOfModel, IsFilledIntoTheSameSphere) {
  // Curvature surfacing with estimated normals; bound of the issue: 0.3 % in the mean.
  const PolylineMesh mesh = three_great_circles();
  const DiffusionSurface surface = diffusion_surface(mesh, {.splits = 4});
  const ModelNetwork model = network_of_model(mesh, surface);
  const CurveNetwork& network = model.network;
  EXPECT_EQ(network.curves.size(), 12u);
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
    EXPECT_GT(network.positions.row(v).normalized().dot(network.normals.row(v)), std::cos(0.02));
  EXPECT_EQ(model.cycles.size(), 8u);
  const FilledModel filled = fill_model(mesh, surface);
  EXPECT_TRUE(filled.turned.empty());
  const double mean = (filled.mesh.positions.rowwise().norm().array() - 1).abs().mean();
  std::cout << "mean error of the filled sphere: " << mean << '\n';
  EXPECT_LT(mean, 3e-3);
}

}  // namespace
}  // namespace batten
