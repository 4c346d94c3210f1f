#include "batten/linalg/ordering.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <queue>
#include <tuple>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "batten/core/random.hpp"

#ifdef BATTEN_HAS_CHOLMOD  // then there are threads
#include <memory>

#include "batten/linalg/background_detail.hpp"
#endif

namespace batten {

namespace {

/// Parts of at most so many unknowns are not parted further: minimum degree does as well there.
constexpr size_t kLeastPart = 300;
/// A graph with weights is coarsened until it has so few vertices.
constexpr int kCoarsest = 60;
/// Bisections of a part, of which that with the fewest unknowns between its halves is kept.
constexpr int kTrials = 2;
/// Starts of the first bisection, of which the best is kept.
constexpr int kStarts = 6;
/// A half may have so large a part of the weight.
constexpr double kLargestHalf = 0.55;
/// Rounds of moves at each level, and moves in a row without gain after which a round ends.
constexpr int kRounds = 4, kIdleMoves = 60;

/// A graph whose vertices and edges stand for several of a finer one.
struct WeightedGraph {
  std::vector<int> first{0}, list, edge_weight, weight;
  int size() const { return static_cast<int>(weight.size()); }
  int total() const { return std::accumulate(weight.begin(), weight.end(), 0); }
};

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

/// Pairs each vertex with the free neighbour it is joined to most. @return per vertex that of the coarser
/// graph; their number.
std::pair<std::vector<int>, int> matched(const WeightedGraph& graph, Random& random) {
  const int n = graph.size(), heaviest = std::max(2, 3 * graph.total() / (2 * kCoarsest));
  std::vector<int> order(n), coarse(n, -1);
  std::iota(order.begin(), order.end(), 0);
  for (int i = n - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
  int count = 0;
  for (const int v : order) {
    if (coarse[v] >= 0) continue;
    int best = -1, most = 0;
    for (int e = graph.first[v]; e < graph.first[v + 1]; ++e) {
      const int u = graph.list[e];
      if (coarse[u] >= 0 || graph.edge_weight[e] <= most || graph.weight[u] + graph.weight[v] > heaviest)
        continue;
      most = graph.edge_weight[e];
      best = u;
    }
    coarse[v] = count;
    if (best >= 0) coarse[best] = count;
    ++count;
  }
  return {std::move(coarse), count};
}

WeightedGraph coarsened(const WeightedGraph& fine, const std::vector<int>& coarse, int count) {
  std::vector<std::pair<int, int>> members(count, {-1, -1});
  for (int v = 0; v < fine.size(); ++v) {
    auto& [a, b] = members[coarse[v]];
    (a < 0 ? a : b) = v;
  }
  WeightedGraph graph;
  std::vector<int> place(count, -1);
  for (int c = 0; c < count; ++c) {
    const int begin = graph.first.back();
    int weight = 0;
    for (const int v : {members[c].first, members[c].second}) {
      if (v < 0) continue;
      weight += fine.weight[v];
      for (int e = fine.first[v]; e < fine.first[v + 1]; ++e) {
        const int d = coarse[fine.list[e]];
        if (d == c) continue;
        if (place[d] < begin) {
          place[d] = static_cast<int>(graph.list.size());
          graph.list.push_back(d);
          graph.edge_weight.push_back(0);
        }
        graph.edge_weight[place[d]] += fine.edge_weight[e];
      }
    }
    graph.weight.push_back(weight);
    graph.first.push_back(static_cast<int>(graph.list.size()));
  }
  return graph;
}

/// Two halves of a graph and the moves that make the cut between them lighter [fiduccia1982].
class Halves {
 public:
  explicit Halves(const WeightedGraph& graph) : graph_(graph), total_(graph.total()) {}

  /// All vertices in half 1 but for a half that grows from one vertex, by those that it is joined to most.
  void grow(int seed);
  void take(std::vector<char> side);
  /// Rounds of single moves, the best of each round kept.
  void refine();

  int cut() const { return cut_; }
  /// How much the heavier half is beyond what it may be.
  int excess() const { return std::max(0, std::max(weight_[0], weight_[1]) - allowed()); }
  const std::vector<char>& side() const { return side_; }

 private:
  int allowed() const {
    const int heaviest = *std::max_element(graph_.weight.begin(), graph_.weight.end());
    return std::max(static_cast<int>(kLargestHalf * total_), total_ / 2 + heaviest);
  }
  void move(int v);
  int gain(int v) const;
  bool round();

  const WeightedGraph& graph_;
  int total_;
  std::vector<char> side_;
  std::array<int, 2> weight_{};
  int cut_ = 0;
};

int Halves::gain(int v) const {
  int gain = 0;
  for (int e = graph_.first[v]; e < graph_.first[v + 1]; ++e)
    gain += side_[graph_.list[e]] != side_[v] ? graph_.edge_weight[e] : -graph_.edge_weight[e];
  return gain;
}

void Halves::move(int v) {
  cut_ -= gain(v);
  weight_[side_[v]] -= graph_.weight[v];
  side_[v] = static_cast<char>(1 - side_[v]);
  weight_[side_[v]] += graph_.weight[v];
}

void Halves::take(std::vector<char> side) {
  side_ = std::move(side);
  weight_ = {0, 0};
  cut_ = 0;
  for (int v = 0; v < graph_.size(); ++v) {
    weight_[side_[v]] += graph_.weight[v];
    for (int e = graph_.first[v]; e < graph_.first[v + 1]; ++e)
      if (side_[v] < side_[graph_.list[e]]) cut_ += graph_.edge_weight[e];
  }
}

void Halves::grow(int seed) {
  take(std::vector<char>(graph_.size(), 1));
  std::priority_queue<std::tuple<int, int>> edge;  // gain, vertex; old entries stay until they come up
  edge.emplace(gain(seed), seed);
  for (int next = 0; 2 * weight_[0] < total_;) {
    if (edge.empty()) {  // another component
      while (side_[next] == 0) ++next;
      edge.emplace(gain(next), next);
    }
    const auto [g, v] = edge.top();
    edge.pop();
    if (side_[v] == 0 || g != gain(v)) continue;
    move(v);
    for (int e = graph_.first[v]; e < graph_.first[v + 1]; ++e)
      if (side_[graph_.list[e]] == 1) edge.emplace(gain(graph_.list[e]), graph_.list[e]);
  }
}

bool Halves::round() {
  std::array<std::priority_queue<std::tuple<int, int>>, 2> movable;
  std::vector<char> moved(graph_.size(), 0);
  const auto offer = [&](int v) { movable[side_[v]].emplace(gain(v), v); };
  for (int v = 0; v < graph_.size(); ++v) {
    bool at_cut = false;
    for (int e = graph_.first[v]; e < graph_.first[v + 1] && !at_cut; ++e)
      at_cut = side_[graph_.list[e]] != side_[v];
    if (at_cut) offer(v);
  }
  const auto top_of = [&](int half) {
    auto& queue = movable[half];
    while (!queue.empty()) {
      const auto [g, v] = queue.top();
      if (!moved[v] && side_[v] == half && g == gain(v)) return v;
      queue.pop();
    }
    return -1;
  };
  std::vector<int> moves;
  size_t kept = 0;
  const int before_cut = cut_, before_excess = excess();
  int best_cut = cut_, best_excess = before_excess;
  while (moves.size() - kept < kIdleMoves) {
    int best = -1;
    for (const int half : {0, 1}) {
      const int v = top_of(half);
      if (v < 0) continue;
      if (weight_[1 - half] + graph_.weight[v] > allowed()) continue;
      if (best < 0 || gain(v) > gain(best) || (gain(v) == gain(best) && weight_[half] > weight_[1 - half]))
        best = v;
    }
    if (best < 0) break;
    movable[side_[best]].pop();
    moved[best] = 1;
    move(best);
    moves.push_back(best);
    for (int e = graph_.first[best]; e < graph_.first[best + 1]; ++e)
      if (!moved[graph_.list[e]]) offer(graph_.list[e]);
    if (std::pair(excess(), cut_) < std::pair(best_excess, best_cut)) {
      best_excess = excess();
      best_cut = cut_;
      kept = moves.size();
    }
  }
  while (moves.size() > kept) {
    move(moves.back());
    moves.pop_back();
  }
  return std::pair(best_excess, best_cut) < std::pair(before_excess, before_cut);
}

void Halves::refine() {
  for (int i = 0; i < kRounds && round(); ++i) {
  }
}

/// Halves of a graph with few edges between them. @return per vertex its half.
std::vector<char> bisect(const WeightedGraph& graph, Random& random, const Progress& progress) {
  progress.report("ordering", 0.5);
  if (graph.size() > kCoarsest) {
    const auto [coarse, count] = matched(graph, random);
    if (count < 0.95 * graph.size()) {
      const WeightedGraph smaller = coarsened(graph, coarse, count);
      const std::vector<char> halves = bisect(smaller, random, progress);
      std::vector<char> side(graph.size());
      for (int v = 0; v < graph.size(); ++v) side[v] = halves[coarse[v]];
      Halves fine(graph);
      fine.take(std::move(side));
      fine.refine();
      return fine.side();
    }
  }
  Halves best(graph);
  for (int start = 0; start < kStarts; ++start) {
    Halves trial(graph);
    trial.grow(static_cast<int>(random.below(graph.size())));
    trial.refine();
    if (start == 0 || std::pair(trial.excess(), trial.cut()) < std::pair(best.excess(), best.cut()))
      best.take(trial.side());
  }
  return best.side();
}

/// The fewest vertices that touch all edges between the halves (König's theorem): those of half 0 that no
/// alternating path from a free vertex of it reaches, and those of half 1 that one reaches.
class Cover {
 public:
  Cover(const WeightedGraph& graph, const std::vector<char>& side)
      : graph_(graph), side_(side), partner_(graph.size(), -1), seen_(graph.size(), 0) {
    int turn = 0;
    for (int v = 0; v < graph_.size(); ++v)
      if (side_[v] == 0) augment(v, ++turn);
    std::fill(seen_.begin(), seen_.end(), 0);
    for (int v = 0; v < graph_.size(); ++v)
      if (side_[v] == 0 && partner_[v] < 0) augment(v, 1);
  }
  bool contains(int v) const { return partner_[v] >= 0 && (side_[v] == 0 ? seen_[v] == 0 : seen_[v] == 1); }

 private:
  /// Whether v or one behind it finds a partner; breadth would not shorten it: cuts are small.
  bool augment(int v, int turn) {
    seen_[v] = turn;
    for (int e = graph_.first[v]; e < graph_.first[v + 1]; ++e) {
      const int u = graph_.list[e];
      if (side_[u] == 0 || seen_[u] == turn) continue;
      seen_[u] = turn;
      if (partner_[u] >= 0 && !augment(partner_[u], turn)) continue;
      partner_[u] = v;
      partner_[v] = u;
      return true;
    }
    return false;
  }

  const WeightedGraph& graph_;
  const std::vector<char>& side_;
  std::vector<int> partner_, seen_;
};

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
      const Cover cover(part, side);
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
