#include "batten/linalg/ordering.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "batten/core/random.hpp"
#include "batten/linalg/bisection_detail.hpp"

#ifdef BATTEN_HAS_CHOLMOD  // then there are threads
#include <memory>

#include "batten/linalg/background_detail.hpp"
#endif

namespace batten {

namespace {

using detail::bisect;
using detail::VertexCover;
using detail::WeightedGraph;

/// Parts of at most so many unknowns are not parted further: minimum degree does as well there.
constexpr size_t kLeastPart = 300;
/// Bisections of a part, of which that with the fewest unknowns between its halves is kept.
constexpr int kTrials = 2;

/// The part of a graph between some vertices. @param local per vertex of the graph scratch, −1 throughout.
WeightedGraph part_of(const AdjacencyGraph& graph, const std::vector<int>& vertices,
                      std::vector<int>& local) {
  WeightedGraph part;
  for (size_t i = 0; i < vertices.size(); ++i) local[vertices[i]] = static_cast<int>(i);
  for (const int v : vertices) {
    for (int e = graph.first[v]; e < graph.first[v + 1]; ++e)
      if (local[graph.list[e]] >= 0) part.list.push_back(local[graph.list[e]]);
    part.first.push_back(static_cast<int>(part.list.size()));
  }
  part.edge_weight.assign(part.list.size(), 1);
  part.weight.assign(vertices.size(), 1);
  for (const int v : vertices) local[v] = -1;
  return part;
}

/// Neighbours as bits, with their numbers.
class BitRows {
 public:
  BitRows(size_t rows, size_t columns)
      : words_((columns + 63) / 64), bits_(rows * words_, 0), count_(rows, 0) {}
  void set(size_t row, size_t column) {
    bits_[row * words_ + column / 64] |= std::uint64_t{1} << column % 64;
    ++count_[row];
  }
  bool contains(size_t row, size_t column) const {
    return (bits_[row * words_ + column / 64] >> column % 64 & 1) != 0;
  }
  int count(size_t row) const { return count_[row]; }
  /// What `gone` was joined to is joined to `row` as well, and neither to itself nor to what is gone.
  void eliminate(size_t gone, size_t row) {
    std::uint64_t* const words = &bits_[row * words_];
    for (size_t w = 0; w < words_; ++w) words[w] |= bits_[gone * words_ + w];
    words[row / 64] &= ~(std::uint64_t{1} << row % 64);
    words[gone / 64] &= ~(std::uint64_t{1} << gone % 64);
    count_[row] = 0;
    for (size_t w = 0; w < words_; ++w) count_[row] += std::popcount(words[w]);
  }

 private:
  size_t words_;
  std::vector<std::uint64_t> bits_;
  std::vector<int> count_;
};

class Dissection {
 public:
  Dissection(const AdjacencyGraph& graph, const Progress& progress)
      : graph_(graph), progress_(progress), local_(graph.size(), -1) {
    std::vector<int> all(graph.size());
    std::iota(all.begin(), all.end(), 0);
    dissect(all);
  }
  std::vector<int> order;

 private:
  void dissect(const std::vector<int>& vertices) {
    if (vertices.size() <= kLeastPart) return leaf(vertices);
    const WeightedGraph part = part_of(graph_, vertices, local_);
    std::array<std::vector<int>, 3> parts;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::vector<char> side = bisect(part, random_, progress_);
      const VertexCover cover(part, side);
      std::array<std::vector<int>, 3> next;
      for (int v = 0; v < part.size(); ++v) next[cover.contains(v) ? 2 : side[v]].push_back(vertices[v]);
      if (trial == 0 || next[2].size() < parts[2].size()) parts = std::move(next);
    }
    if (parts[0].empty() || parts[1].empty()) return leaf(vertices);
    dissect(parts[0]);
    dissect(parts[1]);
    order.insert(order.end(), parts[2].begin(), parts[2].end());
  }

  /// Minimum degree in a part that is not parted: of the whole graph, so that what is joined to separators,
  /// which come later, does not seem to be cheap.
  void leaf(const std::vector<int>& vertices) {
    const size_t n = vertices.size();
    if (n > 4 * kLeastPart) return without_surroundings(vertices);
    std::vector<int> near = vertices;
    for (size_t i = 0; i < n; ++i) local_[vertices[i]] = static_cast<int>(i);
    for (const int v : vertices)
      for (int e = graph_.first[v]; e < graph_.first[v + 1]; ++e)
        if (local_[graph_.list[e]] < 0) {
          local_[graph_.list[e]] = static_cast<int>(near.size());
          near.push_back(graph_.list[e]);
        }
    BitRows joined(n, near.size());
    for (size_t i = 0; i < n; ++i)
      for (int e = graph_.first[vertices[i]]; e < graph_.first[vertices[i] + 1]; ++e)
        joined.set(i, static_cast<size_t>(local_[graph_.list[e]]));
    for (const int v : near) local_[v] = -1;
    std::vector<char> done(n, 0);
    for (size_t step = 0; step < n; ++step) {
      size_t least = n;
      for (size_t i = 0; i < n; ++i)
        if (!done[i] && (least == n || joined.count(i) < joined.count(least))) least = i;
      done[least] = 1;
      order.push_back(vertices[least]);
      for (size_t i = 0; i < n; ++i)
        if (!done[i] && joined.contains(least, i)) joined.eliminate(least, i);
    }
  }

