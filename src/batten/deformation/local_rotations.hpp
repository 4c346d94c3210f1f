#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// The rotation R that maximises trace(Rᵀ C), C = Σ w y xᵀ: the best rigid fit of the vectors x to the
/// vectors y (shape matching, Procrustes). det R = +1 also where C mirrors.
/// @param start a rotation near the answer; the nearer, the faster [mueller2016].
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& C,
                                 const Eigen::Matrix3d& start = Eigen::Matrix3d::Identity());

/// C = Σ_j w_ij y_ij x_ijᵀ over the edges of the one-ring of vertex i, x at rest and y deformed, with the
/// cotangent weights w of `stiffness`; negative ones count as zero.
Eigen::Matrix3d one_ring_covariance(const SparseMatrix& stiffness, const Points& rest, const Points& deformed,
                                    Eigen::Index i);

/// Shape matching in every one-ring (H 2.3.3, step 1): the rotations that turn the edges of the rest shape
/// into those of the deformed one: nearest_rotation() of one_ring_covariance(), on all processors.
/// @param rotations one per vertex; a start on entry, or empty.
void fit_local_rotations(const SparseMatrix& stiffness, const Points& rest, const Points& deformed,
                         std::vector<Eigen::Matrix3d>& rotations);

}  // namespace batten
