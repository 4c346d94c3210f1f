#include "batten/pipeline/surface_uncertainty.hpp"

#include "network/sample_networks.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/pipeline/network_surface.hpp"

namespace batten {
namespace {

CurveNetwork circle_of_radius(double radius, int n) {
  CurveNetwork network;
  network.positions.resize(n, 3);
  network.normals.resize(n, 3);
  NetworkCurve curve;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n;
    network.normals.row(k) << std::cos(angle), std::sin(angle), 0;
    curve.vertices.push_back(k);
  }
  network.positions = radius * network.normals;
  curve.vertices.push_back(0);
  network.curves.push_back(curve);
  return network;
}

TEST(CurvatureChange, OfACircleIsItsCurvatureAndNoChange) {
  const CurvatureChange change = curvature_change(circle_of_radius(2.5, 100));
  EXPECT_NEAR(change.curvature, 1 / 2.5, 1e-3);
  EXPECT_LT(change.change, 1e-9);
}

// −Δu = 1 on a square of side 1, 0 on its sides: 0.0737 in the middle.
TEST(DeviationBetweenCurves, FollowsTheTorsionOfASquare) {
  constexpr int kSide = 20;
  TriangleMesh mesh;
  mesh.positions.resize((kSide + 1) * (kSide + 1), 3);
  mesh.triangles.resize(2 * kSide * kSide, 3);
  std::vector<char> on_curves;
  for (int j = 0, t = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i) {
      const int v = j * (kSide + 1) + i;
      mesh.positions.row(v) << static_cast<double>(i) / kSide, static_cast<double>(j) / kSide, 0;
      on_curves.push_back(i == 0 || j == 0 || i == kSide || j == kSide ? 1 : 0);
      if (i == kSide || j == kSide) continue;
      mesh.triangles.row(t++) << v, v + 1, v + kSide + 2;
      mesh.triangles.row(t++) << v, v + kSide + 2, v + kSide + 1;
    }
  const int middle = kSide / 2 * (kSide + 1) + kSide / 2;
  const Eigen::VectorXd round = deviation_between_curves(mesh, on_curves, {2, 0});
  const Eigen::VectorXd waved = deviation_between_curves(mesh, on_curves, {0, 3});
  for (std::size_t v = 0; v < on_curves.size(); ++v)
    EXPECT_EQ(round[static_cast<Eigen::Index>(v)] == 0, on_curves[v] != 0);
  Eigen::Index most = 0;
  round.maxCoeff(&most);
  EXPECT_EQ(most, middle);
  // Linear in the curvatures; powers 1 and 3/2 of u.
  const double u = round[middle] / (0.005 * 2);
  EXPECT_NEAR(u, 0.0737, 0.001);
  EXPECT_NEAR(waved[middle], 0.15 * 3 * std::pow(u, 1.5), 1e-12);
}

// What moves all curves alike moves the surface alike; across it, by the normal's share.
TEST(SurfaceUncertainty, OfAShiftIsTheShiftAcrossTheSurface) {
  const CurveNetwork network = samples::octahedral_sphere(6);
  SurfaceSolver solver(network);
  const Points built = solver.result().mesh.positions;
  const Eigen::RowVector3d shift(0.003, -0.001, 0.002);
  NetworkUncertainty of_network;
  of_network.deviations = Eigen::VectorXd::Constant(network.positions.rows(), shift.norm());
  NetworkVariation draw;
  draw.moves = shift.replicate(network.positions.rows(), 1);
  draw.turns = Points::Zero(network.positions.rows(), 3);
  of_network.draws = {draw, draw};
  const SurfaceUncertainty found = surface_uncertainty(solver, network, of_network);
  const Eigen::VectorXd expected = (solver.result().mesh.normals * shift.transpose()).cwiseAbs();
  EXPECT_LT((found.from_curves - expected).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(solver.result().mesh.positions, built);  // left as it was
  EXPECT_LT((found.deviations.cwiseAbs2() - found.from_curves.cwiseAbs2() - found.between_curves.cwiseAbs2())
                .cwiseAbs()
                .maxCoeff(),
            1e-15);
  // Without draws the same deviation everywhere stays the same between the curves.
  of_network.draws.clear();
  const SurfaceUncertainty spread = surface_uncertainty(solver, network, of_network);
  EXPECT_LT((spread.from_curves.array() - shift.norm()).abs().maxCoeff(), 1e-9);
  of_network.deviations.conservativeResize(3);
  EXPECT_THROW(surface_uncertainty(solver, network, of_network), InvalidInput);
}

TEST(UncertainSurface, IsTheSurfaceWithAValuePerVertex) {
  const CurveNetwork network = samples::octahedral_sphere(6);
  NetworkUncertainty exact;
  exact.deviations = Eigen::VectorXd::Zero(network.positions.rows());
  const NetworkSurface surface = uncertain_surface(network, exact);
  EXPECT_EQ(surface.mesh.positions, network_surface(network).mesh.positions);
  const Eigen::VectorXd& values = surface.mesh.vertex_values.at("uncertainty");
  ASSERT_EQ(values.size(), surface.mesh.n_vertices());
  EXPECT_EQ(values.head(network.positions.rows()).maxCoeff(), 0);
  EXPECT_GT(values.maxCoeff(), 0);
}

}  // namespace
}  // namespace batten