  void without_surroundings(const std::vector<int>& vertices) {
    const WeightedGraph part = part_of(graph_, vertices, local_);
    AdjacencyGraph graph;
    graph.first = part.first;
    graph.list = part.list;
    for (const int v : minimum_degree(graph)) order.push_back(vertices[v]);
  }

  const AdjacencyGraph& graph_;
  const Progress& progress_;
  std::vector<int> local_;
  Random random_{1};
};

}  // namespace

AdjacencyGraph::AdjacencyGraph(int n, const std::vector<std::pair<int, int>>& joined) : first(n + 1, 0) {
  for (const auto& [a, b] : joined)
    if (a != b) ++first[a + 1], ++first[b + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  list.resize(first[n]);
  std::vector<int> end(first.begin(), first.end() - 1);
  for (const auto& [a, b] : joined)
    if (a != b) list[end[a]++] = b, list[end[b]++] = a;
}

std::vector<int> elimination_tree(const AdjacencyGraph& graph, const std::vector<int>& order) {
  const int n = graph.size();
  std::vector<int> parent(n, -1), ancestor(n, -1), position(n);
  for (int j = 0; j < n; ++j) position[order[j]] = j;
  for (int j = 0; j < n; ++j)
    for (int e = graph.first[order[j]]; e < graph.first[order[j] + 1]; ++e)
      for (int k = position[graph.list[e]]; k < j && k != -1;) {
        const int next = ancestor[k];
        ancestor[k] = j;
        if (next == -1) parent[k] = j;
        k = next;
        if (k == j) break;
      }
  return parent;
}

double elimination_work(const AdjacencyGraph& graph, const std::vector<int>& order) {
  const int n = graph.size();
  const std::vector<int> parent = elimination_tree(graph, order);
  std::vector<int> mark(n, -1), count(n, 1), position(n);
  for (int j = 0; j < n; ++j) position[order[j]] = j;
  for (int i = 0; i < n; ++i) {
    mark[i] = i;
    for (int e = graph.first[order[i]]; e < graph.first[order[i] + 1]; ++e)
      for (int k = position[graph.list[e]]; k < i && mark[k] != i; k = parent[k]) {
        mark[k] = i;
        ++count[k];
      }
  }
  double work = 0;
  for (const double c : count) work += 0.5 * c * c;
  return work;
}

std::vector<int> minimum_degree(const AdjacencyGraph& graph) {
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  const int n = graph.size();
  Matrix matrix(n, n);
  matrix.reserve(static_cast<Eigen::Index>(graph.list.size() / 2) + n);
  std::vector<int> column;
  for (int v = 0; v < n; ++v) {
    column.assign(1, v);  // Eigen leaves vertices without it to the end
    for (int e = graph.first[v]; e < graph.first[v + 1]; ++e)
      if (graph.list[e] > v) column.push_back(graph.list[e]);
    std::sort(column.begin(), column.end());
    matrix.startVec(v);
    for (const int u : column) matrix.insertBack(u, v) = 1;
  }
  matrix.finalize();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(matrix.selfadjointView<Eigen::Lower>(), permutation);
  return {permutation.indices().data(), permutation.indices().data() + n};
}

namespace {

/// Large graphs on a thread of their own while this one reports.
std::vector<int> minimum_degree_with_reports(const AdjacencyGraph& graph, const Progress& progress) {
#ifdef BATTEN_HAS_CHOLMOD
  constexpr int kLarge = 50000;  // some 30 ms
  if (!progress.is_silent() && graph.size() >= kLarge) {
    const auto copy = std::make_shared<const AdjacencyGraph>(graph);
    const auto order = std::make_shared<std::vector<int>>();
    const Progress part = progress.part("ordering", 0, 0.3);
    linalg_detail::run_in_background(
        [copy, order] {
          *order = minimum_degree(*copy);
          return true;
        },
        part);
    return std::move(*order);
  }
#endif
  progress.report("ordering", 0);
  return minimum_degree(graph);
}

}  // namespace

std::vector<int> nested_dissection(const AdjacencyGraph& graph, const Progress& progress) {
  return Dissection(graph, progress).order;
}

std::vector<int> fill_reducing_order(const AdjacencyGraph& graph, const Progress& progress) {
  // Curves leave some 40 multiplications per unknown of the joint estimate, a sheet of 17 × 17 curves 840.
  constexpr double kMuchWork = 150;
  std::vector<int> order = minimum_degree_with_reports(graph, progress);
  progress.report("ordering", 0.3);
  const double work = elimination_work(graph, order);
  if (work < kMuchWork * graph.size()) return order;
  std::vector<int> dissected = nested_dissection(graph, progress);
  return elimination_work(graph, dissected) < work ? dissected : order;
}

}  // namespace batten
