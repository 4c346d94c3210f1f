#include <Eigen/IterativeLinearSolvers>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/modelling/cage_fit_detail.hpp"
#include "batten/subdivision/limit_stencils.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;

/// μ of fit_limit(). A surface through every vertex of uneven quads overshoots between them; with 1 it passes
/// them by a hundredth of a percent of the size on a sphere of 16 n quads, and does not wrinkle beside
/// concave corners.
constexpr double kEvenness = 1;

// Of the size: where a fit stops, and what it must have reached.
constexpr double kAimedResidual = 1e-12, kAcceptedResidual = 1e-9;
constexpr int kMostRounds = 20;

/// Rows of μ U U for the vertices that are not exact, with U the umbrella: how uneven the difference of cage
/// and target is. Sharp edges have none, as the differences on their sides have nothing in common, and
/// neither have borders and the rim of a part.
SparseMatrix unevenness(const ControlCage& cage, const std::vector<char>& free,
                        const std::vector<char>& exact) {
  const auto n = static_cast<Index>(exact.size());
  std::vector<char> left_out(exact.size(), 0);
  for (size_t v = 0; v < free.size(); ++v) left_out[v] = !free[v];
  for (const SharpEdge& edge : cage.sharp_edges) left_out[at(edge.from)] = left_out[at(edge.to)] = 1;
  std::vector<double> valence(exact.size(), 0);
  // Of the neighbours around a vertex: 0 where they close.
  std::vector<Index> first_less_last(exact.size(), 0);
  for (size_t first = 0; first < cage.mesh.corners.size(); first += 4)
    for (size_t k = 0; k < 4; ++k) {
      const size_t v = at(cage.mesh.corners[first + k]);
      valence[v] += 2;
      first_less_last[v] += cage.mesh.corners[first + (k + 1) % 4] - cage.mesh.corners[first + (k + 3) % 4];
    }
  for (size_t v = 0; v < left_out.size(); ++v)
    if (first_less_last[v] != 0) left_out[v] = 1;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(4 * cage.mesh.corners.size());
  for (size_t first = 0; first < cage.mesh.corners.size(); first += 4)
    for (size_t k = 0; k < 4; ++k) {
      const int v = cage.mesh.corners[first + k];
      if (left_out[at(v)]) continue;
      entries.emplace_back(v, v, 2 / valence[at(v)]);
      for (const size_t next : {(k + 1) % 4, (k + 3) % 4})
        entries.emplace_back(v, cage.mesh.corners[first + next], -1 / valence[at(v)]);
    }
  SparseMatrix umbrella(n, n);
  umbrella.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd weight(n);
  for (Index v = 0; v < n; ++v) weight(v) = exact[static_cast<size_t>(v)] ? 0 : kEvenness;
  return weight.asDiagonal() * (umbrella * umbrella);
}

}  // namespace

IterativeReport fit_limit(ControlCage& cage, const Points& target, const std::vector<char>& free,
                          const std::vector<char>& exact) {
  const SparseMatrix uneven = unevenness(cage, free, exact), rows = limit_stencils(cage) + uneven;
  const Points wanted = target + uneven * target;
  const HeldUnknowns unknowns = HeldUnknowns::all_but(free);
  IterativeReport report{.iterations = 0, .residual = 0, .converged = true};
  if (unknowns.n_free() == 0) return report;
  // BiCGSTAB takes a right-hand side that is no number for solved, and maxima pass it over.
  if (!wanted.allFinite()) throw SolverFailure("cage of the limit surface", unknowns.n_free());
  const Eigen::SparseMatrix<double, Eigen::RowMajor> A = unknowns.free_block(rows);
  Eigen::BiCGSTAB<Eigen::SparseMatrix<double, Eigen::RowMajor>> inverse(A);
  inverse.setTolerance(1e-8);  // of what is still lacking, which falls with every turn
  inverse.setMaxIterations(200);
  const double size = bounding_box_diagonal(target);
  Points& positions = cage.mesh.positions;
  Eigen::MatrixXd right;
  double worst = 0;
  const auto take_lack = [&] {
    const Points lack = wanted - rows * positions;
    right = unknowns.free_rows(lack);
    worst = right.rowwise().norm().maxCoeff();
  };
  take_lack();
  Eigen::MatrixXd solved(unknowns.n_free(), 3);
  while (report.iterations < kMostRounds && !(worst < kAimedResidual * size)) {
    for (int c = 0; c < 3; ++c) {
      // Turns that are used up are no failure here: the next round goes on from what they have reached.
      solved.col(c) = inverse.solve(right.col(c));
      if (inverse.info() == Eigen::NumericalIssue || !solved.col(c).allFinite())
        throw SolverFailure("cage of the limit surface", unknowns.n_free());
    }
    unknowns.add_to_free_rows(solved, positions);
    ++report.iterations;
    take_lack();
  }
  report.residual = size > 0 ? worst / size : 0;
  report.converged = worst <= kAcceptedResidual * size;
  return report;
}

}  // namespace batten::detail
