#include "batten/pipeline/reconstruction.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

TEST(Reconstruct, ExactScanOfASphereComesBackAsOne) {
  SimulateOptions device;
  device.step = 0.01;
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), device).scan;
  const Reconstruction result = reconstruct(scan);
  EXPECT_TRUE(result.surface.topology.is_watertight());
  EXPECT_TRUE(result.surface.is_sound());
  EXPECT_EQ(static_cast<int>(result.surface.n_curves), result.network.report.n_curves);
  // A scan fixes neither place nor attitude: spread of the distances from the centre of the vertices.
  const Points& points = result.surface.mesh.positions;
  const Eigen::RowVector3d centre = (points.colwise().maxCoeff() + points.colwise().minCoeff()) / 2;
  const Eigen::VectorXd radii = (points.rowwise() - centre).rowwise().norm();
  EXPECT_LT(radii.maxCoeff() / radii.minCoeff(), 1.01);
}

TEST(Reconstruct, BadOptionsOfEitherStageAreNamed) {
  ReconstructionOptions options;
  options.network.xi = -1;
  EXPECT_THROW(reconstruct({}, options), InvalidInput);
  options.network.xi = 1;
  options.surface.surface.soft_weight = -1;
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("soft_weight"), std::string::npos);
}

}  // namespace
}  // namespace batten
