#include <algorithm>
#include <array>
#include <queue>
#include <tuple>
#include <utility>

#include "batten/linalg/bisection_detail.hpp"

namespace batten::detail {

namespace {

/// A graph with weights is coarsened until it has so few vertices.
constexpr int kCoarsest = 60;
/// Starts of the first bisection, of which the best is kept.
constexpr int kStarts = 6;
/// A half may have so large a part of the weight.
constexpr double kLargestHalf = 0.55;
/// Rounds of moves at each level, and moves in a row without gain after which a round ends.
constexpr int kRounds = 4, kIdleMoves = 60;

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

}  // namespace

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

VertexCover::VertexCover(const WeightedGraph& graph, const std::vector<char>& side)
    : graph_(graph), side_(side), partner_(graph.size(), -1), seen_(graph.size(), 0) {
  int turn = 0;
  for (int v = 0; v < graph_.size(); ++v)
    if (side_[v] == 0) augment(v, ++turn);
  std::fill(seen_.begin(), seen_.end(), 0);
  for (int v = 0; v < graph_.size(); ++v)
    if (side_[v] == 0 && partner_[v] < 0) augment(v, 1);
}

bool VertexCover::augment(int v, int turn) {
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

}  // namespace batten::detail
