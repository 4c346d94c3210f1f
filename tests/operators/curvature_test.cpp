#include "batten/operators/curvature.hpp"

#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

// Radius 2: H = 1/2, K = 1/4, both principal curvatures 1/2; the sign of H for outward normals is METHODS
// 0's.
TEST(DiscreteCurvatures, AreThoseOfASphere) {
  const TriangleMesh mesh = samples::octasphere(24, 2);
  const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    EXPECT_NEAR(c.mean[v], 0.5, 0.01);
    EXPECT_NEAR(c.gaussian[v], 0.25, 0.03);
  }
  EXPECT_NEAR(c.maximal.mean(), 0.5, 0.05);
}

TEST(DiscreteCurvatures, ChangeSignWithTheOrientation) {
  TriangleMesh mesh = samples::octasphere(8, 2);
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  EXPECT_NEAR(discrete_curvatures(mesh.positions, mesh.triangles).mean.mean(), -0.5, 0.02);
}

// Torus of radii R, r at tube angle b: κ1 = 1/r, κ2 = cos b/(R + r cos b). Second order in the step.
TEST(DiscreteCurvatures, ConvergeAtSecondOrderOnATorus) {
  const double R = 2, r = 0.7;
  const auto error = [&](int n) {
    const TriangleMesh mesh = samples::torus(n, R, r);
    const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
    double sum = 0;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
      const double rho = mesh.positions.row(v).head<2>().norm(), cosine = (rho - R) / r;
      sum += std::abs(c.mean[v] - 0.5 * (1 / r + cosine / rho));
    }
    return sum / static_cast<double>(mesh.n_vertices());
  };
  const double coarse = error(24), fine = error(48);
  EXPECT_LT(fine, 0.01);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2);
}

// A cylinder of radius 0.5: κ1 = 2, κ2 = 0, away from its rims.
TEST(DiscreteCurvatures, SplitIntoThePrincipalOnesOnACylinder) {
  const TriangleMesh mesh = samples::mapped_grid(48, 20, true, false, [](double u, double v) {
    return Eigen::Vector3d(0.5 * std::cos(2 * kPi * u), 0.5 * std::sin(2 * kPi * u), v);
  });
  const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    if (c.on_border[v]) continue;
    EXPECT_NEAR(c.maximal[v], 2, 0.02);
    EXPECT_NEAR(c.minimal[v], 0, 0.02);
  }
}

// Gauss-Bonnet is exact on meshes: 2π times 2, 0 and 1.
TEST(TotalAngleDeficit, IsTwoPiTimesTheEulerCharacteristic) {
  const TriangleMesh sphere = samples::octasphere(5, 1), torus = samples::torus(8),
                     square = samples::square(6, 0.5);
  EXPECT_NEAR(total_angle_deficit(sphere.positions, sphere.triangles), 4 * kPi, 1e-11);
  EXPECT_NEAR(total_angle_deficit(torus.positions, torus.triangles), 0, 1e-11);
  EXPECT_NEAR(total_angle_deficit(square.positions, square.triangles), 2 * kPi, 1e-11);
}

// S (4.18) is −2 H N times the area (errata): on a sphere of radius 2 its length over the Voronoi area is 1.
TEST(CurvatureFromNormals, IsMinusTwiceTheMeanCurvatureOnASphere) {
  const TriangleMesh mesh = samples::octasphere(20, 2);
  const Points normals = mesh.positions / 2;
  const Points sum = integrated_curvature_from_normals(mesh.positions, normals, mesh.triangles);
  double along = 0;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) along += sum.row(v).dot(normals.row(v));
  EXPECT_NEAR(along / (4 * kPi * 4), -1, 0.01);  // over the area of the sphere
}

}  // namespace
}  // namespace batten
