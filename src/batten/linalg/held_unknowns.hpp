#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/index.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// Which of n unknowns are held at given values and which are solved for; both keep their order. Free ones
/// have the numbers 0 … n_free() − 1 among themselves, held ones 0 … n_held() − 1.
class HeldUnknowns {
 public:
  HeldUnknowns() = default;
  /// @param held per unknown, not 0: held.
  explicit HeldUnknowns(const std::vector<char>& held);
  /// The same from the other kind. @param free per unknown, not 0: solved for.
  static HeldUnknowns all_but(const std::vector<char>& free);

  Eigen::Index size() const { return static_cast<Eigen::Index>(free_index_.size()); }
  Eigen::Index n_free() const { return static_cast<Eigen::Index>(free_.size()); }
  Eigen::Index n_held() const { return static_cast<Eigen::Index>(held_.size()); }
  /// The free and the held unknowns, increasing.
  const std::vector<int>& free() const { return free_; }
  const std::vector<int>& held() const { return held_; }
  /// Per unknown its number among the free (the held) ones, or −1.
  const std::vector<int>& free_index() const { return free_index_; }
  const std::vector<int>& held_index() const { return held_index_; }

  /// The rows of X (n × k) at the free unknowns.
  template <typename Derived>
  Eigen::MatrixXd free_rows(const Eigen::MatrixBase<Derived>& X) const {
    return rows_of(X, free_);
  }
  /// The rows of X at the held unknowns.
  template <typename Derived>
  Eigen::MatrixXd held_rows(const Eigen::MatrixBase<Derived>& X) const {
    return rows_of(X, held_);
  }
  /// Writes `free_values` (n_free() × k) into the free rows of X (n × k); held rows stay.
  template <typename Derived>
  void set_free_rows(const Eigen::MatrixXd& free_values, Eigen::MatrixBase<Derived>& X) const {
    for (Eigen::Index i = 0; i < n_free(); ++i) X.row(free_[at(i)]) = free_values.row(i);
  }
  /// Adds them instead.
  template <typename Derived>
  void add_to_free_rows(const Eigen::MatrixXd& free_values, Eigen::MatrixBase<Derived>& X) const {
    for (Eigen::Index i = 0; i < n_free(); ++i) X.row(free_[at(i)]) += free_values.row(i);
  }

  /// Rows and columns of the free unknowns of A (n × n); its lower triangle where that is all that is needed.
  SparseMatrix free_block(const SparseMatrix& A, bool lower_only = false) const;
  /// Rows of the free, columns of the held unknowns of A: what moves held values to the right-hand side.
  SparseMatrix coupling(const SparseMatrix& A) const;
  /// Rows and columns of the held unknowns.
  SparseMatrix held_block(const SparseMatrix& A) const;

 private:
  template <typename Derived>
  static Eigen::MatrixXd rows_of(const Eigen::MatrixBase<Derived>& X, const std::vector<int>& rows) {
    Eigen::MatrixXd taken(static_cast<Eigen::Index>(rows.size()), X.cols());
    for (std::size_t i = 0; i < rows.size(); ++i) taken.row(static_cast<Eigen::Index>(i)) = X.row(rows[i]);
    return taken;
  }

  std::vector<int> free_, held_, free_index_, held_index_;
};

/// Solves A x = b for the free unknowns with the others held: A_ff x_f = b_f − A_fh x_h, A_ff symmetric
/// positive definite. Factorised once, it serves any held values and any number of right-hand sides.
class HeldSolver {
 public:
  /// @param system what the matrix stands for; named in the errors.
  HeldSolver(std::string system, HeldUnknowns unknowns, CholeskyBackend backend = CholeskyBackend::Auto);

  /// Splits and factorises the whole symmetric A, n × n, both triangles given.
  /// @throws SolverFailure when A_ff is singular, indefinite or not finite.
  void factorize(const SparseMatrix& A);
  /// The same for a matrix that was assembled in its two parts, as squared_stiffness() does.
  /// @param lower A_ff, n_free × n_free, lower triangle. @param coupling A_fh, n_free × n_held.
  void factorize(const SparseMatrix& lower, SparseMatrix coupling);

  /// @param right n × k, rows of held unknowns unused. @param values n × k, rows of free unknowns unused.
  /// @return n × k: the solution, equal to `values` at the held unknowns. @throws SolverFailure when it is
  /// not finite or nothing has been factorised.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right, const Eigen::MatrixXd& values) const;
  /// The same for b = 0.
  Eigen::MatrixXd solve_homogeneous(const Eigen::MatrixXd& values) const;

  const HeldUnknowns& unknowns() const { return unknowns_; }

 private:
  Eigen::MatrixXd completed(Eigen::MatrixXd right, const Eigen::MatrixXd& values) const;

  HeldUnknowns unknowns_;
  SparseMatrix coupling_;
  SparseCholesky factor_;
};

}  // namespace batten
