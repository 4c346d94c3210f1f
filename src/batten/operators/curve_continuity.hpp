#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Options of curve_continuity().
struct ContinuityOptions {
  /// Radius of the neighbourhood that a quadric is fitted to, in mean lengths of the edges around the sample,
  /// 1.5 to 20. Larger averages over noise of the mesh; the error of the normal grows with its third power
  /// where the surface is smooth. It is enlarged, to twice, where it holds too few vertices.
  double radius = 2;
  /// Most samples on one curve, at least 1; else one per mean edge of the mesh.
  int max_samples = 256;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How the two sides of a surface meet at one place of a curve on it. Angles in radians.
struct ContinuitySample {
  enum class State {
    Measured,
    OneSided,  ///< on a border, with the surface on one side alone
    Unfitted,  ///< too few vertices for a quadric on one side
  };
  State state = State::Unfitted;
  double arc = 0;                                   ///< from the start of the curve
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< of the surface
  double distance = 0;                              ///< of the curve from the surface
  // Where it was measured:
  double gap = 0;  ///< distance between the quadrics of both sides, in the unit of the mesh (G0)
  /// Angle between their normals, 0 … π (G1): 0 where the surface is smooth, π/2 at the edge of a cube.
  double normal_jump = 0;
  double curvature_jump = 0;  ///< |κ_left − κ_right| of the normal curvatures across the curve (G2)
  double curvature = 0;       ///< the larger of |κ_left| and |κ_right|
};

/// The samples of a curve in figures, 0 where nothing was measured.
struct CurveContinuity {
  int n_samples = 0;  ///< measured ones
  int n_one_sided = 0, n_unfitted = 0;
  double max_gap = 0, mean_gap = 0;
  double max_normal_jump = 0, mean_normal_jump = 0;
  double max_curvature_jump = 0, mean_curvature_jump = 0;
  double max_distance = 0, mean_distance = 0;       ///< over all samples
  Eigen::Vector3d worst = Eigen::Vector3d::Zero();  ///< where the normal jump is largest
};
/// The figures of the samples of one curve.
CurveContinuity continuity_figures(const std::vector<ContinuitySample>& samples);

/// Measures how continuous a surface is across curves drawn on it, from quadrics fitted on each side
/// separately. At even samples of each curve the vertices on either side of it within the radius, up to any
/// curve of the list, are written as heights z over the tangent plane of their side, and
///   z = a + b u + c v + ½ (d u² + 2 e u v + f v²)
/// is fitted by least squares with weights that fall to nothing at the radius; the plane follows the normal
/// found, three times. On a smooth surface the measured jump of the normal tends to 0 with the third power of
/// the length of the edges, that of the curvature with the first: cubic terms turn the normals of both sides
/// alike and their curvatures against each other.
/// @param positions, triangles an oriented surface; it may have borders and several components.
/// @param curves polylines on the surface or close to it, k × 3 with k ≥ 2; a closed one repeats its first
/// point. Best it runs along edges of the mesh: a side that has vertices of the other would see its crease.
/// @return per curve its samples, in order.
/// @throws InvalidInput without triangles, on a curve with fewer than two points or coordinates that are not
/// finite, naming it, and on bad options; Cancelled.
std::vector<std::vector<ContinuitySample>> curve_continuity(const Points& positions,
                                                            const Triangles& triangles,
                                                            const std::vector<Points>& curves,
                                                            const ContinuityOptions& options = {},
                                                            const Progress& progress = {});

}  // namespace batten
