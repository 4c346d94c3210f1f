#include "batten/curves/cubic_spline.hpp"

#include <utility>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/curves/gauss.hpp"

namespace batten {

using Eigen::Index;
using Eigen::Vector3d;

CubicSpline::CubicSpline(std::vector<double> knots, Points values, bool periodic)
    : knots_(std::move(knots)), values_(std::move(values)) {
  const Index last = values_.rows() - 1, n = periodic ? last : last + 1;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 3);
  for (Index i = 0; i < n; ++i) {
    const auto row = static_cast<int>(i);
    if (!periodic && (i == 0 || i == last)) {
      entries.emplace_back(row, row, 1);
      continue;
    }
    const Index before = i == 0 ? last - 1 : i - 1;
    const double h0 = width(before), h1 = width(i);
    entries.emplace_back(row, static_cast<int>(before), h0 / 6);
    entries.emplace_back(row, row, (h0 + h1) / 3);
    entries.emplace_back(row, static_cast<int>((i + 1) % n), h1 / 6);
    right.row(i) = (values_.row(i + 1) - values_.row(i)) / h1 - (values_.row(i) - values_.row(before)) / h0;
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  // Diagonally dominant: singular only where knots coincide or are no numbers.
  if (solver.info() != Eigen::Success) throw SolverFailure("second derivatives of a spline", n);
  const Eigen::MatrixXd solution = solver.solve(right);
  bends_.resize(values_.rows(), 3);
  bends_.topRows(n) = solution;
  if (periodic) bends_.row(last) = bends_.row(0);
}

double CubicSpline::width(Index piece) const {
  return knots_[batten::at(piece) + 1] - knots_[batten::at(piece)];
}

Vector3d CubicSpline::at(Index piece, double t) const {
  const double h = width(piece), s = 1 - t;
  return s * values_.row(piece) + t * values_.row(piece + 1) +
         h * h / 6 * ((s * s * s - s) * bends_.row(piece) + (t * t * t - t) * bends_.row(piece + 1));
}

Vector3d CubicSpline::derivative(Index piece, double t) const {
  const double h = width(piece), s = 1 - t;
  return (values_.row(piece + 1) - values_.row(piece)) / h +
         h / 6 * ((1 - 3 * s * s) * bends_.row(piece) + (3 * t * t - 1) * bends_.row(piece + 1));
}

double CubicSpline::length(Index piece, double t) const {
  return t *
         gauss_integral([&](double u) { return speed(piece, t * u / 2) + speed(piece, t * (1 + u) / 2); }) /
         2;
}

}  // namespace batten
