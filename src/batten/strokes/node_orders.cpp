#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <Eigen/Dense>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/strokes/candidate_orders_detail.hpp"
#include "batten/strokes/node_orders_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Gain of a patch more (two patches more are a handle less), and cost of a curve with the same patch on both
/// sides. Both decide only where the geometry leaves a choice: a right angle that is wrong costs one.
constexpr double kPatchGain = 0.12;
constexpr double kSamePatchCost = 0.12;
/// Links that would cost this little more with one end turned over do not tell the sides of their ends.
constexpr std::array<double, 2> kLooseLinks{0.15, 0.6};
/// A choice that wins by less than this is told. Two patches more gain 0.24.
constexpr double kDoubt = 0.15;

/// Sectors of all nodes together, k³ of one with k curves: more are a tangle, in which no order is sure.
constexpr double kMostSectors = 2e7;

/// What the two patches beside a half-edge look like at its node: directions square to the half-edge, in a
/// frame that is carried along the link, with the certainty as length.
struct Sides {
  Vector2d left, right;
};

struct Node {
  std::vector<int> half_edges;
  std::vector<Vector3d> tangents;
  std::vector<NodeOrder> orders;
  std::vector<Sides> sides;  ///< k³: place, left neighbour, right neighbour

  const Sides& sides_of(const NodeOrder& order, int place) const {
    const size_t k = half_edges.size();
    return sides[(at(place) * k + at(order.left[at(place)])) * k + at(order.right[at(place)])];
  }
};

/// Cost of two directions that should be one: 0 when equal, the product of the certainties when opposite.
double mismatch(const Vector2d& a, const Vector2d& b) {
  return 0.5 * (std::sqrt(a.squaredNorm() * b.squaredNorm()) - a.dot(b));
}

class OrderSearch {
 public:
  OrderSearch(const CurveNetwork& network, const LinkGraph& graph, const Progress& progress)
      : network_(network),
        graph_(graph),
        progress_(progress),
        size_(network_size(network, graph)),
        nodes_(graph.half_edges.size()) {}

  OrderSearchResult run() {
    prepare();
    grow();
    progress_.report("cycles", 0.3);
    settle();
    progress_.report("cycles", 0.5);
    follow_ = following_half_edges(current_orders(), 2 * graph_.links.size());
    for (int round = 0; round < 6; ++round) {
      bool changed = change_single_nodes();
      for (const double loose : kLooseLinks) changed = turn_over_groups(loose) || changed;
      progress_.report("cycles", 0.5 + round / 12.0);
      if (!changed) break;
    }
    OrderSearchResult result;
    result.orders = current_orders();
    result.doubtful = std::move(doubtful_);
    look_for_doubts(result.doubtful);
    return result;
  }

 private:
  Vector3d point(int v) const { return network_.positions.row(v); }
  int start_node(int half_edge) const {
    const NetworkLink& link = graph_.links[at(half_edge / 2)];
    return half_edge % 2 == 0 ? link.from : link.to;
  }

  /// Frames square to both ends of a link, the second carried along the link from the first.
  void link_frames(int l, const Vector3d& first, const Vector3d& last, std::array<Vector3d, 2>& at_from,
                   std::array<Vector3d, 2>& at_to) const {
    const NetworkLink& link = graph_.links[at(l)];
    at_from[0] = first.unitOrthogonal();
    at_from[1] = first.cross(at_from[0]);
    at_to = at_from;
    // Chords of equal numbers of edges: the frame hardly depends on how many, noise does.
    const size_t edges = link.vertices.size() - 1, pieces = std::min<size_t>(edges, 24);
    Vector3d tangent = first;
    for (size_t i = 0; i <= pieces; ++i) {
      const Vector3d next = i == pieces ? last
                                        : Vector3d(point(link.vertices[edges * (i + 1) / pieces]) -
                                                   point(link.vertices[edges * i / pieces]));
      if (!(next.norm() > 0)) continue;
      for (Vector3d& v : at_to) v = carried(v, tangent, next.normalized());
      tangent = next.normalized();
    }
  }

