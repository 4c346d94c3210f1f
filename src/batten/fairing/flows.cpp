#include "batten/fairing/flows.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/neighbours_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/gradient.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/operators/shape_operator.hpp"

namespace batten {

namespace {

using Eigen::VectorXd;

double largest_row(const Points& rows) {
  return rows.rows() > 0 ? rows.rowwise().norm().maxCoeff() : 0;
}

double shortest_edge(const Points& positions, const Triangles& triangles) {
  double squared = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      squared = std::min(
          squared, (positions.row(triangles(f, k)) - positions.row(triangles(f, (k + 1) % 3))).squaredNorm());
  return std::sqrt(squared);
}

/// 1 / max Σ_j |A_ij| / M_i ≤ 1 / ‖M⁻¹A‖: half the stability bound of forward Euler (Gershgorin).
double stable_step(const SparseMatrix& A, const VectorXd& mass) {
  VectorXd sums = VectorXd::Zero(A.rows());
  for (Eigen::Index column = 0; column < A.cols(); ++column)
    for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry)
      sums[entry.row()] += std::abs(entry.value());
  const double largest = sums.cwiseQuotient(mass).maxCoeff();
  return largest > 0 ? 1 / largest : std::numeric_limits<double>::infinity();
}

SparseMatrix diagonal_matrix(const VectorXd& diagonal) {
  return SparseMatrix(diagonal.asDiagonal());
}

/// One system of a linear flow M ∂X/∂t = −A X + λ M (X0 − X).
struct LinearFlow {
  SparseMatrix A;  ///< symmetric positive semi-definite
  VectorXd mass;
  Points velocity;  ///< −M⁻¹ A X at the start of the step, for the rules of the step
  bool is_fourth_order = false;
  double largest_laplacian = 0;  ///< max‖ΔX‖ for (1.45) where the velocity is not ΔX itself; 0: it is
  Points projection;             ///< unit vectors along which alone vertices move; 0 × 3: anywhere
};

/// The loop shared by all flows of positions.
/// @param advance (X, vertices that stay, next): puts into `next`, which comes as X, where the step leads,
/// and returns its length; 0 ends the flow. What it says of vertices that stay is ignored.
Points run_steps(const Points& positions, const Triangles& triangles, const FlowOptions& options,
                 FlowReport* report, const Progress& progress,
                 const std::function<double(const Points&, const std::vector<char>&, Points&)>& advance) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const std::vector<char> fixed = fairing_detail::fixed_vertices(positions, triangles, options.keep_boundary);
  FlowReport own;
  FlowReport& told = report != nullptr ? *report : own;
  told = {};
  Points X = positions;
  if (triangles.rows() == 0) return X;
  for (int step = 0; step < options.steps; ++step) {
    progress.report("fairing", static_cast<double>(step) / options.steps);
    Points next = X;
    const double tau = advance(X, fixed, next);
    if (tau == 0) break;
    for (Eigen::Index v = 0; v < X.rows(); ++v)
      if (!fixed[v]) X.row(v) = next.row(v);
    if (!X.allFinite())
      throw SolverFailure("the flow, whose explicit steps are too long; shorten time_step,", X.rows());
    told.time_step = tau;
    told.steps = step + 1;
  }
  told.largest_move = largest_row(X - positions);
  return X;
}

/// All linear flows: backward or forward Euler with the thesis's steps.
Points run_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options,
                FlowReport* report, const Progress& progress,
                const std::function<LinearFlow(const Points&)>& build) {
  SparseCholesky solver("geometric flow step");
  const auto advance = [&](const Points& X, const std::vector<char>& fixed, Points& next) {
    const LinearFlow flow = build(X);
    double tau = options.time_step;
    if (tau == 0) {
      if (options.implicit) {
        const double edge = mean_edge_length(positions, triangles);
        const double fastest = std::max(largest_row(flow.velocity), flow.largest_laplacian);
        // Below rounding: nothing is left to smooth.
        if (!(fastest > 1e-12 * (flow.is_fourth_order ? 1 / (edge * edge * edge) : 1 / edge))) return 0.0;
        tau = edge / fastest;  // (1.45)
      } else {
        tau = stable_step(flow.A, flow.mass);
        if (!flow.is_fourth_order)
          tau = std::min(tau, 0.5 * std::pow(shortest_edge(X, triangles), 2));  // (1.44)
      }
    }
    if (options.implicit) {
      const SparseMatrix system = tau * flow.A + diagonal_matrix((1 + tau * options.fidelity) * flow.mass);
      const Points right = flow.mass.asDiagonal() * (X + tau * options.fidelity * positions);
      fairing_detail::solve_with_fixed(solver, system, right, fixed, next, progress);
    } else {
      next += tau * (flow.velocity + options.fidelity * (positions - X));
    }
    if (flow.projection.rows() > 0)
      for (Eigen::Index v = 0; v < X.rows(); ++v)
        next.row(v) =
            X.row(v) + (next.row(v) - X.row(v)).dot(flow.projection.row(v)) * flow.projection.row(v);
    return tau;
  };
  return run_steps(positions, triangles, options, report, progress, advance);
}

