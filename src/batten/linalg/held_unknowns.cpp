#include "batten/linalg/held_unknowns.hpp"

#include <utility>

namespace batten {

namespace {

/// The entries of A in the given rows and columns (numbers there, or −1), columns in order, counted first.
SparseMatrix part_of(const SparseMatrix& A, const std::vector<int>& row_index,
                     const std::vector<int>& columns, Eigen::Index n_rows, bool lower_only) {
  SparseMatrix part(n_rows, static_cast<Eigen::Index>(columns.size()));
  const auto each = [&](std::size_t c, const auto& take) {
    for (SparseMatrix::InnerIterator entry(A, columns[c]); entry; ++entry) {
      const int row = row_index[at(entry.row())];
      if (row >= 0 && !(lower_only && row < static_cast<int>(c))) take(row, entry.value());
    }
  };
  int count = 0;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    part.outerIndexPtr()[c] = count;
    each(c, [&](int, double) { ++count; });
  }
  part.outerIndexPtr()[columns.size()] = count;
  part.resizeNonZeros(count);
  int place = 0;
  for (std::size_t c = 0; c < columns.size(); ++c)
    each(c, [&](int row, double value) {
      part.innerIndexPtr()[place] = row;
      part.valuePtr()[place++] = value;
    });
  return part;
}

}  // namespace

HeldUnknowns::HeldUnknowns(const std::vector<char>& held)
    : free_index_(held.size(), -1), held_index_(held.size(), -1) {
  for (std::size_t v = 0; v < held.size(); ++v) {
    std::vector<int>& list = held[v] ? held_ : free_;
    (held[v] ? held_index_ : free_index_)[v] = static_cast<int>(list.size());
    list.push_back(static_cast<int>(v));
  }
}

HeldUnknowns HeldUnknowns::all_but(const std::vector<char>& free) {
  std::vector<char> held(free.size());
  for (std::size_t v = 0; v < free.size(); ++v) held[v] = !free[v];
  return HeldUnknowns(held);
}

SparseMatrix HeldUnknowns::free_block(const SparseMatrix& A, bool lower_only) const {
  return part_of(A, free_index_, free_, n_free(), lower_only);
}

SparseMatrix HeldUnknowns::coupling(const SparseMatrix& A) const {
  return part_of(A, free_index_, held_, n_free(), false);
}

SparseMatrix HeldUnknowns::held_block(const SparseMatrix& A) const {
  return part_of(A, held_index_, held_, n_held(), false);
}

HeldSolver::HeldSolver(std::string system, HeldUnknowns unknowns, CholeskyBackend backend)
    : unknowns_(std::move(unknowns)),
      coupling_(unknowns_.n_free(), unknowns_.n_held()),
      factor_(std::move(system), backend) {}

void HeldSolver::factorize(const SparseMatrix& A) {
  factorize(unknowns_.free_block(A, true), unknowns_.coupling(A));
}

void HeldSolver::factorize(const SparseMatrix& lower, SparseMatrix coupling) {
  factor_.factorize(lower);
  coupling_ = std::move(coupling);
}

Eigen::MatrixXd HeldSolver::solve(const Eigen::MatrixXd& right, const Eigen::MatrixXd& values) const {
  return completed(unknowns_.free_rows(right), values);
}

Eigen::MatrixXd HeldSolver::solve_homogeneous(const Eigen::MatrixXd& values) const {
  return completed(Eigen::MatrixXd::Zero(unknowns_.n_free(), values.cols()), values);
}

Eigen::MatrixXd HeldSolver::completed(Eigen::MatrixXd right, const Eigen::MatrixXd& values) const {
  if (unknowns_.n_held() > 0) right -= coupling_ * unknowns_.held_rows(values);
  const Eigen::MatrixXd solution = factor_.solve(right);
  Eigen::MatrixXd result = values;
  unknowns_.set_free_rows(solution, result);
  return result;
}

}  // namespace batten
