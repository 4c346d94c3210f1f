#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "batten/core/parallel.hpp"
#include "batten/linalg/ordering.hpp"
#include "batten/scan/block_ldlt_detail.hpp"

namespace batten {

namespace {

/// Subtrees are at most this part of the whole work, so that the threads end together.
constexpr double kSubtreeShare = 1.0 / 48;
/// Chunks of subtrees that the threads take one by one.
constexpr Eigen::Index kChunks = 64;
/// Columns of the top between two reports; on sheets one takes up to 0.3 ms.
constexpr size_t kTopReport = 100;
/// Below so much work (blocks) threads cost more than they bring.
constexpr double kParallelWork = 2e4;

/// Vertices of a forest with children before parents and subtrees together. @return per place the vertex.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> head(n, -1), next(n, -1), order, stack;
  for (int j = n - 1; j >= 0; --j)
    if (parent[j] >= 0) next[j] = head[parent[j]], head[parent[j]] = j;
  for (int root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const int j = stack.back();
      if (head[j] >= 0) {
        stack.push_back(head[j]);
        head[j] = next[head[j]];
      } else {
        order.push_back(j);
        stack.pop_back();
      }
    }
  }
  return order;
}

/// S = G Gᵀ, in place. @return whether S is positive definite.
template <int B>
bool factorize_definite(Eigen::Matrix<double, B, B>& S) {
  for (int j = 0; j < B; ++j) {
    for (int k = 0; k < j; ++k) S(j, j) -= S(j, k) * S(j, k);
    if (!(S(j, j) > 0) || !std::isfinite(S(j, j))) return false;
    S(j, j) = std::sqrt(S(j, j));
    for (int i = j + 1; i < B; ++i) {
      for (int k = 0; k < j; ++k) S(i, j) -= S(i, k) * S(j, k);
      S(i, j) /= S(j, j);
      S(j, i) = 0;
    }
  }
  return true;
}

/// U becomes U G⁻ᵀ.
template <int B>
void divide_by_transposed(const Eigen::Matrix<double, B, B>& G, Eigen::Matrix<double, B, B>& U) {
  for (int j = 0; j < B; ++j) {
    for (int k = 0; k < j; ++k) U.col(j) -= G(j, k) * U.col(k);
    U.col(j) /= G(j, j);
  }
}

/// U becomes U G⁻¹.
template <int B>
void divide(const Eigen::Matrix<double, B, B>& G, Eigen::Matrix<double, B, B>& U) {
  for (int j = B - 1; j >= 0; --j) {
    for (int k = j + 1; k < B; ++k) U.col(j) -= G(k, j) * U.col(k);
    U.col(j) /= G(j, j);
  }
}

}  // namespace

template <int B>
BlockLdlt<B>::BlockLdlt(int n, const std::vector<std::pair<int, int>>& joined, std::vector<char> multiplier,
                        const Progress& progress)
    : n_(n) {
  const AdjacencyGraph graph(n_, joined);
  order(graph, progress);
  negative_.resize(n_);
  for (int i = 0; i < n_; ++i) negative_[position_[i]] = multiplier.empty() ? 0 : multiplier[i];
  analyse(graph, progress);
  plan();
  log_pivot_.assign(n_, 0);
  clear();
}

template <int B>
void BlockLdlt<B>::order(const AdjacencyGraph& graph, const Progress& progress) {
  const std::vector<int> order = fill_reducing_order(graph, progress);
  unknown_.resize(n_);
  progress.report("ordering", 0.8);
  const std::vector<int> places = postorder(elimination_tree(graph, order));
  for (int j = 0; j < n_; ++j) unknown_[j] = order[places[j]];
  position_.resize(n_);
  for (int j = 0; j < n_; ++j) position_[unknown_[j]] = j;
  parent_ = elimination_tree(graph, unknown_);
}

template <int B>
void BlockLdlt<B>::analyse(const AdjacencyGraph& graph, const Progress& progress) {
  progress.report("ordering", 0.9);
  // Row i of the factor: all columns on the ways from the entries of the matrix up to i.
  std::vector<int> mark(n_, -1);
  std::vector<int> columns;
  std::vector<int> count(n_, 1);
  row_first_.assign(1, 0);
  for (int i = 0; i < n_; ++i) {
    mark[i] = i;
    const size_t begin = columns.size();
    for (int e = graph.first[unknown_[i]]; e < graph.first[unknown_[i] + 1]; ++e)
      for (int k = position_[graph.list[e]]; k < i && mark[k] != i; k = parent_[k]) {
        mark[k] = i;
        ++count[k];
        columns.push_back(k);
      }
    std::sort(columns.begin() + static_cast<std::ptrdiff_t>(begin), columns.end());
    row_first_.push_back(static_cast<int>(columns.size()));
  }
  progress.report("ordering", 0.95);
  first_.assign(n_ + 1, 0);
  std::partial_sum(count.begin(), count.end(), first_.begin() + 1);
  rows_.resize(first_[n_]);
  row_.resize(columns.size());
  std::vector<int> end(first_.begin(), first_.end() - 1);
  for (int i = 0; i < n_; ++i) {
    for (int e = row_first_[i]; e < row_first_[i + 1]; ++e) {
      const int k = columns[e];
      row_[e] = {k, end[k]};
      rows_[end[k]++] = i;
    }
    rows_[end[i]++] = i;
  }
}

