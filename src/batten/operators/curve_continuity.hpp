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
  /// 2 to 20. Larger averages over noise of the mesh; the error of the normal grows with its third power
  /// where the surface is smooth. It is enlarged, to twice, where it holds too few vertices.
  double radius = 3;
  /// Most samples on one curve, at least 1; else one per mean edge of the mesh.
  int max_samples = 256;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How the two sides of a surface meet along one curve on it. Angles in radians; all figures are 0 where
/// nothing was measured.
struct CurveContinuity {
  int n_samples = 0;    ///< places that were measured on both sides
  int n_one_sided = 0;  ///< places on a border, with the surface on one side alone
  int n_unfitted = 0;   ///< places with too few vertices for a quadric on one side
  /// Distance between the quadrics of both sides, in the unit of the mesh (G0).
  double max_gap = 0, mean_gap = 0;
  /// Angle between their normals, 0 … π (G1): 0 where the surface is smooth, π/2 at the edge of a cube.
  double max_normal_jump = 0, mean_normal_jump = 0;
  /// |κ_left − κ_right| of the normal curvatures across the curve, 1/unit (G2).
  double max_curvature_jump = 0, mean_curvature_jump = 0;
  /// Distance of the curve from the mesh.
  double max_distance = 0, mean_distance = 0;
  Eigen::Vector3d worst = Eigen::Vector3d::Zero();  ///< where the normal jump is largest
};

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
/// @return one entry per curve.
/// @throws InvalidInput without triangles, on a curve with fewer than two points or coordinates that are not
/// finite, naming it, and on bad options; Cancelled.
std::vector<CurveContinuity> curve_continuity(const Points& positions, const Triangles& triangles,
                                              const std::vector<Points>& curves,
                                              const ContinuityOptions& options = {},
                                              const Progress& progress = {});

/// The figures of several curves as one: the largest of the largest, means over all samples.
CurveContinuity joint_continuity(const std::vector<CurveContinuity>& curves);

}  // namespace batten
