#pragma once
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace batten {

/// One vector known in two frames: e in the world, m as the device measures it.
struct VectorPair {
  Eigen::Vector3d reference;  ///< in world coordinates, any length but zero
  Eigen::Vector3d measured;   ///< in device coordinates, any length but zero
  double weight = 1;  ///< α, at least 0; at 0 the pair does not count and its vectors may be anything
};

/// Which algorithm solves Wahba's problem. Both give the same rotation to rounding.
enum class WahbaMethod {
  Quaternion,  ///< Davenport's q method (S 3.6–3.13): dominant eigenvector of a 4 × 4 matrix
  Svd,         ///< singular value decomposition of B [markley1988]; S 5.2.1 uses it
};

/// The orientation of a device from vectors that it measures (Wahba's problem [wahba1965], S 3.1).
///
/// Minimises Σ αᵢ ‖mᵢ − Xᵀ eᵢ‖² over rotations X with both vectors scaled to length 1. X maps device to world
/// coordinates; Wahba's A of (3.1) is Xᵀ (docs/methods.md#conventions).
/// @throws InvalidInput with fewer than two pairs of positive weight, with a vanishing or not finite vector
/// among them, or where the rotation is not determined: the directions of one side are all parallel, or both
/// sides are mirror images with σ₂ = σ₃ for the singular values of B = Σ αᵢ mᵢ eᵢᵀ [markley1988].
Eigen::Matrix3d solve_wahba(const std::vector<VectorPair>& pairs,
                            WahbaMethod method = WahbaMethod::Quaternion);

/// The cost Σ αᵢ ‖mᵢ − Xᵀ eᵢ‖² of (3.1), both vectors scaled to length 1.
double wahba_cost(const std::vector<VectorPair>& pairs, const Eigen::Matrix3d& X);

}  // namespace batten