template <int B>
void BlockLdlt<B>::plan() {
  std::vector<double> work(n_, 0);
  std::vector<int> size(n_, 1);
  work_ = 0;
  for (int j = 0; j < n_; ++j) {
    const double c = first_[j + 1] - first_[j];
    work[j] += 0.5 * c * c;
    work_ += 0.5 * c * c;
    if (parent_[j] < 0) continue;
    work[parent_[j]] += work[j];
    size[parent_[j]] += size[j];
  }
  for (int j = n_ - 1; j >= 0;) {
    if (work_ > kParallelWork && work[j] <= kSubtreeShare * work_) {
      subtrees_.push_back({j + 1 - size[j], j + 1});
      j -= size[j];
    } else {
      top_.push_back(j--);
    }
  }
  std::reverse(subtrees_.begin(), subtrees_.end());
  std::reverse(top_.begin(), top_.end());
}

template <int B>
typename BlockLdlt<B>::Slot BlockLdlt<B>::slot(int a, int b) const {
  const int row = std::max(position_[a], position_[b]), column = std::min(position_[a], position_[b]);
  const auto begin = rows_.begin() + first_[column], end = rows_.begin() + first_[column + 1];
  return {static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin()), position_[a] < position_[b]};
}

template <int B>
void BlockLdlt<B>::clear() {
  values_.assign(first_[n_], Block::Zero());
}

/// Calls body(columns) for every column, those that it depends on before it.
template <int B>
template <typename Body>
void BlockLdlt<B>::upwards(const Body& body, const Progress& progress) const {
  const auto n = static_cast<Eigen::Index>(subtrees_.size());
  parallel_for(
      n, (n + kChunks - 1) / kChunks,
      [&](Eigen::Index begin, Eigen::Index end) {
        const std::unique_ptr<int[]> target(new int[static_cast<size_t>(n_)]);
        for (Eigen::Index i = begin; i < end; ++i)
          for (int j = subtrees_[i].begin; j < subtrees_[i].end; ++j) body(j, target.get());
      },
      progress);
  const std::unique_ptr<int[]> target(new int[static_cast<size_t>(n_)]);
  for (size_t i = 0; i < top_.size(); ++i) {
    if (i % kTopReport == 0) progress.report("working", 0.5);
    body(top_[i], target.get());
  }
}

/// The same with those that depend on a column before it.
template <int B>
template <typename Body>
void BlockLdlt<B>::downwards(const Body& body, const Progress& progress) const {
  for (size_t i = top_.size(); i-- > 0;) {
    if (i % kTopReport == 0) progress.report("working", 0.5);
    body(top_[i]);
  }
  const auto n = static_cast<Eigen::Index>(subtrees_.size());
  parallel_for(
      n, (n + kChunks - 1) / kChunks,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i)
          for (int j = subtrees_[i].end - 1; j >= subtrees_[i].begin; --j) body(j);
      },
      progress);
}

template <int B>
bool BlockLdlt<B>::eliminate(int column, int* target) {
  const int begin = first_[column], end = first_[column + 1];
  for (int p = begin; p < end; ++p) target[rows_[p]] = p;
  for (int e = row_first_[column]; e < row_first_[column + 1]; ++e) {
    const int k = row_[e].column;
    Block carried = values_[row_[e].place].transpose();
    if (negative_[k]) carried = -carried;
    for (int p = row_[e].place; p < first_[k + 1]; ++p)
      values_[target[rows_[p]]].noalias() -= values_[p].lazyProduct(carried);
  }
  Block& pivot = values_[begin];
  if (negative_[column]) pivot = -pivot;
  if (!factorize_definite<B>(pivot)) return false;
  log_pivot_[column] = 2 * std::log(pivot.diagonal().prod());
  for (int p = begin + 1; p < end; ++p) {
    if (negative_[column]) values_[p] = -values_[p];
    divide_by_transposed<B>(pivot, values_[p]);
  }
  return true;
}

