#include "batten/operators/curvature.hpp"

#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

// Radius 2: H = 1/2, K = 1/4, both principal curvatures 1/2; the sign of H is that of
// docs/methods.md#conventions.
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

// The Gaussian curvature on the same torus, κ1 κ2, by the angle deficit.
TEST(DiscreteCurvatures, ConvergeAtSecondOrderToTheGaussianOneOnATorus) {
  const double R = 2, r = 0.7;
  const auto error = [&](int n) {
    const TriangleMesh mesh = samples::torus(n, R, r);
    const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
    double sum = 0;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
      const double rho = mesh.positions.row(v).head<2>().norm(), cosine = (rho - R) / r;
      sum += std::abs(c.gaussian[v] - cosine / (r * rho));
    }
    return sum / static_cast<double>(mesh.n_vertices());
  };
  EXPECT_NEAR(std::log2(error(24) / error(48)), 2, 0.3);
}

// On a sphere the cotangent vector over the Voronoi area is exact but where triangles are obtuse, so the mean
// curvature converges faster than at second order; the Gaussian one is held to first by the six vertices of
// valence four.
TEST(DiscreteCurvatures, ConvergeOnASphere) {
  const auto error = [&](int n) {
    const TriangleMesh mesh = samples::octasphere(n, 2);
    const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
    return Eigen::Vector2d((c.mean.array() - 0.5).abs().mean(), (c.gaussian.array() - 0.25).abs().mean());
  };
  const Eigen::Vector2d coarse = error(12), fine = error(24);
  EXPECT_GT(std::log2(coarse[0] / fine[0]), 1.9);
  EXPECT_GT(std::log2(coarse[1] / fine[1]), 0.9);
}

// On a regular polygon the second difference over the squared chord is 2R(1 − cos)/(2R²(1 − cos)) = 1/R: the
// mean curvature of an evenly cut cylinder is exact, and its triangles unroll, so that K is 0.
TEST(DiscreteCurvatures, AreExactOnAnEvenlyCutCylinder) {
  const TriangleMesh mesh = samples::mapped_grid(16, 8, true, false, [](double u, double v) {
    return Eigen::Vector3d(0.5 * std::cos(2 * kPi * u), 0.5 * std::sin(2 * kPi * u), 1.5 * v);
  });
  const Curvatures c = discrete_curvatures(mesh.positions, mesh.triangles);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    if (!c.on_border[v]) {
      EXPECT_NEAR(c.mean[v], 1, 1e-10);
      EXPECT_NEAR(c.gaussian[v], 0, 1e-10);
    }
}

// (1.29) as printed is −2 H N (docs/errata.md#h-1-29): here with the sign of (1.28). On a sphere of radius 2
// it points outwards with the length 2 H = 1; on a torus it converges at second order.
TEST(CurvatureFromDivergence, HasTheSignAndTheLimitOfTheLaplacianOfThePositions) {
  const TriangleMesh sphere = samples::octasphere(20, 2);
  const Points wide = curvature_from_divergence(sphere.positions, sphere.triangles);
  const Eigen::VectorXd along = wide.cwiseProduct(sphere.positions).rowwise().sum() / 2;
  EXPECT_NEAR(along.mean(), 1, 0.03);
  EXPECT_GT(along.minCoeff(), 0.85);  // at the six vertices of valence four
  const double R = 2, r = 0.7;
  const auto error = [&](int n) {
    const TriangleMesh mesh = samples::torus(n, R, r);
    const Points vector = curvature_from_divergence(mesh.positions, mesh.triangles);
    double sum = 0;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
      const Eigen::RowVector3d x = mesh.positions.row(v);
      const double rho = x.head<2>().norm(), cosine = (rho - R) / r;
      const Eigen::RowVector3d normal = (x - Eigen::RowVector3d(x[0], x[1], 0) * (R / rho)) / r;
      sum += (vector.row(v) - (1 / r + cosine / rho) * normal).norm();
    }
    return sum / static_cast<double>(mesh.n_vertices());
  };
  const double coarse = error(24), fine = error(48);
  EXPECT_LT(fine, 0.05);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.3);
}

// The reason for the wide stencil (H 1.3): noise of one hundredth of an edge shows less in it.
TEST(CurvatureFromDivergence, IsLessMovedByNoise) {
  const TriangleMesh mesh = samples::octasphere(16, 2);
  TriangleMesh noisy = mesh;
  Random random(5);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) noisy.positions.row(v) *= 1 + 0.0005 * random.normal();
  const auto moved = [&](const auto& curvature) { return (curvature(noisy) - curvature(mesh)).norm(); };
  const double narrow = moved([](const TriangleMesh& m) -> Points {
    return discrete_curvatures(m.positions, m.triangles).mean_vector;
  });
  const double wide = moved(
      [](const TriangleMesh& m) -> Points { return curvature_from_divergence(m.positions, m.triangles); });
  EXPECT_LT(wide, 0.7 * narrow);
}

// Gauss-Bonnet is exact on meshes: 2π times 2, 0 and 1.
TEST(TotalAngleDeficit, IsTwoPiTimesTheEulerCharacteristic) {
  const TriangleMesh sphere = samples::octasphere(5, 1), torus = samples::torus(8),
                     square = samples::square(6, 0.5);
  EXPECT_NEAR(total_angle_deficit(sphere.positions, sphere.triangles), 4 * kPi, 1e-11);
  EXPECT_NEAR(total_angle_deficit(torus.positions, torus.triangles), 0, 1e-11);
  EXPECT_NEAR(total_angle_deficit(square.positions, square.triangles), 2 * kPi, 1e-11);
}

// S (4.18) is −2 H N times the area (docs/errata.md#s-4-18): on a sphere of radius 2 its length over the
// Voronoi area is 1.
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
