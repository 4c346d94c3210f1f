#include "batten/linalg/iterative.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/IterativeLinearSolvers>
#include <unsupported/Eigen/IterativeSolvers>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

void check_iterations(const IterativeOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
}

int iteration_limit(const IterativeOptions& options, Eigen::Index unknowns) {
  return options.max_iterations > 0 ? options.max_iterations : static_cast<int>(2 * unknowns + 10);
}

template <typename Solver>
IterativeReport solve_columns(Solver& solver, const SparseMatrix& A, const Eigen::MatrixXd& B,
                              Eigen::MatrixXd& X, std::string_view system, const IterativeOptions& options,
                              bool measures_from_start = false) {
  solver.setTolerance(options.tolerance);
  solver.setMaxIterations(iteration_limit(options, A.cols()));
  solver.compute(A);
  if (solver.info() != Eigen::Success) throw SolverFailure(system, A.cols());
  IterativeReport report;
  report.converged = true;
  if (X.rows() != A.cols() || X.cols() != B.cols()) X = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    const double size = B.col(c).norm();
    // Eigen's GMRES stops at a fraction of the residual at the start: from a good start it would look for
    // digits that are not there, and from the solution it reports as many iterations as it may take.
    if (measures_from_start) {
      const double start = (B.col(c) - A * X.col(c)).norm();
      if (start <= options.tolerance * size) {
        report.residual = std::max(report.residual, size > 0 ? start / size : 0);
        continue;
      }
      solver.setTolerance(std::min(0.5, options.tolerance * size / start));
    }
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

/// Entries per chunk of vectors: some 20 µs of work.
constexpr Eigen::Index kGrain = 8192;

double dot(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  return parallel_sum(x.size(), kGrain, [&](Eigen::Index begin, Eigen::Index end) {
    return x.segment(begin, end - begin).dot(y.segment(begin, end - begin));
  });
}

/// Conjugate gradients with a diagonal preconditioner, column by column.
IterativeReport solve_with_diagonal(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                    std::string_view system, const IterativeOptions& options,
                                    const Progress& progress) {
  if (X.rows() != A.cols() || X.cols() != B.cols()) X = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  const LinearOperator product = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    parallel_for(A.cols(), kGrain / 8, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) {  // column i is row i
        double sum = 0;
        for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) sum += entry.value() * x[entry.row()];
        y[i] = sum;
      }
    });
  };
  const Eigen::VectorXd diagonal = A.diagonal();
  IterativeReport worst;
  worst.converged = true;
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    Eigen::VectorXd x = X.col(c);
    const IterativeReport report =
        solve_conjugate_gradients(product, diagonal, B.col(c), x, system, options, progress);
    X.col(c) = x;
    worst.iterations = std::max(worst.iterations, report.iterations);
    worst.residual = std::max(worst.residual, report.residual);
    worst.converged = worst.converged && report.converged;
  }
  return worst;
}

}  // namespace

std::optional<std::string> IterativeOptions::problem() const {
  if (!(tolerance > 0 && tolerance < 1)) return concat("tolerance must be in (0, 1), got ", tolerance);
  if (max_iterations < 0) return concat("max_iterations must be at least 0, got ", max_iterations);
  return std::nullopt;
}

IterativeReport solve_conjugate_gradients(const LinearOperator& A, const Eigen::VectorXd& diagonal,
                                          const Eigen::VectorXd& b, Eigen::VectorXd& x,
                                          std::string_view system, const IterativeOptions& options,
                                          const Progress& progress) {
  check_iterations(options);
  const Eigen::Index n = b.size();
  if (diagonal.size() != n || !((diagonal.array() > 0).all())) throw SolverFailure(system, n);
  if (x.size() != n) x = Eigen::VectorXd::Zero(n);
  const double size = b.dot(b.cwiseQuotient(diagonal));
  IterativeReport report;
  if (!(size > 0)) {
    if (size != 0) throw SolverFailure(system, n);
    x.setZero();
    report.converged = true;
    return report;
  }
  Eigen::VectorXd image(n), residual(n), search(n);
  A(x, image);
  residual = b - image;
  search = residual.cwiseQuotient(diagonal);
  double energy = dot(residual, search);
  const double enough = options.tolerance * options.tolerance * size;
  const int limit = iteration_limit(options, n);
  while (report.iterations < limit && energy > enough) {
    progress.report(system, static_cast<double>(report.iterations) / limit);
    A(search, image);
    const double step = energy / dot(search, image);
    // The next residual, and its energy, in one pass.
    const double next = parallel_sum(n, kGrain, [&](Eigen::Index begin, Eigen::Index end) {
      double sum = 0;
      for (Eigen::Index i = begin; i < end; ++i) {
        x[i] += step * search[i];
        residual[i] -= step * image[i];
        sum += residual[i] * residual[i] / diagonal[i];
      }
      return sum;
    });
    const double turn = next / energy;
    parallel_for(n, kGrain, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) search[i] = residual[i] / diagonal[i] + turn * search[i];
    });
    energy = next;
    ++report.iterations;
  }
  if (!std::isfinite(energy)) throw SolverFailure(system, n);
  report.residual = std::sqrt(energy / size);
  report.converged = energy <= enough;
  return report;
}

IterativeReport solve_conjugate_gradients(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                          std::string_view system, const IterativeOptions& options,
                                          const Progress& progress) {
  check_iterations(options);
  if (options.preconditioner == Preconditioner::Diagonal)
    return solve_with_diagonal(A, B, X, system, options, progress);
  progress.report(system, 0);
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper, Eigen::IncompleteCholesky<double>>
      solver;
  return solve_columns(solver, A, B, X, system, options);
}

IterativeReport solve_gmres(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                            std::string_view system, const IterativeOptions& options) {
  check_iterations(options);
  Eigen::GMRES<SparseMatrix, Eigen::IncompleteLUT<double>> solver;
  solver.set_restart(50);
  return solve_columns(solver, A, B, X, system, options, true);
}

IterativeReport solve_lsqr(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                           std::string_view system, const IterativeOptions& options) {
  check_iterations(options);
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
      // Golub–Kahan bidiagonalisation, then one Givens rotation ([paige1982], section 4).
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
