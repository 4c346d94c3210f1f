#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/operators/laplacian.hpp"

// What the systems of deformation are made of. Private to the room.
namespace batten::detail {

/// Per vertex the lowest vertex of its connected part. @param n vertices of the mesh.
std::vector<int> connected_parts(const Triangles& triangles, Eigen::Index n);

/// Lengthens all edges by one small amount, such that no triangle is flatter than a hundredth of the mean
/// edge [sharp2020]: weights of degenerate triangles stay finite, those of good ones hardly change.
EdgeLengths mollified(EdgeLengths lengths);

/// Negative weights of obtuse pairs of triangles become 0; rows keep their sum of zero.
/// @param K a stiffness matrix: n × n, full, weights below zero off the diagonal.
void clamp_weights(SparseMatrix& K);

/// The stiffness matrix of ∇·(g ∇·): every edge weight of K times the mean of g (n) at its ends.
SparseMatrix weighted_stiffness(const SparseMatrix& K, const Eigen::VectorXd& g);

/// Rows and columns of a full symmetric matrix, with `lower` only the lower triangle of the result.
/// @param row_of, column_of per row of T where it comes to lie, or −1.
SparseMatrix part_of(const SparseMatrix& T, const std::vector<int>& row_of, const std::vector<int>& column_of,
                     Eigen::Index n_rows, Eigen::Index n_columns, bool lower);

}  // namespace batten::detail
