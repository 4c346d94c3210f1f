#include "batten/fairing/total_variation.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/operators/gradient.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Frobenius norms of the 3 × c blocks, one per triangle.
VectorXd block_norms(const MatrixXd& blocks) {
  VectorXd norms(blocks.rows() / 3);
  for (Eigen::Index f = 0; f < norms.size(); ++f) norms[f] = blocks.middleRows(3 * f, 3).norm();
  return norms;
}

/// The operators of one mesh, and Chambolle's iteration on them.
class Chambolle {
 public:
  Chambolle(const Points& positions, const Triangles& triangles)
      : gradient_(face_gradient(positions, triangles)),
        divergence_(face_divergence(positions, triangles)),
        mass_(fairing_detail::bounded_mass(positions, triangles)),
        areas_(face_areas(positions, triangles)) {
    // ‖div‖² is the largest eigenvalue of M⁻¹K: at most its largest row sum of absolute values.
    const SparseMatrix K = cotangent_stiffness(positions, triangles);
    VectorXd sums = VectorXd::Zero(K.rows());
    for (Eigen::Index column = 0; column < K.cols(); ++column)
      for (SparseMatrix::InnerIterator entry(K, column); entry; ++entry)
        sums[entry.row()] += std::abs(entry.value());
    const double bound = K.rows() > 0 ? sums.cwiseQuotient(mass_).maxCoeff() : 0;
    step_ = bound > 0 ? 1 / bound : 0;
  }

  /// `iterations` further steps from V (3m × c, updated), for the data f; returns φ.
  MatrixXd solve(const MatrixXd& f, double weight, int iterations, MatrixXd& V) const {
    for (int i = 0; i < iterations; ++i) {
      const MatrixXd ascent = gradient_ * (divergence(V) - weight * f);
      const VectorXd norms = block_norms(ascent);
      V += step_ * ascent;
      for (Eigen::Index face = 0; face < norms.size(); ++face)
        V.middleRows(3 * face, 3) /= 1 + step_ * norms[face];
    }
    return f - divergence(V) / weight;
  }

  MatrixXd divergence(const MatrixXd& V) const {
    return mass_.cwiseInverse().asDiagonal() * (divergence_ * V);
  }
  double variation(const MatrixXd& field) const { return areas_.dot(block_norms(gradient_ * field)); }
  double squared(const MatrixXd& field) const { return mass_.dot(field.rowwise().squaredNorm()); }
  double absolute(const MatrixXd& field) const { return mass_.dot(field.rowwise().norm()); }

 private:
  SparseMatrix gradient_, divergence_;
  VectorXd mass_, areas_;
  double step_ = 0;
};

}  // namespace

std::optional<std::string> TotalVariationOptions::problem() const {
  if (!(fit_weight > 0) || !std::isfinite(fit_weight))
    return concat("fit_weight must be finite and above 0, got ", fit_weight);
  if (iterations < 1) return concat("iterations must be at least 1, got ", iterations);
  return std::nullopt;
}

double total_variation(const Points& positions, const Triangles& triangles, const Eigen::MatrixXd& field) {
  return face_areas(positions, triangles).dot(block_norms(face_gradient(positions, triangles) * field));
}

Eigen::MatrixXd denoise_total_variation(const Points& positions, const Triangles& triangles,
                                        const Eigen::MatrixXd& field, const TotalVariationOptions& options,
                                        TotalVariationReport* report, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (field.rows() != positions.rows() || !field.allFinite())
    throw InvalidInput(concat("the field must hold a finite value for each of the ", positions.rows(),
                              " vertices, got ", field.rows(), " rows"));
  fairing_detail::fixed_vertices(positions, triangles, false);
  const Chambolle chambolle(positions, triangles);
  const double mu = options.fit_weight;
  MatrixXd V = MatrixXd::Zero(3 * triangles.rows(), field.cols());
  MatrixXd result = field;
  TotalVariationReport told;
  if (options.fit == TotalVariationFit::L2) {
    constexpr int kChunk = 10;
    for (int i = 0; i < options.iterations; i += kChunk) {
      progress.report("total variation", static_cast<double>(i) / options.iterations);
      result = chambolle.solve(field, mu, std::min(kChunk, options.iterations - i), V);
    }
    told.energy = chambolle.variation(result) + 0.5 * mu * chambolle.squared(result - field);
    // The dual value of a feasible V: ½μ‖f‖² − ½/μ ‖μf − div V‖².
    const double dual = 0.5 * mu * chambolle.squared(field) -
                        0.5 / mu * chambolle.squared(mu * field - chambolle.divergence(V));
    told.gap = told.energy - dual;
  } else {
    // TV(u) + ‖u + w − f‖²/(2θ) + μ|w|, u and w in turn; θ small against the range of the field.
    const double spread = std::sqrt(chambolle.squared(field.rowwise() - field.colwise().mean()) /
                                    std::max(chambolle.squared(MatrixXd::Ones(field.rows(), 1)), 1e-300));
    const double theta = std::max(spread, 1e-300) / mu * 0.05;
    MatrixXd outliers = MatrixXd::Zero(field.rows(), field.cols());
    for (int i = 0; i < options.iterations; ++i) {
      progress.report("total variation", static_cast<double>(i) / options.iterations);
      result = chambolle.solve(field - outliers, 1 / theta, 5, V);
      const MatrixXd rest = field - result;
      for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        const double length = rest.row(v).norm();
        outliers.row(v) = length > theta * mu ? (1 - theta * mu / length) * rest.row(v) : 0 * rest.row(v);
      }
    }
    told.energy = chambolle.variation(result) + mu * chambolle.absolute(result - field);
  }
  if (report != nullptr) *report = told;
  return result;
}

}  // namespace batten
