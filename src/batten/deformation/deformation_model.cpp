#include <algorithm>

#include "batten/deformation/deformation_matrices_detail.hpp"
#include "batten/deformation/deformation_model_detail.hpp"
#include "batten/deformation/local_rotations.hpp"
#include "batten/operators/curvature.hpp"

namespace batten::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

DeformationModel::DeformationModel(const Points& rest, const Triangles& triangles,
                                   const DeformOptions& options, double diameter)
    : rest_(rest), detail_weight_(options.detail_weight) {
  const Eigen::Index n = rest.rows();
  const EdgeLengths lengths = mollified(edge_lengths(rest, triangles));
  K_ = cotangent_stiffness(triangles, lengths, n);
  // Rotations are fitted with weights of at least 0; the energies that follow them must have the same, or the
  // alternation need not descend.
  if (options.detail != DetailPreservation::None) clamp_weights(K_);
  const Eigen::VectorXd mass = lumped_mass(triangles, lengths, n);
  // The mass of a vertex whose triangles have no area is bounded, so that its row stays finite.
  const double least = 1e-8 * mass.sum() / static_cast<double>(std::max<Eigen::Index>(n, 1));
  inverse_mass_ = mass.cwiseMax(least > 0 ? least : 1.0).cwiseInverse();
  rest_vectors_ = K_ * rest;
  set_second_order(options, diameter);
}

void DeformationModel::set_second_order(const DeformOptions& options, double diameter) {
  const bool gauss_newton = options.detail == DetailPreservation::GaussNewton;
  bending_ = options.energy == DeformationEnergy::Stretch ? 0 : 1;
  // GaussNewton adds λ_2 times the bending energy (2.67) to the matrix; Stretch has none to compare it with
  // and takes it at the size of the mesh.
  followed_detail_ = gauss_newton ? options.detail_weight : 0;
  const double bending_length = options.bending_length * diameter;
  if (options.energy == DeformationEnergy::Stretch) {
    second_order_ = K_;
    if (gauss_newton && bending_length > 0) second_order_ /= bending_length * bending_length;
  }
  if (options.energy == DeformationEnergy::Combined && bending_length > 0)
    second_order_ = K_ / (bending_length * bending_length);
  if (gauss_newton && options.membrane_length > 0 && diameter > 0) {
    const double length = options.membrane_length * diameter;
    membrane_ = K_ * (followed_detail_ / (length * length));
  }
}

SparseMatrix DeformationModel::second_order() const {
  if (membrane_.nonZeros() == 0) return second_order_;
  return second_order_.nonZeros() > 0 ? SparseMatrix(second_order_ + membrane_) : membrane_;
}

SparseMatrix DeformationModel::curvature_stiffness(const Triangles& triangles) const {
  const Curvatures curvatures = discrete_curvatures(rest_, triangles);
  Eigen::VectorXd G = Eigen::VectorXd::Zero(rest_.rows());
  for (Eigen::Index v = 0; v < rest_.rows(); ++v)
    if (!curvatures.on_border[v])
      G[v] = std::max(0.0, curvatures.mean[v] * curvatures.mean[v] - curvatures.gaussian[v]);
  return weighted_stiffness(K_, G);
}

void DeformationModel::set_curvature_term(double c, const SparseMatrix& curvature) {
  second_order_ = c == 0 ? SparseMatrix(rest_.rows(), rest_.rows()) : SparseMatrix(-2 * c * curvature);
}

void DeformationModel::follow_normals(const Triangles& triangles, const std::vector<char>& used) {
  dual_ = std::make_unique<DualLaplacian>(rest_, triangles, rest_vectors_);
  for (Eigen::Index v = 0; v < rest_.rows(); ++v)
    if (!dual_->followed()[v] && used[v]) not_followed_.push_back(static_cast<int>(v));
}

Points DeformationModel::apply_bending(const Points& vectors) const {
  return K_ * (inverse_mass_.asDiagonal() * vectors).eval();
}

Points DeformationModel::turned_edges(const SparseMatrix& T, const std::vector<Matrix3d>& rotations) const {
  Points B(rest_.rows(), 3);
  for (Eigen::Index i = 0; i < rest_.rows(); ++i) {
    Vector3d sum = Vector3d::Zero();
    for (SparseMatrix::InnerIterator entry(T, i); entry; ++entry) {
      const Eigen::Index j = entry.row();
      const Vector3d edge = rest_.row(i) - rest_.row(j);
      sum -= 0.5 * entry.value() * ((rotations[i] + rotations[j]) * edge);
    }
    B.row(i) = sum;
  }
  return B;
}

Points DeformationModel::turned_rest(const std::vector<Matrix3d>& rotations) const {
  Points B = Points::Zero(rest_.rows(), 3);
  if (bending_ > 0) {
    Points turned(rest_.rows(), 3);
    for (Eigen::Index i = 0; i < rest_.rows(); ++i)
      turned.row(i) = rest_vectors_.row(i) * rotations[i].transpose();
    B = bending_ * apply_bending(turned);
  }
  if (second_order_.nonZeros() > 0) B += turned_edges(second_order_, rotations);
  return B;
}

Points DeformationModel::detail_forces(const Points& deformed, std::vector<Matrix3d>& rotations) const {
  Points vectors;
  dual_->evaluate(deformed, vectors);
  if (membrane_.nonZeros() > 0) fit_local_rotations(K_, rest_, deformed, rotations);
  if (rotations.empty()) rotations.assign(rest_.rows(), Matrix3d::Identity());
  for (const int i : not_followed_) {
    // Vectors that the face normals cannot carry (in the surface, on borders) turn with their one-ring.
    if (membrane_.nonZeros() == 0)
      rotations[i] = nearest_rotation(one_ring_covariance(K_, rest_, deformed, i), rotations[i]);
    vectors.row(i) = rest_vectors_.row(i) * rotations[i].transpose();
  }
  Points B = detail_weight_ * apply_bending(vectors);
  if (membrane_.nonZeros() > 0) B += turned_edges(membrane_, rotations);
  return B;
}

Points DeformationModel::displacement_forces() const {
  Points B = Points::Zero(rest_.rows(), 3);
  if (bending_ > 0) B = bending_ * apply_bending(rest_vectors_);
  if (second_order_.nonZeros() > 0) B += second_order_ * rest_;
  return B;
}

}  // namespace batten::detail
