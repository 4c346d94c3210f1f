#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/mesh/registration.hpp"
#include "batten/mesh/shape.hpp"

namespace batten {

/// Largest, mean and root mean square of a set of distances; zeros without any.
struct DistanceFigures {
  double max = 0, mean = 0, rms = 0;
  Eigen::Index count = 0;
};
/// The figures of distances, none below 0.
DistanceFigures distance_figures(const Eigen::VectorXd& distances);

/// How compare() measures.
struct CompareOptions {
  RegistrationKind registration = RegistrationKind::None;
  Eigen::Index samples = 200000;              ///< per direction, uniform by area or length
  Eigen::Index registration_samples = 20000;  ///< points that the registration matches
  std::uint64_t seed = 1;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Distances from one shape to the other: (2.101) of H, and over either set of points (2.102-2.104).
struct DirectedComparison {
  DistanceFigures vertices;  ///< over the vertices in use, as H has it
  DistanceFigures samples;   ///< over the uniform samples: independent of the density of the vertices
  /// Per vertex of the shape that is measured, in the unit of B; NaN where no element uses the vertex.
  Eigen::VectorXd vertex_distances;
  /// Angles in [0, π] between the normal of the face of each sample and that of the face on which its nearest
  /// point lies. Weighted by area, as the samples are. Without samples (`count` 0) unless both are surfaces.
  DistanceFigures normal_angles;
};

/// Distances in both directions. Lengths in the unit of B.
struct Comparison {
  Registration registration;  ///< applied to A before measuring
  DirectedComparison a_to_b, b_to_a;
  double diameter = 0;  ///< of B: the diagonal of its bounding box, to divide by
};

/// Exact distances between two shapes (surfaces or curves, in any mix), in both directions: from every vertex
/// and sample to the nearest point of any triangle or segment of the other.
/// @throws InvalidInput when a shape is empty or B is a single point; Cancelled.
Comparison compare(const Shape& a, const Shape& b, const CompareOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