Points divided(const Points& rows, const VectorXd& by) {
  return by.cwiseInverse().asDiagonal() * rows;
}

}  // namespace

std::optional<std::string> FlowOptions::problem() const {
  if (!(time_step >= 0) || !std::isfinite(time_step))
    return concat("time_step must be finite and at least 0, got ", time_step);
  if (steps < 0) return concat("steps must be at least 0, got ", steps);
  if (!(fidelity >= 0) || !std::isfinite(fidelity))
    return concat("fidelity must be finite and at least 0, got ", fidelity);
  return std::nullopt;
}

std::optional<std::string> AnisotropicFlowOptions::problem() const {
  if (!(threshold >= 0)) return concat("threshold must be at least 0, got ", threshold);
  return FlowOptions::problem();
}

std::optional<std::string> NonlocalFlowOptions::problem() const {
  if (!(similarity > 0)) return concat("similarity must be above 0, got ", similarity);
  return FlowOptions::problem();
}

std::optional<std::string> TaubinOptions::problem() const {
  if (!(lambda > 0 && lambda <= 1)) return concat("lambda must lie in 0 to 1, got ", lambda);
  if (!(mu < -lambda && mu >= -2)) return concat("mu must lie in −2 to −lambda, got ", mu);
  if (steps < 0) return concat("steps must be at least 0, got ", steps);
  return std::nullopt;
}

double edge_stopping(double curvature, double threshold) {
  const double ratio = curvature / threshold;
  return 1 / (1 + ratio * ratio);
}

Points mean_curvature_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options,
                           FlowReport* report, const Progress& progress) {
  return run_flow(positions, triangles, options, report, progress, [&](const Points& X) {
    LinearFlow flow;
    flow.A = fairing_detail::bounded_stiffness(X, triangles);
    flow.mass = fairing_detail::bounded_mass(X, triangles);
    flow.velocity = -divided(flow.A * X, flow.mass);
    return flow;
  });
}

Points bilaplacian_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options,
                        FlowReport* report, const Progress& progress) {
  return run_flow(positions, triangles, options, report, progress, [&](const Points& X) {
    const SparseMatrix K = fairing_detail::bounded_stiffness(X, triangles);
    LinearFlow flow;
    flow.mass = fairing_detail::bounded_mass(X, triangles);
    flow.A = K * flow.mass.cwiseInverse().asDiagonal() * K;
    flow.velocity = -divided(flow.A * X, flow.mass);
    flow.is_fourth_order = true;
    return flow;
  });
}

Points anisotropic_flow(const Points& positions, const Triangles& triangles,
                        const AnisotropicFlowOptions& options, FlowReport* report, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const double edge = mean_edge_length(positions, triangles);
  const double threshold = options.threshold > 0 ? options.threshold : 1 / std::max(edge, 1e-300);
  return run_flow(positions, triangles, options, report, progress, [&](const Points& X) {
    LinearFlow flow;
    flow.A = fairing_detail::bounded_stiffness(X, triangles);
    flow.mass = fairing_detail::bounded_mass(X, triangles);
    const Points curvature = divided(flow.A * X, flow.mass);  // 2 H N
    flow.largest_laplacian = largest_row(curvature);
    // ∂X/∂t = f ΔX is M f⁻¹ ∂X/∂t = −K X: the diffusivity becomes a larger mass, and the system stays
    // symmetric.
    for (Eigen::Index v = 0; v < X.rows(); ++v)
      flow.mass[v] /= std::max(1e-6, edge_stopping(0.5 * curvature.row(v).norm(), threshold));
    flow.velocity = -divided(flow.A * X, flow.mass);
    return flow;
  });
}

/// ν times the mean edge, by default: bends of 17° an edge are half kept. Of 0.3, 1, 3 and 10 the one that
/// leaves the least noise on sharp and organic shapes (docs/methods.md#fairing); with 1 and ten steps it left
/// more than mean curvature flow.
constexpr double kTensorThreshold = 0.3;

