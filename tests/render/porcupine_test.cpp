#include "batten/render/porcupine.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

/// A circle of latitude z of the sphere of radius r, closed or a half.
CurveNetwork latitude(int n, double r, double z, bool closed, bool normals) {
  CurveNetwork network;
  const double rho = std::sqrt(r * r - z * z);
  const int count = closed ? n : n + 1;
  network.positions.resize(count, 3);
  NetworkCurve curve;
  for (int i = 0; i < count; ++i) {
    const double a = (closed ? 2 : 1) * kPi * i / n;
    network.positions.row(i) << rho * std::cos(a), rho * std::sin(a), z;
    curve.vertices.push_back(i);
  }
  if (closed) curve.vertices.push_back(0);
  network.curves.push_back(curve);
  if (normals) network.normals = network.positions / r;
  return network;
}

// Three points of a circle give its radius exactly. Along a circle of latitude the normal curvature is 1/r
// (Meusnier), the curvature of the curve itself 1/ρ.
TEST(Porcupine, IsTheNormalCurvatureOnASphere) {
  for (const bool closed : {true, false})
    for (const double z : {0.0, 0.9}) {
      const auto with = porcupine(latitude(40, 1.5, z, closed, true)).front();
      const auto without = porcupine(latitude(40, 1.5, z, closed, false)).front();
      for (Eigen::Index i = 0; i < with.curvature.size(); ++i) {
        // At the ends of an open curve the normal is that of the end, the circle that of its neighbour.
        const bool end = !closed && (i == 0 || i + 1 == with.curvature.size());
        EXPECT_NEAR(with.curvature[i], 1 / 1.5, end ? 0.01 : 1e-12);
        EXPECT_NEAR(without.curvature[i], 1 / std::sqrt(1.5 * 1.5 - z * z), 1e-12);
      }
    }
}

TEST(Porcupine, IsZeroOnALineAndOnRepeatedPoints) {
  CurveNetwork network;
  network.positions.resize(4, 3);
  network.positions << 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 2, 2;
  network.curves.push_back({"", false, {0, 1, 2, 3}});
  EXPECT_LT(porcupine(network).front().curvature.cwiseAbs().maxCoeff(), 1e-14);
  network.curves[0].vertices[1] = 9;
  EXPECT_THROW(porcupine(network), InvalidInput);
}

}  // namespace
}  // namespace batten
