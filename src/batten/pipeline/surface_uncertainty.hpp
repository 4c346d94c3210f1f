#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/scan/uncertainty.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {

/// Standard deviations of a surface across itself, per vertex, in its unit.
struct SurfaceUncertainty {
  Eigen::VectorXd deviations;      ///< both parts below together
  Eigen::VectorXd from_curves;     ///< what is not known of the curves
  Eigen::VectorXd between_curves;  ///< what the curves do not tell of the surface between them
};

/// How far the surface of a network may lie from the truth.
///
/// from_curves: every draw of the network goes through the linear solve of the surface
/// (SurfaceSolver::move(), positions and normals), and the moves across the surface are averaged. Without
/// draws the deviations of the network are spread harmonically, as if neighbouring curves were wrong alike.
/// between_curves: c κ' u^(3/2) + c₀ κ u with −Δu = 1 between the curves, u = 0 on them (half the square of
/// the distance, about, near a curve; a strip of width w has w²/8 in its middle), κ' the root mean square
/// change of the normal curvature along the curves per length, over a tenth of the diameter, κ that of the
/// curvature itself; c and c₀ from surfaces that are known (docs/methods.md#uncertainty).
/// @param solver of `network`; left as it was built. @param of_network deviations (and draws) of the same
/// vertices. @throws InvalidInput on other sizes, SolverFailure, Cancelled.
SurfaceUncertainty surface_uncertainty(SurfaceSolver& solver, const CurveNetwork& network,
                                       const NetworkUncertainty& of_network, const Progress& progress = {});

/// How curved the curves of a network are, and how fast that changes along them.
struct CurvatureChange {
  double curvature = 0;  ///< root mean square of the normal curvature along the curves, 1/length
  double change = 0;     ///< root mean square of its change per length, 1/length²
};
/// Of the curves of a network with normals.
CurvatureChange curvature_change(const CurveNetwork& network);

/// The part between the curves for a mesh some of whose vertices lie on curves, 0 at those.
/// @param on_curves per vertex, not 0: on a curve. One factorisation.
Eigen::VectorXd deviation_between_curves(const TriangleMesh& mesh, const std::vector<char>& on_curves,
                                         const CurvatureChange& curvature);

}  // namespace batten