  void prepare() {
    refuse_tangle();
    const size_t n_links = graph_.links.size();
    std::vector<std::array<Vector3d, 2>> frames(2 * n_links);
    std::vector<Vector3d> tangents(2 * n_links);
    for (size_t d = 0; d < 2 * n_links; ++d)
      tangents[d] = link_direction(network_, graph_, static_cast<int>(d), size_);
    for (size_t l = 0; l < n_links; ++l)
      link_frames(static_cast<int>(l), tangents[2 * l], -tangents[2 * l + 1], frames[2 * l],
                  frames[2 * l + 1]);
    for (size_t n = 0; n < nodes_.size(); ++n) {
      Node& node = nodes_[n];
      node.half_edges = graph_.half_edges[n];
      for (const int d : node.half_edges) node.tangents.push_back(tangents[at(d)]);
      std::vector<int> borders;
      for (std::size_t i = 0; i < node.half_edges.size(); ++i)
        if (graph_.links[at(node.half_edges[i] / 2)].border) borders.push_back(static_cast<int>(i));
      node.orders = candidate_orders(node.tangents, borders);
      const size_t k = node.half_edges.size();
      node.sides.resize(k * k * k);
      for (size_t i = 0; i < k; ++i)
        for (size_t l = 0; l < k; ++l)
          for (size_t r = 0; r < k; ++r) {
            const std::array<Vector3d, 2>& frame = frames[at(node.half_edges[i])];
            const auto side = [&](size_t j) {
              return Vector2d(node.tangents[j].dot(frame[0]), node.tangents[j].dot(frame[1]));
            };
            // A sector of nearly a half turn does not show its side. There a surface that passes smoothly
            // under the half-edge is supposed, with less certainty.
            const Vector2d left = side(l), right = side(r);
            Sides& sides = node.sides[(i * k + l) * k + r];
            sides.left = left - 0.5 * (1 - left.norm()) * right;
            sides.right = right - 0.5 * (1 - right.norm()) * left;
          }
    }
    chosen_.assign(nodes_.size(), -1);
  }

