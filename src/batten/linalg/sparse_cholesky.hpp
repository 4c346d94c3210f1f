#pragma once
#include <memory>
#include <string>
#include <string_view>

#include <Eigen/SparseCore>

#include "batten/core/progress.hpp"

namespace batten {

/// Column-major compressed sparse matrix; the storage of every system in the library.
using SparseMatrix = Eigen::SparseMatrix<double>;

/// Who factorises.
enum class CholeskyBackend {
  /// CHOLMOD where it is built in and the system has more than kCholmodFrom unknowns, else Eigen.
  Auto,
  /// Eigen's simplicial LDLᵀ with minimum-degree ordering; everywhere, fastest below some 10,000 unknowns.
  Eigen,
  /// SuiteSparse CHOLMOD, supernodal; several times faster from 100,000 unknowns on.
  Cholmod,
};

/// Factorises symmetric positive definite systems and keeps the factor, so that many right-hand sides, and
/// many matrices of one pattern, share the work.
class SparseCholesky {
 public:
  /// Below this many unknowns Auto takes Eigen (see bench/, "factorisation").
  static constexpr Eigen::Index kCholmodFrom = 15000;

  /// @param system what the matrix stands for; named in the errors.
  explicit SparseCholesky(std::string system, CholeskyBackend backend = CholeskyBackend::Auto);
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Factorises A (n × n, symmetric positive definite; only the lower triangle is read). The ordering of an
  /// earlier call is kept when the pattern is the same.
  ///
  /// Where somebody listens to the progress and the system is large (kCholmodFrom), CHOLMOD, which cannot be
  /// interrupted, runs on a thread of its own with a copy of A, and the calling thread reports every 50 ms.
  /// After a cancellation that thread works on to its end, unseen; the process waits for it when it exits.
  /// The settings of OpenBLAS and OpenMP are serial while CHOLMOD runs and put back when it returns.
  /// @throws SolverFailure when A is singular, indefinite or not finite; Cancelled, and nothing is factorised
  /// then.
  void factorize(const SparseMatrix& A, const Progress& progress = {});
  /// The same for a matrix that may be indefinite, as Newton's method meets them. @return false, and nothing
  /// to solve with, when A is not positive definite; the ordering is kept either way.
  bool try_factorize(const SparseMatrix& A, const Progress& progress = {});

  /// X with A X = B, for any number of columns. @pre factorize() has succeeded.
  /// @throws SolverFailure when the result is not finite.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const;

  /// Rows of the matrix that was factorised.
  Eigen::Index unknowns() const;
  /// The backend in use: Eigen or Cholmod.
  CholeskyBackend backend() const;
  static bool has_cholmod();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace batten