Points anisotropic_tensor_flow(const Points& positions, const Triangles& triangles,
                               const AnisotropicFlowOptions& options, FlowReport* report,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const double edge = mean_edge_length(positions, triangles);
  const double threshold =
      options.threshold > 0 ? options.threshold : kTensorThreshold / std::max(edge, 1e-300);
  return run_flow(positions, triangles, options, report, progress, [&](const Points& X) {
    LinearFlow flow;
    flow.projection = vertex_normals(X, triangles);
    const FaceCurvatures curvatures = face_curvatures(X, triangles, flow.projection);
    const SparseMatrix G = face_gradient(X, triangles);
    std::vector<Eigen::Triplet<double>> blocks;
    blocks.reserve(9 * static_cast<std::size_t>(triangles.rows()));
    for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
      const Eigen::RowVector3d a = X.row(triangles(f, 0)), b = X.row(triangles(f, 1)),
                               c = X.row(triangles(f, 2));
      const double area = 0.5 * (b - a).cross(c - a).norm();
      const Eigen::Vector3d v1 = curvatures.first_direction.row(f), v2 = curvatures.second_direction.row(f);
      const Eigen::Matrix3d D = edge_stopping(curvatures.first[f], threshold) * v1 * v1.transpose() +
                                edge_stopping(curvatures.second[f], threshold) * v2 * v2.transpose();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) blocks.emplace_back(3 * f + i, 3 * f + j, area * D(i, j));
    }
    SparseMatrix D(3 * triangles.rows(), 3 * triangles.rows());
    D.setFromTriplets(blocks.begin(), blocks.end());
    flow.A = G.transpose() * D * G;
    flow.mass = fairing_detail::bounded_mass(X, triangles);
    flow.velocity = -divided(flow.A * X, flow.mass);
    return flow;
  });
}

Points elastica_flow(const Points& positions, const Triangles& triangles, const FlowOptions& options,
                     FlowReport* report, const Progress& progress) {
  SparseCholesky solver("elastica flow step");
  const auto advance = [&](const Points& X, const std::vector<char>& fixed, Points& next) {
    const Curvatures curvatures = discrete_curvatures(X, triangles);
    const SparseMatrix K = fairing_detail::bounded_stiffness(X, triangles);
    const VectorXd mass = fairing_detail::bounded_mass(X, triangles);
    const Points normals = vertex_normals(X, triangles);
    VectorXd H = curvatures.mean;
    for (Eigen::Index v = 0; v < X.rows(); ++v)
      if (curvatures.on_border[v]) H[v] = 0;  // no curvature there, see Curvatures
    VectorXd speed = -(K * H).cwiseQuotient(mass);
    for (Eigen::Index v = 0; v < X.rows(); ++v) {
      if (curvatures.on_border[v])
        speed[v] = 0;
      else
        speed[v] += 2 * H[v] * (H[v] * H[v] - curvatures.gaussian[v]);
    }
    const Points velocity = Points(speed.asDiagonal() * normals) + options.fidelity * (positions - X);
    const SparseMatrix bilaplacian = K * mass.cwiseInverse().asDiagonal() * K;
    double tau = options.time_step;
    if (tau == 0) {
      const double edge = mean_edge_length(positions, triangles), fastest = largest_row(velocity);
      if (!(fastest > 1e-12 / (edge * edge * edge))) return 0.0;
      tau = options.implicit ? edge / fastest : stable_step(bilaplacian, mass);
    }
    Points moves = tau * velocity;
    if (options.implicit) {
      // V N = −½ Δ²X + lower terms, and the pull −λX: both at the end of the step.
      const SparseMatrix system =
          0.5 * tau * bilaplacian + diagonal_matrix((1 + tau * options.fidelity) * mass);
      const Points right = mass.asDiagonal() * moves;
      moves.setZero();
      fairing_detail::solve_with_fixed(solver, system, right, fixed, moves, progress);
    }
    next += moves;
    return tau;
  };
  return run_steps(positions, triangles, options, report, progress, advance);
}

Points nonlocal_flow(const Points& positions, const Triangles& triangles, const NonlocalFlowOptions& options,
                     FlowReport* report, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return run_flow(positions, triangles, options, report, progress, [&](const Points& X) {
    const SparseMatrix K = fairing_detail::bounded_stiffness(X, triangles);
    LinearFlow flow;
    flow.mass = fairing_detail::bounded_mass(X, triangles);
    Points H = divided(K * X, flow.mass);
    const double largest = largest_row(H);
    if (largest > 0) H /= largest;
    flow.A = fairing_detail::similar_stiffness(K, H, options.similarity);
    flow.velocity = -divided(flow.A * X, flow.mass);
    return flow;
  });
}

Points taubin_smoothing(const Points& positions, const Triangles& triangles, const TaubinOptions& options,
                        const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const std::vector<char> fixed = fairing_detail::fixed_vertices(positions, triangles, options.keep_boundary);
  const fairing_detail::IndexLists neighbours =
      fairing_detail::vertex_neighbours(triangles, positions.rows());
  Points X = positions;
  for (int step = 0; step < options.steps; ++step) {
    progress.report("fairing", static_cast<double>(step) / options.steps);
    for (const double weight : {options.lambda, options.mu}) {
      const Points old = X;
      for (Eigen::Index v = 0; v < X.rows(); ++v) {
        if (fixed[v] || neighbours.size(v) == 0) continue;
        Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
        for (int i = neighbours.begin(v); i < neighbours.end(v); ++i) mean += old.row(neighbours.indices[i]);
        X.row(v) += weight * (mean / neighbours.size(v) - old.row(v));
      }
    }
  }
  return X;
}

}  // namespace batten