  /// @throws InvalidInput where so many curves meet that their orders cannot be tried.
  [[gnu::cold]] void refuse_tangle() const {
    double sectors = 0;
    std::size_t worst = 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      sectors += std::pow(static_cast<double>(graph_.half_edges[n].size()), 3);
      if (graph_.half_edges[n].size() > graph_.half_edges[worst].size()) worst = n;
    }
    if (sectors <= kMostSectors) return;
    const int half_edge = graph_.half_edges[worst].front();
    const std::vector<int>& vertices = graph_.links[at(half_edge / 2)].vertices;
    const Eigen::RowVector3d place =
        network_.positions.row(half_edge % 2 == 0 ? vertices.front() : vertices.back());
    throw InvalidInput(concat("the strokes cross too densely for cycles: ", graph_.half_edges[worst].size(),
                              " pieces meet at (", place[0], ", ", place[1], ", ", place[2],
                              "), and many at other nodes; fewer strokes, a smaller weld tolerance, or a "
                              "surface that needs no cycles (topology implicit)"));
  }

  int place_of(int half_edge) const {
    const std::vector<int>& half_edges = graph_.half_edges[at(start_node(half_edge))];
    return static_cast<int>(std::find(half_edges.begin(), half_edges.end(), half_edge) - half_edges.begin());
  }

  /// Cost of a link between two orders: the patch left of its one end lies right of the other.
  double link_cost(int l, const NodeOrder& from, const NodeOrder& to) const {
    const NetworkLink& link = graph_.links[at(l)];
    const Sides& a = nodes_[at(link.from)].sides_of(from, place_[at(2 * l)]);
    const Sides& b = nodes_[at(link.to)].sides_of(to, place_[at(2 * l + 1)]);
    return mismatch(a.left, b.right) + mismatch(a.right, b.left);
  }

  const NodeOrder& chosen(int n) const { return nodes_[at(n)].orders[at(chosen_[at(n)])]; }

  /// Cost of an order of a node given those chosen at its neighbours; neighbours without one do not count.
  double cost_at(int n, const NodeOrder& order) const {
    double cost = order.cost;
    for (const int d : nodes_[at(n)].half_edges) {
      const NetworkLink& link = graph_.links[at(d / 2)];
      if (link.from == link.to) {
        if (d % 2 == 0) cost += link_cost(d / 2, order, order);
        continue;
      }
      const int other = link.from == n ? link.to : link.from;
      if (chosen_[at(other)] < 0) continue;
      cost +=
          link.from == n ? link_cost(d / 2, order, chosen(other)) : link_cost(d / 2, chosen(other), order);
    }
    return cost;
  }

  /// The cheapest order of a node given its neighbours, and by how much it wins.
  std::pair<int, double> best_order(int n) const {
    const std::vector<NodeOrder>& orders = nodes_[at(n)].orders;
    int best = 0;
    double least = std::numeric_limits<double>::infinity(), second = least;
    for (size_t o = 0; o < orders.size(); ++o) {
      const double cost = cost_at(n, orders[o]);
      if (cost < least) {
        second = least;
        least = cost;
        best = static_cast<int>(o);
      } else {
        second = std::min(second, cost);
      }
    }
    return {best, second - least};
  }

  /// From the surest node outwards, always the node that its neighbours decide most clearly.
  void grow() {
    place_.resize(2 * graph_.links.size());
    for (size_t d = 0; d < place_.size(); ++d) place_[d] = place_of(static_cast<int>(d));
    struct Seed {
      double margin;
      int node;
    };
    std::vector<Seed> seeds;
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].orders.empty()) continue;
      double second = 1;
      for (const NodeOrder& order : nodes_[n].orders)
        if (order.cost > 1e-9) second = std::min(second, order.cost);
      seeds.push_back({second, static_cast<int>(n)});
    }
    std::stable_sort(seeds.begin(), seeds.end(),
                     [](const Seed& a, const Seed& b) { return a.margin > b.margin; });
    std::vector<double> margin(nodes_.size(), -1);
    std::vector<int> best(nodes_.size(), -1);
    std::set<std::pair<double, int>> frontier;  // the negative margin first: the surest node leads
    const auto choose = [&](int n, int order) {
      chosen_[at(n)] = order;
      for (const int d : nodes_[at(n)].half_edges) {
        const int other = start_node(d ^ 1);
        if (chosen_[at(other)] >= 0) continue;
        frontier.erase({-margin[at(other)], other});
        std::tie(best[at(other)], margin[at(other)]) = best_order(other);
        frontier.emplace(-margin[at(other)], other);
      }
    };
    for (const Seed& seed : seeds) {
      if (chosen_[at(seed.node)] >= 0) continue;
      choose(seed.node, best_order(seed.node).first);
      while (!frontier.empty()) {
        const int n = frontier.begin()->second;
        frontier.erase(frontier.begin());
        choose(n, best[at(n)]);
      }
    }
  }

  /// Changes single nodes as long as that costs less, without looking at patches.
  void settle() {
    for (int sweep = 0; sweep < 50; ++sweep) {
      bool changed = false;
      for (size_t n = 0; n < nodes_.size(); ++n) {
        if (nodes_[n].orders.empty()) continue;
        const int best = best_order(static_cast<int>(n)).first;
        if (best == chosen_[n] || cost_at(static_cast<int>(n), nodes_[n].orders[at(best)]) >
                                      cost_at(static_cast<int>(n), chosen(static_cast<int>(n))) - 1e-9)
          continue;
        chosen_[n] = best;
        changed = true;
      }
      if (!changed) break;
    }
  }

  std::vector<int> sequence_of(int n, const NodeOrder& order) const {
    std::vector<int> sequence;
    for (const int place : order.sequence) sequence.push_back(nodes_[at(n)].half_edges[at(place)]);
    return sequence;
  }

  std::vector<std::vector<int>> current_orders() const {
    std::vector<std::vector<int>> orders(nodes_.size());
    for (size_t n = 0; n < nodes_.size(); ++n)
      if (chosen_[n] >= 0) orders[n] = sequence_of(static_cast<int>(n), chosen(static_cast<int>(n)));
    return orders;
  }

  void write_following(int n, const NodeOrder& order) {
    const std::vector<int>& half_edges = nodes_[at(n)].half_edges;
    for (size_t i = 0; i < half_edges.size(); ++i)
      follow_[at(half_edges[at(order.left[i])] ^ 1)] = half_edges[i];
  }

  /// What the patches through some half-edges cost: −gain for each, and the links with one patch on both
  /// sides.
  double patch_cost(const std::vector<int>& half_edges) {
    mark_.resize(follow_.size(), -1);
    std::vector<int> marked;
    int count = 0, twice = 0;
    for (const int first : half_edges) {
      if (mark_[at(first)] >= 0) continue;
      for (int d = first; mark_[at(d)] < 0; d = follow_[at(d)]) {
        mark_[at(d)] = count;
        marked.push_back(d);
        twice += mark_[at(d ^ 1)] == count;
      }
      ++count;
    }
    for (const int d : marked) mark_[at(d)] = -1;
    return kSamePatchCost * twice - kPatchGain * count;
  }

  /// The half-edges that leave a node and those that arrive: the patches around it pass all of them.
  std::vector<int> half_edges_at(int n) const {
    std::vector<int> half_edges = nodes_[at(n)].half_edges;
    const size_t k = half_edges.size();
    for (size_t i = 0; i < k; ++i) half_edges.push_back(half_edges[i] ^ 1);
    return half_edges;
  }

  /// The least that another order of a node costs more, patches counted; its number in `order`.
  double best_change(int n, int& order) {
    const Node& node = nodes_[at(n)];
    const std::vector<int> half_edges = half_edges_at(n);
    const double here = cost_at(n, chosen(n)), patches = patch_cost(half_edges);
    double least = std::numeric_limits<double>::infinity();
    order = -1;
    // The only node of its component: seen from the other side it is the same.
    const bool alone = std::all_of(node.half_edges.begin(), node.half_edges.end(),
                                   [&](int d) { return start_node(d ^ 1) == n; });
    for (size_t o = 0; o < node.orders.size(); ++o) {
      if (static_cast<int>(o) == chosen_[at(n)] || (alone && static_cast<int>(o) == chosen(n).mirrored))
        continue;
      const double local = cost_at(n, node.orders[o]) - here;
      // k patches more at the very most; what could not win or be in doubt is not traced.
      const auto k = static_cast<double>(node.half_edges.size());
      if (local - (kPatchGain + kSamePatchCost) * k >= std::min(least, kDoubt)) continue;
      write_following(n, node.orders[o]);
      const double change = local + patch_cost(half_edges) - patches;
      if (change < least) {
        least = change;
        order = static_cast<int>(o);
      }
    }
    write_following(n, chosen(n));
    return least;
  }

  bool change_single_nodes() {
    bool any = false;
    for (int sweep = 0; sweep < 20; ++sweep) {
      bool changed = false;
      for (size_t n = 0; n < nodes_.size(); ++n) {
        if (nodes_[n].orders.size() < 2) continue;
        int order = -1;
        if (best_change(static_cast<int>(n), order) > -1e-9) continue;
        chosen_[n] = order;
        write_following(static_cast<int>(n), chosen(static_cast<int>(n)));
        changed = any = true;
      }
      if (!changed) break;
    }
    return any;
  }

  /// Groups of nodes that hang together by links that tell the sides clearly; turning over one of them
  /// changes only the loose links around it.
  bool turn_over_groups(double loose) {
    DisjointSets sets(static_cast<int>(nodes_.size()));
    std::vector<double> gain(graph_.links.size(), 0);
    for (size_t l = 0; l < graph_.links.size(); ++l) {
      const NetworkLink& link = graph_.links[l];
      if (link.from == link.to) continue;
      const auto number = static_cast<int>(l);
      gain[l] = link_cost(number, chosen(link.from), mirrored(link.to)) -
                link_cost(number, chosen(link.from), chosen(link.to));
      if (gain[l] > loose) sets.unite(link.from, link.to);
    }
    std::map<int, std::vector<int>> groups;
    for (size_t n = 0; n < nodes_.size(); ++n)
      if (chosen_[n] >= 0) groups[sets.root(static_cast<int>(n))].push_back(static_cast<int>(n));
    // One group of each component stays: turning all of them over changes nothing.
    std::vector<size_t> largest(at(graph_.topology.n_components), 0);
    std::vector<int> keeper(at(graph_.topology.n_components), -1);
    for (const auto& [first, members] : groups) {
      const size_t component = at(graph_.topology.component_of_node[at(first)]);
      if (members.size() <= largest[component]) continue;
      largest[component] = members.size();
      keeper[component] = first;
    }
    bool any = false;
    for (const auto& [first, members] : groups) {
      if (first == keeper[at(graph_.topology.component_of_node[at(first)])]) continue;
      double change = 0;
      std::vector<int> half_edges;
      for (const int n : members)
        for (const int d : nodes_[at(n)].half_edges) {
          half_edges.push_back(d);
          half_edges.push_back(d ^ 1);
          const NetworkLink& link = graph_.links[at(d / 2)];
          if (sets.root(start_node(d ^ 1)) != first)
            change += link_cost(d / 2, chosen(link.from), mirrored(link.to)) -
                      link_cost(d / 2, chosen(link.from), chosen(link.to));
        }
      const double before = patch_cost(half_edges);
      for (const int n : members) write_following(n, mirrored(n));
      const double total = change + patch_cost(half_edges) - before;
      if (total < -1e-9) {
        for (const int n : members) chosen_[at(n)] = chosen(n).mirrored;
        any = true;
        continue;
      }
      for (const int n : members) write_following(n, chosen(n));
      if (total < kDoubt && members.size() > 1 && loose == kLooseLinks.back())
        doubtful_.push_back({first, true, total});
    }
    if (any) doubtful_.clear();  // what was in doubt before is looked at again
    return any;
  }

  const NodeOrder& mirrored(int n) const { return nodes_[at(n)].orders[at(chosen(n).mirrored)]; }

  void look_for_doubts(std::vector<DoubtfulOrder>& doubtful) {
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].orders.size() < 2) continue;
      int order = -1;
      const double margin = best_change(static_cast<int>(n), order);
      if (margin < kDoubt)
        doubtful.push_back({static_cast<int>(n), order == chosen(static_cast<int>(n)).mirrored, margin});
    }
    std::stable_sort(doubtful.begin(), doubtful.end(),
                     [](const DoubtfulOrder& a, const DoubtfulOrder& b) { return a.margin < b.margin; });
  }

  const CurveNetwork& network_;
  const LinkGraph& graph_;
  const Progress& progress_;
  double size_;
  std::vector<Node> nodes_;
  std::vector<int> place_;   ///< per link half-edge: its place in the list of its node
  std::vector<int> chosen_;  ///< per node: number of its order
  std::vector<int> follow_;  ///< per link half-edge
  std::vector<int> mark_;    ///< scratch of patch_cost()
  std::vector<DoubtfulOrder> doubtful_;
};

}  // namespace

Vector3d carried(const Vector3d& v, const Vector3d& a, const Vector3d& b) {
  const double cosine = a.dot(b);
  if (cosine < -1 + 1e-9) return v;  // straight back: any half turn would do
  const Vector3d axis = a.cross(b);
  return v + axis.cross(v) + axis.cross(axis.cross(v)) / (1 + cosine);
}

std::vector<int> following_half_edges(const std::vector<std::vector<int>>& orders, std::size_t n_half_edges) {
  std::vector<int> follow(n_half_edges, -1);
  // With the patch to the left, a walk that arrives by a half-edge leaves by the one clockwise of its twin.
  for (const std::vector<int>& around : orders)
    for (size_t i = 0; i < around.size(); ++i) follow[at(around[(i + 1) % around.size()] ^ 1)] = around[i];
  return follow;
}

OrderSearchResult search_node_orders(const CurveNetwork& network, const LinkGraph& graph,
                                     const Progress& progress) {
  return OrderSearch(network, graph, progress).run();
}

}  // namespace batten::detail
