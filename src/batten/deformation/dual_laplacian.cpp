#include "batten/deformation/dual_laplacian.hpp"

#include <Eigen/Dense>

#include "batten/core/parallel.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Singular values of the normals of a ring below this share of the largest are taken as zero: along those
/// directions a small turn of a face makes the vector swing by the inverse of the share. At 0.05 the
/// iteration runs away on most scans and CAD meshes; at 0.5 on none that was tried.
constexpr double kLeastSpread = 0.5;
/// Vectors of which more than this share lies in such directions turn with their one-rings instead.
constexpr double kLeftOut = 0.15;

Points face_crosses(const Points& positions, const Triangles& triangles) {
  Points crosses(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = positions.row(triangles(f, 0));
    const Vector3d b = positions.row(triangles(f, 1)), c = positions.row(triangles(f, 2));
    crosses.row(f) = (b - a).cross(c - a);
  }
  return crosses;
}

}  // namespace

DualLaplacian::DualLaplacian(const Points& positions, const Triangles& triangles, const Points& delta)
    : triangles_(triangles), mu_(Points::Zero(triangles.rows(), 3)), length_(delta.rowwise().norm()) {
  const Points crosses = face_crosses(positions, triangles);
  std::vector<Matrix3d> gram(positions.rows(), Matrix3d::Zero());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Matrix3d square = crosses.row(f).transpose() * crosses.row(f);
    for (int k = 0; k < 3; ++k) gram[triangles(f, k)] += square;
  }
  // μ = Aᵀ (A Aᵀ)⁺ δ with the columns of A the crosses: the least-norm solution of (2.74).
  Points solution = Points::Zero(positions.rows(), 3);
  followed_.assign(positions.rows(), 0);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(gram[i]);
    const Vector3d& values = eigen.eigenvalues();
    if (!(values[2] > 0)) continue;
    const Vector3d d = delta.row(i);
    Vector3d expressed = Vector3d::Zero(), y = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      if (values[k] < kLeastSpread * kLeastSpread * values[2]) continue;
      const Vector3d axis = eigen.eigenvectors().col(k);
      expressed += axis.dot(d) * axis;
      y += axis.dot(d) / values[k] * axis;
    }
    solution.row(i) = y;
    followed_[i] = (expressed - d).norm() <= kLeftOut * d.norm();
  }
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) mu_(f, k) = crosses.row(f).dot(solution.row(triangles(f, k)));
}

void DualLaplacian::evaluate(const Points& positions, Points& delta) const {
  const Points crosses = face_crosses(positions, triangles_);
  delta = Points::Zero(positions.rows(), 3);
  for (Eigen::Index f = 0; f < triangles_.rows(); ++f)
    for (int k = 0; k < 3; ++k) delta.row(triangles_(f, k)) += mu_(f, k) * crosses.row(f);
  for (Eigen::Index i = 0; i < delta.rows(); ++i) {
    const double length = delta.row(i).norm();
    // (2.77) with its guard: a flat ring has no vector to follow.
    if (followed_[i] && length > 0)
      delta.row(i) *= length_[i] / length;
    else
      delta.row(i).setZero();
  }
}

}  // namespace batten
