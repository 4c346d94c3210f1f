#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// How one step x_{k+1} − x_k follows from the frames at both its ends.
enum class StepRule {
  /// The frame turns at a constant rate between the samples; its tangent is integrated exactly (S 3.6,
  /// docs/errata.md#s-3-6). Second order, and exact on circles and helices.
  ConstantRate,
  /// h t_k, as (3.32) of the thesis amounts to where the data close. First order.
  Tangent,
};

/// What is least where the steps around the loops of the network do not close.
enum class ClosureForm {
  /// Σ ‖x_{k+1} − x_k − d_k‖²/h_k: every step of a segment gives way in proportion to its length. A weighted
  /// graph Laplacian over the nodes, then a closed form inside each segment: O(N).
  FirstDifference,
  /// S (3.32) and its end rows: Σ ‖e_k − e_{k−1}‖² with e_k = (x_{k+1} − x_k − d_k)/h_k, plus ‖e‖² of the
  /// first and the last step of open curves. Tangents turn gradually, and the length of a closed curve is
  /// free. O(N) in the samples; but a curve couples all its nodes with each other, so that large grids, with
  /// more than some fifty nodes on every curve, take the time of a dense system of their nodes.
  SecondDifference,
};

/// The step of length h between two frames (m, or whatever h is in).
/// ConstantRate: d = h X J e₁ with J = ∫₀¹ exp(u φ) du and exp(φ) = XᵀY.
Eigen::Vector3d frame_step(const Eigen::Matrix3d& X, const Eigen::Matrix3d& Y, double h, StepRule rule);

/// All steps of every curve: (n_samples − 1) × 3 each.
std::vector<Points> frame_steps(const SampledScan& scan, StepRule rule);

/// The same, with the rate of turn changing along each step as it does from step to step around it: fourth
/// order in the steps where the curves are smooth, StepRule::ConstantRate where they turn evenly.
std::vector<Points> fourth_order_steps(const SampledScan& scan);

/// Positions of all vertices, and how well the steps closed before they were made to.
struct IntegrationResult {
  Points positions;  ///< one row per vertex of number_vertices()
  /// Least value of Σ ‖m_s‖²/L_s over the placements of the nodes, m_s the misfit of segment s and L_s its
  /// length. Unit: length. 0 for networks without loops.
  double closure_energy = 0;
  /// Root mean square of the misfits ‖m_s‖ at that placement, in the unit of the scan.
  double closure_misfit = 0;
  int n_loops = 0;  ///< independent loops: what the misfit is measured on
};

/// Finds positions of all samples that follow the given steps, with the nodes as shared points. Vertex 0 lies
/// at the origin.
/// @param steps per curve, (n_samples − 1) × 3.
/// @throws InvalidInput when the curves are not connected, SolverFailure.
IntegrationResult integrate_steps(const SampledScan& scan, const std::vector<Points>& steps,
                                  ClosureForm form);

/// Plain sums along each curve from the first node already placed, misfits left where they fall: a preview
/// while the scan is still being recorded. Curves not connected to the first start at the origin.
std::vector<Points> integrate_preview(const SampledScan& scan, StepRule rule = StepRule::ConstantRate);

/// The size of a scan before positions are known (docs/methods.md#conventions): twice the greatest distance
/// of its points from their centroid after unfiltered integration.
double scan_size(const Points& positions);

}  // namespace batten
