// After [mueller2016].
#include "batten/deformation/local_rotations.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "batten/core/parallel.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d rotation_by_svd(const Matrix3d& C) {
  const Eigen::JacobiSVD<Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs[2] = -1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// Rodrigues' formula for the rotation vector omega.
Matrix3d rotation_of(const Vector3d& omega) {
  const double angle2 = omega.squaredNorm();
  const double angle = std::sqrt(angle2);
  // Below 1e-4 the series is exact to the last bit.
  const double s = angle > 1e-4 ? std::sin(angle) / angle : 1 - angle2 / 6;
  const double c = angle > 1e-4 ? (1 - std::cos(angle)) / angle2 : 0.5 - angle2 / 24;
  Matrix3d W;
  W << 0, -omega[2], omega[1], omega[2], 0, -omega[0], -omega[1], omega[0], 0;
  return Matrix3d::Identity() + s * W + c * W * W;
}

}  // namespace

Matrix3d nearest_rotation(const Matrix3d& C, const Matrix3d& start) {
  const double size = C.norm();
  if (!(size > 0)) return start;
  // Newton on the group: the torque of R towards C, divided by the stiffness of trace(Rᵀ C) against turning.
  // It converges quadratically near the maximum, but could stop at a saddle: the stiffness must be positive.
  Matrix3d R = start;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Matrix3d P = C * R.transpose();
    const Vector3d torque(P(2, 1) - P(1, 2), P(0, 2) - P(2, 0), P(1, 0) - P(0, 1));
    Matrix3d stiffness = -0.5 * (P + P.transpose());
    stiffness.diagonal().array() += P.trace();
    const double a = stiffness(0, 0), det2 = a * stiffness(1, 1) - stiffness(0, 1) * stiffness(0, 1);
    const double det = stiffness.determinant();
    if (!(a > 0 && det2 > 0 && det > 1e-9 * size * size * size)) return rotation_by_svd(C);
    const Vector3d omega = stiffness.inverse() * torque;
    if (omega.squaredNorm() > 1) return rotation_by_svd(C);
    R = rotation_of(omega) * R;
    if (omega.squaredNorm() < 1e-16) return R;
  }
  return rotation_by_svd(C);
}

Matrix3d one_ring_covariance(const SparseMatrix& stiffness, const Points& rest, const Points& deformed,
                             Eigen::Index i) {
  Matrix3d C = Matrix3d::Zero();
  for (SparseMatrix::InnerIterator entry(stiffness, i); entry; ++entry) {
    const Eigen::Index j = entry.row();
    if (j == i || entry.value() >= 0) continue;
    const Vector3d x = rest.row(j) - rest.row(i), y = deformed.row(j) - deformed.row(i);
    C += (-entry.value() * y) * x.transpose();
  }
  return C;
}

void fit_local_rotations(const SparseMatrix& stiffness, const Points& rest, const Points& deformed,
                         std::vector<Matrix3d>& rotations) {
  if (static_cast<Eigen::Index>(rotations.size()) != rest.rows())
    rotations.assign(rest.rows(), Matrix3d::Identity());
  parallel_for(rest.rows(), 512, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      rotations[i] = nearest_rotation(one_ring_covariance(stiffness, rest, deformed, i), rotations[i]);
    }
  });
}

}  // namespace batten
