#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/deformation/constrained_system_detail.hpp"
#include "batten/deformation/deformation_matrices_detail.hpp"

namespace batten::detail {

ConstrainedSystem::ConstrainedSystem(std::vector<int> constrained, Eigen::Index n, double soft_weight)
    : constrained_(std::move(constrained)),
      index_of_known_(n, -1),
      index_of_unknown_(n, -1),
      soft_weight_(soft_weight) {
  for (std::size_t c = 0; c < constrained_.size(); ++c) {
    const int v = constrained_[c];
    if (v < 0 || v >= n)
      throw InvalidInput(
          concat("constraint ", c, " names vertex ", v, ", but the mesh has the vertices 0 to ", n - 1));
    if (index_of_known_[v] >= 0)
      throw InvalidInput(concat("vertex ", v, " is constrained twice; name it once"));
    index_of_known_[v] = static_cast<int>(c);
  }
}

void ConstrainedSystem::choose_unknowns(const std::vector<char>& used) {
  for (std::size_t v = 0; v < used.size(); ++v)
    if (is_soft() ? used[v] != 0 || index_of_known_[v] >= 0 : index_of_known_[v] < 0 && used[v] != 0) {
      index_of_unknown_[v] = static_cast<int>(unknowns_.size());
      unknowns_.push_back(static_cast<int>(v));
    }
}

void ConstrainedSystem::factorize(const SparseMatrix& K, const Eigen::VectorXd& inverse_mass, double bending,
                                  const SparseMatrix& T, const Progress& progress) {
  progress.report("factorising", 0.1);
  const auto u = static_cast<Eigen::Index>(unknowns_.size());
  const auto c = is_soft() ? Eigen::Index{0} : static_cast<Eigen::Index>(constrained_.size());
  SparseMatrix lower(u, u);
  known_ = SparseMatrix(u, c);
  if (bending > 0) {
    SquaredStiffness squared =
        squared_stiffness(K, bending * inverse_mass, index_of_unknown_, index_of_known_);
    lower.swap(squared.lower);
    if (c > 0) known_.swap(squared.known);
  }
  if (T.nonZeros() > 0) {
    lower += part_of(T, index_of_unknown_, index_of_unknown_, u, u, true);
    if (c > 0) known_ += part_of(T, index_of_unknown_, index_of_known_, u, c, false);
  }
  if (is_soft()) add_soft_weights(lower);
  lower.makeCompressed();
  progress.report("factorising", 0.3);
  cholesky_.factorize(lower, progress.part("factorising", 0.3, 1));
}

void ConstrainedSystem::add_soft_weights(SparseMatrix& lower) {
  soft_unknowns_.clear();
  pull_ = soft_weight_ * lower.diagonal().mean();
  SparseMatrix weights(lower.rows(), lower.cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (const int v : constrained_) soft_unknowns_.push_back(index_of_unknown_[v]);
  for (const int u : soft_unknowns_) entries.emplace_back(u, u, pull_);
  weights.setFromTriplets(entries.begin(), entries.end());
  lower += weights;
}

}  // namespace batten::detail
