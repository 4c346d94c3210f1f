#pragma once
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// What conjugate gradients divide the residual by.
enum class Preconditioner {
  /// The least iterations; costs as much as some ten of them at first, and works on one thread.
  IncompleteCholesky,
  /// For matrices near their diagonal, or with a good start; works on all threads and can be cancelled.
  Diagonal,
};

/// Options shared by the iterative solvers.
struct IterativeOptions {
  /// Stop when the residual is below this fraction of the right-hand side; (0, 1). H 1.5 uses 1e-6.
  double tolerance = 1e-6;
  /// Most iterations, at least 0; 0 takes twice the number of unknowns.
  int max_iterations = 0;
  Preconditioner preconditioner = Preconditioner::IncompleteCholesky;  ///< of conjugate gradients

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What an iterative solve reached.
struct IterativeReport {
  int iterations = 0;      ///< of the slowest column
  double residual = 0;     ///< relative, of the worst column
  bool converged = false;  ///< false: the solution is the best found, its residual above the tolerance
};

/// The worst of several iterative solves.
struct SolveQuality {
  int unconverged = 0;  ///< how many stopped at their limit of iterations
  double residual = 0;  ///< the largest relative residual
  /// Takes in one more solve.
  void add(const IterativeReport& report) {
    unconverged += report.converged ? 0 : 1;
    residual = std::max(residual, report.residual);
  }
  /// Takes in what several came to.
  void add(const SolveQuality& others) {
    unconverged += others.unconverged;
    residual = std::max(residual, others.residual);
  }
};

/// Conjugate gradients for symmetric positive definite A (n × n, both halves stored).
/// @param X the start on entry (n × k), the solution on return.
/// @throws InvalidInput where options.problem() names one, here and below; SolverFailure when the iteration
/// leaves the finite numbers; `system` says what A stands for; Cancelled.
IterativeReport solve_conjugate_gradients(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                          std::string_view system, const IterativeOptions& options = {},
                                          const Progress& progress = {});
/// Writes A x (n) into y (n).
using LinearOperator = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;
/// The same for a matrix that is not stored, with its diagonal (n, above 0; or any other, as ones) as
/// preconditioner. Residuals are measured in the norm of the preconditioner, √(rᵀ D⁻¹ r), here. Sums are
/// added up in chunks that do not depend on the number of threads.
/// @param x the start on entry (n), the solution on return.
IterativeReport solve_conjugate_gradients(const LinearOperator& A, const Eigen::VectorXd& diagonal,
                                          const Eigen::VectorXd& b, Eigen::VectorXd& x,
                                          std::string_view system, const IterativeOptions& options = {},
                                          const Progress& progress = {});
/// Restarted GMRES(50) with incomplete LU, for square A that is not symmetric.
IterativeReport solve_gmres(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                            std::string_view system, const IterativeOptions& options = {});
/// LSQR [paige1982] for min ‖A x − b‖², A m × n of any shape. The tolerance is on ‖Aᵀr‖.
IterativeReport solve_lsqr(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                           std::string_view system, const IterativeOptions& options = {});

}  // namespace batten
