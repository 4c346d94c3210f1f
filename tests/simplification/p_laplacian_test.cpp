#include "batten/simplification/p_laplacian.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

Shape bumpy_square(int n) {
  return fixtures::grid(n, n, false, false, [](double u, double v) {
    return Vector3d(u, v, 0.1 * std::sin(9 * u) * std::sin(7 * v));
  });
}

// p = 2 and w1 make L_p the graph Laplacian (γ = 2 w, half of it in (2.95)): one step is the dense solve of
// (I + dt L + dt λ) X' = (1 + dt λ) X with border rows replaced by the identity.
TEST(PLaplacianFlow, AgreesWithADenseSolveForTheOrdinaryLaplacian) {
  const Shape shape = bumpy_square(5);
  PLaplacianOptions options;
  options.p = 2;
  options.weight = FlowWeight::Uniform;
  options.fidelity = 0.3;
  options.steps = 1;
  options.time_step = 0.7;
  const Points moved = p_laplacian_flow(shape.positions, shape.triangles, options);
  const Eigen::Index n = shape.positions.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n), L = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index f = 0; f < shape.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = shape.triangles(f, k), j = shape.triangles(f, (k + 1) % 3);
      L(i, j) = L(j, i) = -1;
    }
  L.diagonal() = -L.rowwise().sum();
  A += 0.7 * L + 0.7 * 0.3 * Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd right = (1 + 0.7 * 0.3) * shape.positions;
  for (Eigen::Index v = 0; v < n; ++v) {
    const Vector3d p = shape.positions.row(v);
    if (p.x() > 0 && p.x() < 1 && p.y() > 0 && p.y() < 1) continue;
    A.row(v).setZero();
    A(v, v) = 1;
    right.row(v) = shape.positions.row(v);
  }
  const Eigen::MatrixXd expected = A.partialPivLu().solve(right);
  EXPECT_LT((moved - expected).cwiseAbs().maxCoeff(), 1e-12);
}

// The matrix is positive definite and its inverse averages: no vertex leaves the box of the input.
TEST(PLaplacianFlow, StaysInsideTheBoundingBoxForEveryExponentAndWeight) {
  const Shape shape = bumpy_square(12);
  for (const double p : {0.1, 1.0, 2.0})
    for (const FlowWeight weight : {FlowWeight::Uniform, FlowWeight::InverseLength, FlowWeight::Curvature}) {
      PLaplacianOptions options;
      options.p = p;
      options.weight = weight;
      options.steps = 20;
      options.time_step = 5;
      const Points moved = p_laplacian_flow(shape.positions, shape.triangles, options);
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(moved.col(k).maxCoeff(), shape.positions.col(k).maxCoeff() + 1e-12);
        EXPECT_GE(moved.col(k).minCoeff(), shape.positions.col(k).minCoeff() - 1e-12);
      }
    }
}

// A large fidelity pulls back to the input; without any the flow goes furthest.
TEST(PLaplacianFlow, FidelityPullsBackToTheInput) {
  const Shape shape = fixtures::sphere(10);
  PLaplacianOptions options;
  options.steps = 5;
  options.time_step = 2;
  double before = 1e300;
  for (const double fidelity : {0.0, 1.0, 100.0}) {
    options.fidelity = fidelity;
    const double moved =
        (p_laplacian_flow(shape.positions, shape.triangles, options) - shape.positions).norm();
    EXPECT_GT(moved, 0);
    EXPECT_LT(moved, before);
    before = moved;
  }
}

// Lengths are taken in mean edges: the flow of a scaled and moved mesh is the scaled and moved flow.
TEST(PLaplacianFlow, CommutesWithScalingAndMoving) {
  const Shape shape = fixtures::blob(8);
  const Points reference = p_laplacian_flow(shape.positions, shape.triangles);
  for (const double scale : {1e-3, 1e3}) {
    Points positions = scale * shape.positions;
    positions.rowwise() += scale * Eigen::RowVector3d(1, -2, 0.5);
    const Points moved = p_laplacian_flow(positions, shape.triangles);
    Points expected = scale * reference;
    expected.rowwise() += scale * Eigen::RowVector3d(1, -2, 0.5);
    EXPECT_LT((moved - expected).cwiseAbs().maxCoeff(), 1e-8 * scale);
  }
}

TEST(PLaplacianFlow, BadOptionsAreRefused) {
  const Shape shape = fixtures::sphere(3);
  for (const auto& change : std::vector<void (*)(PLaplacianOptions&)>{
           [](PLaplacianOptions& o) { o.p = 0; }, [](PLaplacianOptions& o) { o.p = 3; },
           [](PLaplacianOptions& o) { o.time_step = 0; }, [](PLaplacianOptions& o) { o.sigma = -1; },
           [](PLaplacianOptions& o) { o.fidelity = -1; }, [](PLaplacianOptions& o) { o.epsilon = 0; }}) {
    PLaplacianOptions options;
    change(options);
    EXPECT_THROW(p_laplacian_flow(shape.positions, shape.triangles, options), InvalidInput);
  }
}

}  // namespace
}  // namespace batten
