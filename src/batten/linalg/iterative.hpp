#pragma once
#include <string_view>

#include <Eigen/Core>

#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// Options shared by the iterative solvers.
struct IterativeOptions {
  /// Stop when the residual is below this fraction of the right-hand side; (0, 1). H 1.5 uses 1e-6.
  double tolerance = 1e-6;
  /// Most iterations; 0 takes twice the number of unknowns.
  int max_iterations = 0;
};

/// What an iterative solve reached.
struct IterativeReport {
  int iterations = 0;      ///< of the slowest column
  double residual = 0;     ///< relative, of the worst column
  bool converged = false;  ///< false: the solution is the best found, its residual above the tolerance
};

/// Conjugate gradients with incomplete Cholesky for symmetric positive definite A (n × n).
/// @param X the start on entry (n × k), the solution on return.
/// @throws SolverFailure when the iteration leaves the finite numbers; `system` says what A stands for.
IterativeReport solve_conjugate_gradients(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                                          std::string_view system, const IterativeOptions& options = {});
/// Restarted GMRES(50) with incomplete LU, for square A that is not symmetric.
IterativeReport solve_gmres(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                            std::string_view system, const IterativeOptions& options = {});
/// LSQR (Paige, Saunders 1982) for min ‖A x − b‖², A m × n of any shape. The tolerance is on ‖Aᵀr‖.
IterativeReport solve_lsqr(const SparseMatrix& A, const Eigen::MatrixXd& B, Eigen::MatrixXd& X,
                           std::string_view system, const IterativeOptions& options = {});

}  // namespace batten
