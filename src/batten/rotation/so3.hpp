#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace batten {

/// The matrix of the cross product: hat(a) b = a × b.
Eigen::Matrix3d hat(const Eigen::Vector3d& a);
/// Rotation by |a| radians about a (Rodrigues). Exact to rounding for every angle, 0 and π included.
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& a);
/// The rotation vector of R, of length at most π: so3_exp(so3_log(R)) = R. @pre R is a rotation.
Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);
/// Right Jacobian: so3_exp(a + d) ≈ so3_exp(a) so3_exp(J_r(a) d).
Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& a);
/// Its inverse: so3_log(so3_exp(a) so3_exp(d)) ≈ a + J_r⁻¹(a) d. @pre |a| < 2π.
Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& a);
/// The rotation nearest to A in the Frobenius norm. @pre A is not singular.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& A);

/// Darboux frame X = [t N B] with B = t × N, columns in world coordinates (docs/methods.md#conventions). Both
/// vectors need not be of unit length nor exactly orthogonal: N is kept in direction where `keep_normal`,
/// else t.
/// @throws InvalidInput when either vanishes or both are parallel.
Eigen::Matrix3d darboux_frame(const Eigen::Vector3d& tangent, const Eigen::Vector3d& normal,
                              bool keep_normal = true);

}  // namespace batten
