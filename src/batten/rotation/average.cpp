#include "batten/rotation/average.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// @return the sum of the weights.
double check(size_t n_rotations, const std::vector<double>& weights) {
  if (n_rotations == 0) throw InvalidInput("an average needs at least one rotation");
  if (weights.empty()) return static_cast<double>(n_rotations);
  if (weights.size() != n_rotations)
    throw InvalidInput(
        concat("an average of ", n_rotations, " rotations needs as many weights, got ", weights.size()));
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] >= 0) || !std::isfinite(weights[i]))
      throw InvalidInput(concat("weight ", i, " of an average must be >= 0, got ", weights[i]));
    sum += weights[i];
  }
  if (!(sum > 0)) throw InvalidInput("the weights of an average must not all be zero");
  return sum;
}

double weight(const std::vector<double>& weights, size_t i) {
  return weights.empty() ? 1.0 : weights[i];
}

Eigen::Quaterniond dominant_eigenvector(const Eigen::Matrix4d& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(M);
  Eigen::Quaterniond q;
  q.coeffs() = solver.eigenvectors().col(3);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q.normalized();
}

}  // namespace

Eigen::Quaterniond rotation_average(const std::vector<Eigen::Quaterniond>& rotations,
                                    const std::vector<double>& weights) {
  const double sum = check(rotations.size(), weights);
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector4d q = rotations[i].coeffs();
    M += weight(weights, i) / (sum * q.squaredNorm()) * q * q.transpose();
  }
  return dominant_eigenvector(M);
}

Eigen::Matrix3d rotation_average(const std::vector<Eigen::Matrix3d>& rotations,
                                 const std::vector<double>& weights) {
  std::vector<Eigen::Quaterniond> quaternions;
  quaternions.reserve(rotations.size());
  for (const Eigen::Matrix3d& R : rotations) quaternions.emplace_back(R);
  return rotation_average(quaternions, weights).toRotationMatrix();
}

Eigen::Matrix3d rotation_average_with_normal(const std::vector<Eigen::Matrix3d>& rotations,
                                             const std::vector<double>& weights,
                                             const Eigen::Vector3d& normal, double w) {
  const double sum = check(rotations.size(), weights);
  if (!(w >= 0 && w < 1)) throw InvalidInput(concat("the weight of the normal must be in [0, 1), got ", w));
  if (!(normal.norm() > 0)) throw InvalidInput("the normal of a constrained average has no direction");
  const Eigen::Vector3d n = normal.normalized();
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector4d q = Eigen::Quaterniond(rotations[i]).normalized().coeffs();
    M += weight(weights, i) / sum * q * q.transpose();
  }
  const Eigen::Matrix4d K = 4 * M - Eigen::Matrix4d::Identity();  // S (3.19) with Σ α = 1
  // N = A e₂ as quadratic forms in q = (x, y, z, w). S prints them for (2.26), the transpose of the matrix
  // used here; in Hamilton's matrix the terms with w in K_x and K_z change their sign.
  Eigen::Matrix4d Kx, Ky, Kz;
  Kx << 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0, 0, -1, 0;
  Ky << -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1;
  Kz << 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0;
  return dominant_eigenvector((1 - w) * K + w * (n.x() * Kx + n.y() * Ky + n.z() * Kz)).toRotationMatrix();
}

}  // namespace batten
