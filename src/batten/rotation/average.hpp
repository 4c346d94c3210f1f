#pragma once
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace batten {

/// The weighted average of orientations: minimises Σ αᵢ ‖A − Aᵢ‖²_F over rotations (S 3.15), as the dominant
/// eigenvector of Σ αᵢ qᵢ qᵢᵀ (S 3.20–3.21; [markley2007]). The signs of the quaternions do not matter.
/// @param weights as many as rotations, none negative, not all zero; empty stands for equal weights.
/// @throws InvalidInput without rotations, with a negative or not finite weight, or when all weights vanish.
Eigen::Quaterniond rotation_average(const std::vector<Eigen::Quaterniond>& rotations,
                                    const std::vector<double>& weights = {});
Eigen::Matrix3d rotation_average(const std::vector<Eigen::Matrix3d>& rotations,
                                 const std::vector<double>& weights = {});

/// The average frame with its normal drawn towards a given one (S appendix B): maximises
/// (1 − w) trace(A Bᵀ) + w ⟨N, N̂⟩ with B = Σ αᵢ Aᵢ / Σ αᵢ and N the second column of A, by the dominant
/// eigenvector of K̂ = (1 − w) K + w Σ N̂_j K_j. w = 0 is rotation_average(); as w → 1 the normal becomes N̂
/// and the tangent is the average turned about it.
/// @param normal N̂, of any length but zero.  @param w in [0, 1).
/// @throws InvalidInput as above, when w is out of range, or when the normal vanishes.
Eigen::Matrix3d rotation_average_with_normal(const std::vector<Eigen::Matrix3d>& rotations,
                                             const std::vector<double>& weights,
                                             const Eigen::Vector3d& normal, double w);

}  // namespace batten
