#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/index.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"

namespace batten::detail {
namespace {

FairingSystems systems_of(const TriangleMesh& mesh, const std::vector<char>& fixed) {
  FairingSystems systems(fixed, border_vertices(mesh.triangles, mesh.n_vertices()), {});
  systems.set_metric(mesh.triangles, edge_lengths(mesh.positions, mesh.triangles));
  return systems;
}

// Linear functions have no Laplacian of any order: all three solves reproduce them from border values.
TEST(Polyharmonic, ReproducesLinearFunctionsOnAPlane) {
  const TriangleMesh mesh = samples::square(10, 0.6);
  FairingSystems systems = systems_of(mesh, border_vertices(mesh.triangles, mesh.n_vertices()));
  const Eigen::MatrixXd f = 2 * mesh.positions.col(0) - 3 * mesh.positions.col(1);
  const std::vector<char> border = border_vertices(mesh.triangles, mesh.n_vertices());
  for (const int order : {1, 2}) {
    Eigen::MatrixXd values = f;
    for (Eigen::Index v = 0; v < f.rows(); ++v)
      if (!border[v]) values(v, 0) = 0;
    EXPECT_LT((systems.polyharmonic(order, values) - f).norm(), 1e-9) << "order " << order;
  }
}

// Given the exact integrated Laplacian of a shape and its fixed vertices, the fit returns the shape.
TEST(FitLaplacian, ReturnsTheShapeWhoseLaplacianItIsGiven) {
  const TriangleMesh mesh = samples::torus(8);
  std::vector<char> fixed(mesh.n_vertices(), 0);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); v += 7) fixed[v] = 1;
  FairingSystems systems = systems_of(mesh, fixed);
  const Eigen::MatrixXd target = systems.stiffness() * mesh.positions;
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(mesh.n_vertices(), 3);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    if (fixed[v]) values.row(v) = mesh.positions.row(v);
  EXPECT_LT((systems.fit_laplacian(target, values) - mesh.positions).norm(), 1e-9);
  EXPECT_LT((systems.fit_laplacian_gradient(target, values) - mesh.positions).norm(), 1e-8);
}

// f = x³ over the square: Δf = 6x is even, so that the least ∫|∇Δf|² comes nearer to it than the least
// ∫|Δf|².
TEST(FitLaplacianGradient, LetsTheLaplacianGoUpEvenly) {
  const TriangleMesh mesh = samples::square(21);
  const Eigen::VectorXd x = mesh.positions.col(0), cubic = x.array().cube();
  std::vector<char> fixed(at(mesh.n_vertices()), 0);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    fixed[at(v)] = v / 21 % 5 == 0 || v % 21 % 5 == 0 || v % 21 == 20;
  FairingSystems systems = systems_of(mesh, fixed);
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(mesh.n_vertices(), 1);
  Eigen::MatrixXd values = zero;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    if (fixed[at(v)]) values(v, 0) = cubic[v];
  const double even = (systems.fit_laplacian_gradient(zero, values) - cubic).norm();
  EXPECT_LT(even, 0.1 * (systems.fit_laplacian(zero, values) - cubic).norm());
}

// On a mesh inscribed in a sphere (x_i − x_j)·N_i = |x_i − x_j|²/2R, so both forms agree to rounding.
TEST(CurvatureAlongEdges, EqualsTheCotangentFormOnAnInscribedSphere) {
  const TriangleMesh mesh = samples::octasphere(9, 2);
  const Points normals = mesh.positions / 2;
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  const Points Kx = K * mesh.positions;
  const Eigen::VectorXd curvature = curvature_along_edges(K, mesh.positions, normals);
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    EXPECT_NEAR(curvature[v], Kx.row(v).dot(normals.row(v)), 1e-13);
}

// S 4.5.1: a normal that vanished takes the mean of the smallest ring that has one.
TEST(NormalizePropagated, FillsVanishedNormalsFromTheRingAround) {
  const TriangleMesh mesh = samples::square(5);
  const SparseMatrix K = uniform_stiffness(mesh.triangles, mesh.n_vertices());
  Points normals = Points::Zero(25, 3);
  for (int v = 0; v < 25; ++v)
    if (v / 5 == 0 || v / 5 == 4 || v % 5 == 0 || v % 5 == 4) normals.row(v) << 0, 0, 3;
  normalize_propagated(normals, K);
  for (int v = 0; v < 25; ++v) EXPECT_LT((normals.row(v) - Eigen::RowVector3d(0, 0, 1)).norm(), 1e-14) << v;
}

}  // namespace
}  // namespace batten::detail
