#include "batten/remeshing/area_samples.hpp"

#include "remeshing/surfaces.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace batten {
namespace {

using fixtures::grid_of;
using fixtures::roof;

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
