#include "batten/rotation/so3.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Coefficients of Rodrigues' formula and its integrals: sin θ/θ, (1 − cos θ)/θ², (θ − sin θ)/θ³. Below the
/// limit the series is exact to rounding, where the closed forms lose digits.
struct SineRatios {
  double a, b, c;
};

SineRatios sine_ratios(double theta) {
  const double t2 = theta * theta;
  if (theta < 0.02)
    return {1 - t2 / 6 * (1 - t2 / 20 * (1 - t2 / 42)), 0.5 - t2 / 24 * (1 - t2 / 30 * (1 - t2 / 56)),
            1.0 / 6 - t2 / 120 * (1 - t2 / 42 * (1 - t2 / 72))};
  const double half = std::sin(0.5 * theta);
  return {std::sin(theta) / theta, 2 * half * half / t2, (theta - std::sin(theta)) / (t2 * theta)};
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d H;
  H << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return H;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& a) {
  const SineRatios k = sine_ratios(a.norm());
  const Eigen::Matrix3d A = hat(a);
  return Eigen::Matrix3d::Identity() + k.a * A + k.b * A * A;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  // By way of the quaternion: its largest component is never small, so that no angle loses digits.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double angle = 2 * std::atan2(sine, q.w());
  if (sine < 1e-8) return 2 * q.vec();
  return angle / sine * q.vec();
}

Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& a) {
  const SineRatios k = sine_ratios(a.norm());
  const Eigen::Matrix3d A = hat(a);
  return Eigen::Matrix3d::Identity() - k.b * A + k.c * A * A;
}

Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& a) {
  const double theta = a.norm(), t2 = theta * theta;
  // 1/θ² − (1 + cos θ)/(2 θ sin θ) = (1 − (θ/2) cot(θ/2))/θ²
  double k;
  if (theta < 0.05) {
    k = 1.0 / 12 + t2 / 720 * (1 + t2 / 42);
  } else {
    k = (1 - 0.5 * theta / std::tan(0.5 * theta)) / t2;
  }
  const Eigen::Matrix3d A = hat(a);
  return Eigen::Matrix3d::Identity() + 0.5 * A + k * A * A;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& A) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d& U = svd.matrixU();
  const Eigen::Matrix3d& V = svd.matrixV();
  const double sign = (U * V.transpose()).determinant() < 0 ? -1 : 1;
  return U * Eigen::Vector3d(1, 1, sign).asDiagonal() * V.transpose();
}

Eigen::Matrix3d darboux_frame(const Eigen::Vector3d& tangent, const Eigen::Vector3d& normal,
                              bool keep_normal) {
  // Below this sine of the angle between the two (about 0.006°) their order in the plane is rounding.
  constexpr double kSmallestSine = 1e-4;
  const double t_length = tangent.norm(), n_length = normal.norm();
  if (!(t_length > 0) || !std::isfinite(t_length)) throw InvalidInput("the tangent has no direction");
  if (!(n_length > 0) || !std::isfinite(n_length)) throw InvalidInput("the normal has no direction");
  const Eigen::Vector3d t = tangent / t_length, n = normal / n_length;
  const Eigen::Vector3d b = t.cross(n);
  if (b.norm() < kSmallestSine) throw InvalidInput("the tangent is parallel to the normal");
  Eigen::Matrix3d X;
  X.col(2) = b.normalized();
  if (keep_normal) {
    X.col(1) = n;
    X.col(0) = n.cross(X.col(2));
  } else {
    X.col(0) = t;
    X.col(1) = X.col(2).cross(t);
  }
  return X;
}

}  // namespace batten
