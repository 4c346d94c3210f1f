#include "batten/rotation/wahba.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;

// Of a matrix of unit vectors with weights that sum to one: below this second singular value (the product of
// the spreads of both sides, so about a thousandth of a degree each) the directions count as parallel.
constexpr double kParallel = 1e-9;

Vector3d unit(const Vector3d& v, const char* side, size_t pair) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InvalidInput(concat("the ", side, " vector of pair ", pair + 1,
                              " vanishes or is not finite; leave the reading out"));
  return v / length;
}

/// (3.13): Ω(m), with v = (x, y, z, w) the quaternion.
Matrix4d omega(const Vector3d& m) {
  Matrix4d result;
  result << -hat(m), m, -m.transpose(), 0;
  return result;
}

/// (3.13): Θ(e).
Matrix4d theta(const Vector3d& e) {
  Matrix4d result;
  result << hat(e), e, -e.transpose(), 0;
  return result;
}

/// The same pairs with unit vectors and weights that sum to 1.
std::vector<VectorPair> normalized(const std::vector<VectorPair>& pairs) {
  std::vector<VectorPair> result;
  double sum = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const VectorPair& pair = pairs[i];
    if (!(pair.weight >= 0) || !std::isfinite(pair.weight))
      throw InvalidInput(concat("the weight of pair ", i + 1, " must be at least 0, got ", pair.weight));
    if (pair.weight == 0) continue;
    result.push_back({unit(pair.reference, "reference", i), unit(pair.measured, "measured", i), pair.weight});
    sum += pair.weight;
  }
  if (result.size() < 2)
    throw InvalidInput(concat("an orientation needs two vectors with a weight above 0, got ", result.size()));
  for (VectorPair& pair : result) pair.weight /= sum;
  return result;
}

Matrix3d solve_by_quaternion(const std::vector<VectorPair>& pairs) {
  Matrix4d K = Matrix4d::Zero();
  for (const VectorPair& pair : pairs) K -= pair.weight * omega(pair.measured) * theta(pair.reference);
  const Eigen::SelfAdjointEigenSolver<Matrix4d> eigen(K);  // eigenvalues sorted upwards
  const Eigen::Vector4d q = eigen.eigenvectors().col(3);
  // A(q) of (2.26) maps world to device. The ordinary rotation matrix of q is its transpose: X.
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
}

Matrix3d solve_by_svd(const Matrix3d& B) {
  // A = U diag(1, 1, det U det V) Vᵀ maximises trace(A Bᵀ); X = Aᵀ.
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d& U = svd.matrixU();
  const Matrix3d& V = svd.matrixV();
  const Vector3d signs(1, 1, U.determinant() * V.determinant() < 0 ? -1 : 1);
  return V * signs.asDiagonal() * U.transpose();
}

}  // namespace

Matrix3d solve_wahba(const std::vector<VectorPair>& pairs, WahbaMethod method) {
  const std::vector<VectorPair> unit_pairs = normalized(pairs);
  Matrix3d B = Matrix3d::Zero();  // attitude profile matrix, (3.3)
  for (const VectorPair& pair : unit_pairs) B += pair.weight * pair.measured * pair.reference.transpose();
  // The rotation is unique while σ₂ + det-sign · σ₃ is above 0 [markley1988].
  const Eigen::JacobiSVD<Matrix3d> singular(B);
  const Vector3d& sigma = singular.singularValues();
  if (!(sigma[1] + (B.determinant() < 0 ? -sigma[2] : sigma[2]) > kParallel))
    throw InvalidInput(
        "the measured vectors, or the reference vectors, are parallel, so the orientation is not determined; "
        "two different directions are needed");
  return method == WahbaMethod::Quaternion ? solve_by_quaternion(unit_pairs) : solve_by_svd(B);
}

double wahba_cost(const std::vector<VectorPair>& pairs, const Matrix3d& X) {
  double cost = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].weight == 0) continue;  // as in solve_wahba(): its vectors may be missing
    const Vector3d e = unit(pairs[i].reference, "reference", i);
    const Vector3d m = unit(pairs[i].measured, "measured", i);
    cost += pairs[i].weight * (m - X.transpose() * e).squaredNorm();
  }
  return cost;
}

}  // namespace batten
