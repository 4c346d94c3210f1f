#include "batten/operators/gradient.hpp"

#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

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

TEST(Gradient, IsZeroOnTrianglesWithoutArea) {
  TriangleMesh mesh = samples::square(3);
  mesh.positions.row(4) = mesh.positions.row(5);
  EXPECT_TRUE(Eigen::MatrixXd(face_gradient(mesh.positions, mesh.triangles)).allFinite());
}

}  // namespace
}  // namespace batten
