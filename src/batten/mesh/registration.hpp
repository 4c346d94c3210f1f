#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/mesh/shape.hpp"

namespace batten {

/// p ↦ scale · rotation · p + translation, with a proper rotation.
struct SimilarityTransform {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  /// A point, or each row of `points`, transformed.
  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const { return scale * (rotation * p) + translation; }
  Points operator()(const Points& points) const;
  /// The normals of a transformed shape: rotated only.
  Points rotated(const Points& vectors) const { return vectors * rotation.transpose(); }
  SimilarityTransform inverse() const;
  /// First `other`, then this.
  SimilarityTransform operator*(const SimilarityTransform& other) const;
  /// Angle of the rotation in radians, 0 … π.
  double angle() const;
};

/// What a registration may change.
enum class RegistrationKind { None, Rigid, Similarity };

constexpr auto choices_of(RegistrationKind) {
  return choices<RegistrationKind>("registration", {{RegistrationKind::None, "none"},
                                                    {RegistrationKind::Rigid, "rigid"},
                                                    {RegistrationKind::Similarity, "similarity"}});
}

/// The transform that takes the rows of `from` closest to those of `to` in the least-squares sense
/// ([umeyama1991], by a singular value decomposition; reflections are excluded).
/// @param weights one per pair, not negative; empty for equal weights.
/// @throws InvalidInput when the numbers of points differ, a number is not finite, or the points lie on one
/// line, so that the rotation about it is not determined.
SimilarityTransform fit_transform(const Points& from, const Points& to, RegistrationKind kind,
                                  const Eigen::VectorXd& weights = {});

/// How a registration searches.
struct RegistrationOptions {
  RegistrationKind kind = RegistrationKind::Rigid;
  Eigen::Index samples = 20000;  ///< points that are matched, uniform by area or length
  std::uint64_t seed = 1;
  int max_iterations = 200;  ///< of the refinement
  /// Stop when no sample moves by more than this fraction of the diameter, or when five steps in a row each
  /// lower the mean square by less than 1e-7 of itself.
  double tolerance = 1e-10;
  double trim = 0;  ///< share of the furthest pairs that is left out, [0, 0.9]

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How a registration ended.
struct Registration {
  SimilarityTransform transform;  ///< of the moving shape
  double rms = 0;                 ///< of the matched samples, in the unit of `fixed`
  int iterations = 0;
  bool converged = false;  ///< false: stopped at max_iterations
};

/// Moves one shape onto another so that the mean squared distance of its samples to the other is least:
/// iterated closest points [besl1992] from the alignment of the centroids, with several starts (as it
/// lies, and the 24 ways to lay the principal axes upon each other) refined by Gauss–Newton on the distances
/// to tangent planes and tangent lines [chen1992]. Where a surface is moved onto curves, the curves
/// are matched to the surface instead and the result is inverted.
/// Symmetric shapes have several answers; the start "as it lies" wins unless another is better by 0.1 %.
/// @throws InvalidInput when a shape is empty, its points lie on one line, or the scale runs away; Cancelled.
Registration register_shapes(const Shape& moving, const Shape& fixed, const RegistrationOptions& options = {},
                             const Progress& progress = {});

}  // namespace batten
