#include "batten/operators/gradient.hpp"

#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {
namespace {

// On a plane the gradient of a linear function is its coefficient vector on every triangle and vertex.
TEST(Gradient, IsExactForLinearFunctionsOnAPlane) {
  const TriangleMesh mesh = samples::square(8, 0.7);
  const Eigen::VectorXd f = 2 * mesh.positions.col(0) - 3 * mesh.positions.col(1);
  for (const SparseMatrix& G :
       {face_gradient(mesh.positions, mesh.triangles), vertex_gradient(mesh.positions, mesh.triangles)}) {
    const Eigen::VectorXd g = G * f;
    for (Eigen::Index i = 0; i < g.size() / 3; ++i)
      EXPECT_LT((g.segment<3>(3 * i) - Eigen::Vector3d(2, -3, 0)).norm(), 1e-11);
  }
}

// D = −Gᵀ A and D G = −K: the divergence of the gradient is the (integrated) Laplacian.
TEST(Divergence, OfTheGradientIsTheCotangentLaplacian) {
  const TriangleMesh mesh = samples::torus(6);
  const SparseMatrix G = face_gradient(mesh.positions, mesh.triangles);
  const SparseMatrix D = face_divergence(mesh.positions, mesh.triangles);
  const SparseMatrix K = cotangent_stiffness(mesh.positions, mesh.triangles);
  EXPECT_LT(Eigen::MatrixXd(D * G + K).norm(), 1e-10);
}

/// A vector of n normally distributed numbers.
Eigen::VectorXd random_vector(Eigen::Index n, std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) values[i] = random.normal();
  return values;
}

// ⟨div u, f⟩ = −∫ u · ∇f for any u and f: the divergence is minus the adjoint of the gradient, on closed
// meshes and on open ones, where it counts the flow over the border.
TEST(Divergence, IsMinusTheAdjointOfTheGradient) {
  for (const TriangleMesh& mesh : {samples::torus(7), samples::square(9, 0.8), samples::octasphere(4, 2)}) {
    const Eigen::VectorXd u = random_vector(3 * mesh.n_triangles(), 1),
                          f = random_vector(mesh.n_vertices(), 2);
    const Eigen::VectorXd Gf = face_gradient(mesh.positions, mesh.triangles) * f;
    const Eigen::VectorXd areas = face_areas(mesh.positions, mesh.triangles);
    double right = 0;
    for (Eigen::Index t = 0; t < areas.size(); ++t)
      right += areas[t] * u.segment<3>(3 * t).dot(Gf.segment<3>(3 * t));
    const double left = (face_divergence(mesh.positions, mesh.triangles) * u).dot(f);
    EXPECT_NEAR(left, -right, 1e-11 * (std::abs(left) + u.norm() * Gf.norm()));
  }
}

// The field (2x + y, 3x − 5y, 7x) in the plane z = 0 has the divergence 2 − 5 on every vertex; the part that
// stands on the plane does not count.
TEST(VertexDivergence, IsExactForLinearFieldsOnAPlane) {
  const TriangleMesh mesh = samples::square(8, 0.7);
  Eigen::VectorXd field(3 * mesh.n_vertices());
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    const double x = mesh.positions(v, 0), y = mesh.positions(v, 1);
    field.segment<3>(3 * v) << 2 * x + y, 3 * x - 5 * y, 7 * x;
  }
  const Eigen::VectorXd divergence = vertex_divergence(mesh.positions, mesh.triangles) * field;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) EXPECT_NEAR(divergence[v], -3, 1e-11);
}

// Only in the limit is the divergence per vertex minus the adjoint of the gradient per vertex: the defect
// |∫ f div V + ∫ V · ∇f| of smooth f and V on a torus falls at second order.
TEST(VertexDivergence, IsMinusTheAdjointOfTheGradientInTheLimit) {
  const auto defect = [](int n) {
    const TriangleMesh mesh = samples::torus(n);
    const Eigen::VectorXd mass = lumped_mass(mesh.positions, mesh.triangles, MassKind::Barycentric);
    Eigen::VectorXd f(mesh.n_vertices()), V(3 * mesh.n_vertices());
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
      const Eigen::Vector3d x = mesh.positions.row(v);
      f[v] = std::sin(x[0]) + x[2] * x[1];
      V.segment<3>(3 * v) << std::cos(x[1]), x[0] * x[2], x[0];
      // Tangential: (1.4) leaves out what the normal part adds, 2 H N · V.
      const double rho = x.head<2>().norm();
      const Eigen::Vector3d normal = (x - Eigen::Vector3d(2 * x[0] / rho, 2 * x[1] / rho, 0)).normalized();
      V.segment<3>(3 * v) -= normal.dot(V.segment<3>(3 * v)) * normal;
    }
    const Eigen::VectorXd divergence = vertex_divergence(mesh.positions, mesh.triangles) * V;
    const Eigen::VectorXd gradient = vertex_gradient(mesh.positions, mesh.triangles) * f;
    double sum = 0;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
      sum += mass[v] * (f[v] * divergence[v] + V.segment<3>(3 * v).dot(gradient.segment<3>(3 * v)));
    return std::abs(sum);
  };
  const double coarse = defect(16), fine = defect(32);
  EXPECT_GT(coarse, 1e-6);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.3);
}

TEST(Gradient, IsZeroOnTrianglesWithoutArea) {
  TriangleMesh mesh = samples::square(3);
  mesh.positions.row(4) = mesh.positions.row(5);
  EXPECT_TRUE(Eigen::MatrixXd(face_gradient(mesh.positions, mesh.triangles)).allFinite());
  EXPECT_TRUE(Eigen::MatrixXd(vertex_divergence(mesh.positions, mesh.triangles)).allFinite());
}

}  // namespace
}  // namespace batten
