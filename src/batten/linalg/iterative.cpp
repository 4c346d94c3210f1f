#include "batten/linalg/iterative.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/IterativeLinearSolvers>
#include <unsupported/Eigen/IterativeSolvers>

#include "batten/core/error.hpp"

namespace batten {

namespace {

int iteration_limit(const IterativeOptions& options, Eigen::Index unknowns) {
  return options.max_iterations > 0 ? options.max_iterations : static_cast<int>(2 * unknowns + 10);
}

template <typename Solver>
IterativeReport solve_columns(Solver& solver, const SparseMatrix& A, const Eigen::MatrixXd& B,
                              Eigen::MatrixXd& X, std::string_view system, const IterativeOptions& options) {
  solver.setTolerance(options.tolerance);
  solver.setMaxIterations(iteration_limit(options, A.cols()));
  solver.compute(A);
  if (solver.info() != Eigen::Success) throw SolverFailure(system, A.cols());
  IterativeReport report;
  report.converged = true;
  if (X.rows() != A.cols() || X.cols() != B.cols()) X = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    const double size = B.col(c).norm();
    X.col(c) = solver.solveWithGuess(B.col(c), X.col(c)).eval();
    if (!X.col(c).allFinite()) throw SolverFailure(system, A.cols());
    const double residual = size > 0 ? (B.col(c) - A * X.col(c)).norm() / size : 0;
    report.iterations = std::max(report.iterations, static_cast<int>(solver.iterations()));
    report.residual = std::max(report.residual, residual);
  }
  // The solvers stop on an estimate of the residual; the true one may be a little larger.
  report.converged = report.residual <= 10 * options.tolerance;
  return report;
}

}  // namespace

IterativeReport solve_conjugate_gradients(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                          std::string_view system, const IterativeOptions& options) {
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper, Eigen::IncompleteCholesky<double>>
      solver;
  return solve_columns(solver, A, B, X, system, options);
}

IterativeReport solve_gmres(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                            std::string_view system, const IterativeOptions& options) {
  Eigen::GMRES<SparseMatrix, Eigen::IncompleteLUT<double>> solver;
  solver.set_restart(50);
  return solve_columns(solver, A, B, X, system, options);
}

IterativeReport solve_lsqr(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                           std::string_view system, const IterativeOptions& options) {
  IterativeReport report;
  report.converged = true;
  if (X.rows() != A.cols() || X.cols() != B.cols()) X = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  const SparseMatrix At = A.transpose();
  const int limit = iteration_limit(options, A.cols());
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    Eigen::VectorXd x = X.col(c);
    Eigen::VectorXd u = B.col(c) - A * x;
    const double size = (At * B.col(c)).norm();
    double beta = u.norm();
    if (beta == 0 || size == 0) continue;
    u /= beta;
    Eigen::VectorXd v = At * u;
    double alpha = v.norm();
    if (alpha == 0) continue;
    v /= alpha;
    Eigen::VectorXd w = v;
    double phi_bar = beta, rho_bar = alpha;
    bool converged = false;
    int k = 0;
    for (; k < limit && !converged; ++k) {
      // Golub–Kahan bidiagonalisation, then one Givens rotation (Paige, Saunders 1982, section 4).
      u = A * v - alpha * u;
      beta = u.norm();
      if (beta > 0) u /= beta;
      v = At * u - beta * v;
      alpha = v.norm();
      if (alpha > 0) v /= alpha;
      const double rho = std::hypot(rho_bar, beta);
      const double cosine = rho_bar / rho, sine = beta / rho;
      const double theta = sine * alpha;
      rho_bar = -cosine * alpha;
      const double phi = cosine * phi_bar;
      phi_bar = sine * phi_bar;
      x += (phi / rho) * w;
      w = v - (theta / rho) * w;
      converged = phi_bar * alpha * std::abs(cosine) <= options.tolerance * size;  // ‖Aᵀr‖
    }
    if (!x.allFinite()) throw SolverFailure(system, A.cols());
    X.col(c) = x;
    report.iterations = std::max(report.iterations, k);
    report.residual = std::max(report.residual, (At * (B.col(c) - A * x)).norm() / size);
    report.converged = report.converged && converged;
  }
  return report;
}

}  // namespace batten