template <int B>
bool BlockLdlt<B>::factorize(const Progress& progress) {
  std::atomic<bool> definite{true};
  upwards(
      [&](int column, int* target) {
        if (definite && !eliminate(column, target)) definite = false;
      },
      progress);
  log_determinant_ = 0;
  for (const double log : log_pivot_) log_determinant_ += log;
  return definite && std::isfinite(log_determinant_);
}

template <int B>
Eigen::VectorXd BlockLdlt<B>::solve(const Eigen::VectorXd& right) const {
  std::vector<Vector> x(n_);
  for (int j = 0; j < n_; ++j) x[j] = right.segment<B>(B * unknown_[j]);
  upwards(
      [&](int j, int*) {
        for (int e = row_first_[j]; e < row_first_[j + 1]; ++e)
          x[j].noalias() -= values_[row_[e].place].lazyProduct(x[row_[e].column]);
        values_[first_[j]].template triangularView<Eigen::Lower>().solveInPlace(x[j]);
      },
      {});
  downwards(
      [&](int j) {
        if (negative_[j]) x[j] = -x[j];
        for (int p = first_[j] + 1; p < first_[j + 1]; ++p)
          x[j].noalias() -= values_[p].transpose().lazyProduct(x[rows_[p]]);
        values_[first_[j]].transpose().template triangularView<Eigen::Upper>().solveInPlace(x[j]);
      },
      {});
  Eigen::VectorXd solution(right.size());
  for (int j = 0; j < n_; ++j) solution.segment<B>(B * unknown_[j]) = x[j];
  return solution;
}

template <int B>
Eigen::VectorXd BlockLdlt<B>::root_times(const Eigen::VectorXd& z) const {
  Eigen::VectorXd product = Eigen::VectorXd::Zero(z.size());
  for (int j = 0; j < n_; ++j) {
    const Vector x = z.segment<B>(B * j);
    product.segment<B>(B * unknown_[j]) += values_[first_[j]].template triangularView<Eigen::Lower>() * x;
    for (int p = first_[j] + 1; p < first_[j + 1]; ++p)
      product.segment<B>(B * unknown_[rows_[p]]) += values_[p] * x;
  }
  return product;
}

template <int B>
void BlockLdlt<B>::invert(const Progress& progress) {
  wanted_.assign(n_, 1);
  inverse_.resize(values_.size());
  downwards([&](int j) { invert_column(j); }, progress);
}

template <int B>
void BlockLdlt<B>::invert(const std::vector<int>& unknowns, const Progress& progress) {
  wanted_.assign(n_, 0);
  for (const int i : unknowns)
    for (int j = position_[i]; j >= 0 && !wanted_[j]; j = parent_[j]) wanted_[j] = 1;
  inverse_.resize(values_.size());
  downwards(
      [&](int j) {
        if (wanted_[j]) invert_column(j);
      },
      progress);
}

/// Z L = L⁻ᵀ S, column by column: with M = L G⁻¹, Z_ij = −Σ_k Z_ik M_kj over the rows k of the column, whose
/// blocks Z_ik lie in columns that are known.
template <int B>
void BlockLdlt<B>::invert_column(int column) {
  const int begin = first_[column], end = first_[column + 1];
  std::vector<Block> M(values_.begin() + begin + 1, values_.begin() + end);
  for (Block& block : M) divide<B>(values_[begin], block);
  const auto unit = [&](int p) -> const Block& { return M[static_cast<size_t>(p - begin - 1)]; };
  for (int p = begin; p < end; ++p) inverse_[p].setZero();
  for (int p = begin + 1; p < end; ++p) {
    int place = first_[rows_[p]];
    inverse_[p].noalias() -= inverse_[place].lazyProduct(unit(p));
    for (int q = p + 1; q < end; ++q) {
      while (rows_[place] < rows_[q]) ++place;
      inverse_[q].noalias() -= inverse_[place].lazyProduct(unit(p));
      inverse_[p].noalias() -= inverse_[place].transpose().lazyProduct(unit(q));
    }
  }
  Block diagonal = Block::Identity();
  divide<B>(values_[begin], diagonal);
  diagonal = diagonal.transpose() * diagonal;
  if (negative_[column]) diagonal = -diagonal;
  for (int p = begin + 1; p < end; ++p) diagonal.noalias() -= unit(p).transpose().lazyProduct(inverse_[p]);
  inverse_[begin] = 0.5 * (diagonal + diagonal.transpose());
}

template class BlockLdlt<1>;
template class BlockLdlt<3>;

}  // namespace batten
