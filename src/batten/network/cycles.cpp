#include "batten/network/cycles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/network/end_parabola.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Half-edge 2s walks segment s forwards, half-edge 2s + 1 backwards; the patch of a half-edge lies to its
/// left.
using HalfEdge = int;
constexpr HalfEdge twin(HalfEdge d) {
  return d ^ 1;
}

/// A closed walk of half-edges and what is known of the region to its left.
struct Orbit {
  std::vector<HalfEdge> half_edges;
  std::vector<int> vertices;  ///< without repetition at the end
  double turning = 0;         ///< total exterior angle in the tangent planes, radians
  bool only_boundary = true;  ///< no half-edge of a segment that is not on the border
  int component = -1;
};

/// Gauss-Bonnet: the total Gaussian curvature of a patch with these loops is 2π χ − Σ turning.
double total_curvature(int n_loops, double turning) {
  return 2 * kPi * (2 - n_loops) - turning;
}

class CycleFinder {
 public:
  /// @param orders taken as they are; null: from the tangent planes.
  explicit CycleFinder(const CurveNetwork& network, const detail::NodeOrders* orders = nullptr)
      : network_(network), topology_(network_topology(network)), orders_(orders) {}

  CycleReport find() {
    check_input();
    if (orders_ == nullptr)
      order_half_edges();
    else
      take_orders();
    trace_orbits();
    join_facing_loops();
    classify();
    return collect();
  }

 private:
  Vector3d point(int v) const { return network_.positions.row(v); }
  Vector3d normal(int v) const { return normals_.row(v); }
  const NetworkSegment& segment(HalfEdge d) const { return topology_.segments[d / 2]; }
  int start(HalfEdge d) const {
    return d % 2 == 0 ? segment(d).vertices.front() : segment(d).vertices.back();
  }
  int end(HalfEdge d) const { return start(twin(d)); }
  /// The i-th vertex of the half-edge's walk.
  int walk(HalfEdge d, std::size_t i) const {
    const std::vector<int>& vertices = segment(d).vertices;
    return d % 2 == 0 ? vertices[i] : vertices[vertices.size() - 1 - i];
  }
  std::string name(int s) const { return curve_name(network_, topology_.segments[s].curve); }

  void check_input() {
    if (network_.curves.empty()) throw InvalidInput("the network has no curves; there is nothing to surface");
    if (!network_.has_normals())
      throw InvalidInput(
          "the network has no normals, which order the curves around a node; give one unit normal per "
          "vertex");
    normals_ = network_.normals;
    for (const NetworkSegment& s : topology_.segments)
      for (std::size_t i = 0; i < s.vertices.size(); ++i) {
        const int v = s.vertices[i];
        if (!network_.positions.row(v).allFinite())
          throw InvalidInput(concat("vertex ", v, " of ", curve_name(network_, s.curve),
                                    " has a coordinate that is not a number; repair or remove it"));
        if (!network_.normals.row(v).allFinite() || !(network_.normals.row(v).norm() > 0.01))
          throw InvalidInput(concat("vertex ", v, " of ", curve_name(network_, s.curve),
                                    " has no usable normal; give it a unit normal"));
        normals_.row(v) = network_.normals.row(v).normalized();
        if (i > 0 && network_.positions.row(v) == network_.positions.row(s.vertices[i - 1]))
          throw InvalidInput(concat("the vertices ", s.vertices[i - 1], " and ", v, " of ",
                                    curve_name(network_, s.curve),
                                    " lie at the same place; merge them into one"));
      }
  }

  /// The direction in which a half-edge leaves its node: the derivative of the parabola through the node that
  /// fits the first few samples, so that neither a bend nor noise of one sample turns it.
  Vector3d direction(HalfEdge d) const {
    constexpr std::size_t kSamples = 4;
    const std::size_t count = std::min(kSamples, segment(d).vertices.size() - 1);
    detail::EndParabola parabola(point(start(d)));
    for (std::size_t i = 1; i <= count; ++i) parabola.add(point(walk(d, i)));
    return parabola.tangent();
  }

  struct Spoke {
    double angle;
    HalfEdge half_edge;
  };

  /// Signed angle at which two half-edges of one node part, looked at where they are a few degrees apart:
  /// curves that touch have no order at the node itself.
  double parting(HalfEdge a, HalfEdge b) const {
    const int node = start(a);
    const Vector3d x = point(node), N = normal(node);
    double angle = 0;
    const std::size_t count = std::min(segment(a).vertices.size(), segment(b).vertices.size());
    for (std::size_t i = 1; i < std::min<std::size_t>(count, 50); ++i) {
      const Vector3d p = point(walk(a, i)) - x, q = point(walk(b, i)) - x;
      angle = std::atan2(N.dot(p.cross(q)), (p - N * N.dot(p)).dot(q));
      if (std::abs(angle) > radians(4)) break;
    }
    return angle;
  }

  void order_half_edges() {
    const auto n_half_edges = static_cast<HalfEdge>(2 * topology_.segments.size());
    std::vector<std::vector<Spoke>> spokes(topology_.nodes.size());
    for (HalfEdge d = 0; d < n_half_edges; ++d) {
      const int v = start(d);
      const Vector3d N = normal(v);
      Vector3d axis = Vector3d::Zero();
      Eigen::Index least = 0;
      N.cwiseAbs().minCoeff(&least);
      axis[least] = 1;
      const Vector3d u = N.cross(axis).normalized(), w = N.cross(u);
      const Vector3d t = direction(d);
      spokes[topology_.node_of_vertex[v]].push_back({std::atan2(t.dot(w), t.dot(u)), d});
    }
    next_.assign(n_half_edges, -1);
    for (std::size_t node = 0; node < spokes.size(); ++node) {
      std::vector<Spoke>& around = spokes[node];
      if (around.size() == 1) {
        const HalfEdge d = around.front().half_edge;
        throw InvalidInput(concat(name(d / 2), " ends at vertex ", topology_.nodes[node],
                                  " without meeting another curve; join it to the network or remove it"));
      }
      std::sort(around.begin(), around.end(), [](const Spoke& a, const Spoke& b) {
        return a.angle != b.angle ? a.angle < b.angle : a.half_edge < b.half_edge;
      });
      if (around.size() > 2) {
        // Begin after the widest gap: curves that touch then stand side by side, never across the ends.
        std::size_t widest = 0;
        double width = -1;
        for (std::size_t i = 0; i < around.size(); ++i) {
          double gap = around[(i + 1) % around.size()].angle - around[i].angle;
          if (i + 1 == around.size()) gap += 2 * kPi;
          if (gap > width) {
            width = gap;
            widest = i;
          }
        }
        std::rotate(around.begin(),
                    around.begin() + static_cast<std::ptrdiff_t>((widest + 1) % around.size()), around.end());
        for (std::size_t round = 1; round < around.size(); ++round)
          for (std::size_t i = 0; i + 1 < around.size(); ++i) {
            Spoke& first = around[i];
            Spoke& second = around[i + 1];
            const double gap = std::remainder(second.angle - first.angle, 2 * kPi);
            if (std::abs(gap) < radians(4) && parting(first.half_edge, second.half_edge) < 0)
              std::swap(first.half_edge, second.half_edge);
          }
      }
      // With the patch to the left, a walk that arrives by a half-edge leaves by the one clockwise of its
      // twin.
      for (std::size_t i = 0; i < around.size(); ++i)
        next_[twin(around[(i + 1) % around.size()].half_edge)] = around[i].half_edge;
    }
  }

  void take_orders() {
    next_.assign(2 * topology_.segments.size(), -1);
    for (const std::vector<int>& around : orders_->half_edges)
      for (std::size_t i = 0; i < around.size(); ++i)
        next_[twin(around[(i + 1) % around.size()])] = around[i];
  }

  double turning(const std::vector<int>& loop) const {
    double sum = 0;
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i) {
      const int v = loop[i];
      const Vector3d N = normal(v);
      const Vector3d in = point(v) - point(loop[(i + n - 1) % n]), out = point(loop[(i + 1) % n]) - point(v);
      const Vector3d a = in - N * N.dot(in), b = out - N * N.dot(out);
      sum += std::atan2(N.dot(a.cross(b)), a.dot(b));
    }
    return sum;
  }

  void trace_orbits() {
    orbit_of_half_edge_.assign(next_.size(), -1);
    for (HalfEdge first = 0; first < static_cast<HalfEdge>(next_.size()); ++first) {
      if (orbit_of_half_edge_[first] >= 0) continue;
      Orbit orbit;
      orbit.component = topology_.component_of_node[topology_.node_of_vertex[start(first)]];
      HalfEdge d = first;
      do {
        orbit_of_half_edge_[d] = static_cast<int>(orbits_.size());
        orbit.half_edges.push_back(d);
        if (!segment(d).boundary) orbit.only_boundary = false;
        for (std::size_t i = 0; i + 1 < segment(d).vertices.size(); ++i) orbit.vertices.push_back(walk(d, i));
        d = next_[d];
      } while (d != first);
      orbit.turning = turning(orbit.vertices);
      orbits_.push_back(std::move(orbit));
    }
  }

  /// The two orbits may bound one patch: their nearest points see each other to their left, along the
  /// surface.
  bool facing(const Orbit& a, const Orbit& b, double& distance) const {
    std::size_t at_a = 0, at_b = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < a.vertices.size(); ++i)
      for (std::size_t j = 0; j < b.vertices.size(); ++j) {
        const double d = (point(a.vertices[i]) - point(b.vertices[j])).squaredNorm();
        if (d < nearest) {
          nearest = d;
          at_a = i;
          at_b = j;
        }
      }
    distance = std::sqrt(nearest);
    if (distance == 0) return false;
    const Vector3d d = (point(b.vertices[at_b]) - point(a.vertices[at_a])) / distance;
    return leftward(a, at_a).dot(d) > 0.3 && leftward(b, at_b).dot(d) < -0.3;
  }

  /// Unit vector of the tangent plane that points to the left of the walk.
  Vector3d leftward(const Orbit& orbit, std::size_t i) const {
    const std::size_t n = orbit.vertices.size();
    const int v = orbit.vertices[i];
    const Vector3d in = (point(v) - point(orbit.vertices[(i + n - 1) % n])).normalized();
    const Vector3d out = (point(orbit.vertices[(i + 1) % n]) - point(v)).normalized();
    return normal(v).cross(in + out).normalized();
  }

  /// Joins loops of different components into patches with several loops, nearest first, where they face each
  /// other and one patch needs clearly less Gaussian curvature than two.
  void join_facing_loops() {
    group_.resize(orbits_.size());
    for (std::size_t i = 0; i < orbits_.size(); ++i) group_[i] = static_cast<int>(i);
    if (topology_.n_components < 2) return;
    struct Pair {
      double distance;
      int a, b;
    };
    std::vector<Pair> pairs;
    for (std::size_t a = 0; a < orbits_.size(); ++a) {
      if (lies_outside(orbits_[a])) continue;
      for (std::size_t b = a + 1; b < orbits_.size(); ++b) {
        if (orbits_[a].component == orbits_[b].component || lies_outside(orbits_[b]) ||
            !worth_joining({static_cast<int>(a)}, {static_cast<int>(b)}))
          continue;
        double distance = 0;
        if (facing(orbits_[a], orbits_[b], distance))
          pairs.push_back({distance, static_cast<int>(a), static_cast<int>(b)});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
    for (const Pair& pair : pairs) {
      const std::vector<int> a = members(group_[pair.a]), b = members(group_[pair.b]);
      if (group_[pair.a] == group_[pair.b] || !worth_joining(a, b)) continue;
      // One component bounds a patch from one side only: a second loop of it would close a tunnel, which
      // nothing in the network speaks for.
      std::set<int> components;
      for (const int i : a) components.insert(orbits_[i].component);
      if (std::any_of(b.begin(), b.end(), [&](int i) { return components.count(orbits_[i].component) > 0; }))
        continue;
      const int keep = std::min(group_[pair.a], group_[pair.b]),
                drop = std::max(group_[pair.a], group_[pair.b]);
      for (int& g : group_)
        if (g == drop) g = keep;
    }
  }

  std::vector<int> members(int group) const {
    std::vector<int> list;
    for (std::size_t i = 0; i < group_.size(); ++i)
      if (group_[i] == group) list.push_back(static_cast<int>(i));
    return list;
  }

  /// A loop that is a component of its own.
  bool is_lone(const Orbit& orbit) const {
    const int other = orbit_of_half_edge_[twin(orbit.half_edges.front())];
    return orbits_[other].half_edges.size() == orbit.half_edges.size() &&
           std::all_of(orbit.half_edges.begin(), orbit.half_edges.end(),
                       [&](HalfEdge d) { return orbit_of_half_edge_[twin(d)] == other; });
  }

  /// A disc by itself, or one end of a tube.
  bool lone_border(int orbit) const { return orbits_[orbit].only_boundary && is_lone(orbits_[orbit]); }

  /// The outside of a sheet bounds no patch with anything that is near it. The outside of a lone loop may: a
  /// loop drawn on a patch divides it.
  bool lies_outside(const Orbit& orbit) const {
    if (is_lone(orbit)) return false;
    if (orders_ != nullptr) return orders_->outside[orbit.half_edges.front()] != 0;
    // A border whose other side holds curves has its patch there.
    return orbit.only_boundary &&
           std::any_of(orbit.half_edges.begin(), orbit.half_edges.end(),
                       [&](HalfEdge d) { return !orbits_[orbit_of_half_edge_[twin(d)]].only_boundary; });
  }

  bool worth_joining(const std::vector<int>& a, const std::vector<int>& b) const {
    double turning_a = 0, turning_b = 0;
    for (const int i : a) turning_a += orbits_[i].turning;
    for (const int i : b) turning_b += orbits_[i].turning;
    const int loops_a = static_cast<int>(a.size()), loops_b = static_cast<int>(b.size());
    const double joined = std::abs(total_curvature(loops_a + loops_b, turning_a + turning_b));
    const double apart =
        std::abs(total_curvature(loops_a, turning_a)) + std::abs(total_curvature(loops_b, turning_b));
    // The outsides of two flat discs would make a patch of curvature 4π: more than a patch is given.
    if (joined > 3.5 * kPi) return false;
    // Two rims that face each other are a tube even where it narrows strongly (S fig. 4.18, right).
    if (a.size() == 1 && b.size() == 1 && lone_border(a.front()) && lone_border(b.front())) return true;
    return joined + kPi < apart;
  }

  /// Which groups are patches and which lie outside; errors where a border is not tagged.
  void classify() {
    outside_.assign(orbits_.size(), 0);
    // A border segment has a patch on one side. Settle the sides that the rest of the network decides.
    std::vector<double> curvature(orbits_.size(), 0);
    std::vector<char> only_boundary(orbits_.size(), 1), joined(orbits_.size(), 0);
    for (std::size_t i = 0; i < orbits_.size(); ++i) {
      if (group_[i] != static_cast<int>(i)) continue;
      double sum = 0;
      const std::vector<int> list = members(static_cast<int>(i));
      for (const int m : list) {
        sum += orbits_[m].turning;
        if (!orbits_[m].only_boundary) only_boundary[i] = 0;
      }
      joined[i] = list.size() > 1;
      curvature[i] = total_curvature(static_cast<int>(list.size()), sum);
    }
    for (std::size_t s = 0; s < topology_.segments.size(); ++s) {
      if (!topology_.segments[s].boundary) continue;
      const int left = group_[orbit_of_half_edge_[2 * s]], right = group_[orbit_of_half_edge_[2 * s + 1]];
      if (left == right)
        throw InvalidInput(
            concat(name(static_cast<int>(s)),
                   " is tagged as boundary but has the same patch on both sides; remove the tag"));
      const auto rank = [&](int g) {
        // Patches with curves inside them are certain; then those of several loops; then the flatter one.
        return std::array<double, 3>{only_boundary[g] ? 1.0 : 0.0, joined[g] ? 0.0 : 1.0,
                                     std::abs(curvature[g])};
      };
      const std::array<double, 3> l = rank(left), r = rank(right);
      if (orders_ == nullptr && l[0] == 0 && r[0] == 0) {
        // Both sides hold curves that are not tagged. The side whose walk turns the wrong way is outside.
        report_untagged(curvature[left] > curvature[right] ? left : right);
      }
      outside_[l < r ? right : left] = 1;
    }
    if (orders_ != nullptr) {
      for (std::size_t d = 0; d < next_.size(); ++d)
        if (orders_->outside[d] && !joined[group_[orbit_of_half_edge_[d]]])
          outside_[group_[orbit_of_half_edge_[d]]] = 1;
      return;
    }
    for (std::size_t g = 0; g < orbits_.size(); ++g)
      if (group_[g] == static_cast<int>(g) && !outside_[g] && curvature[g] > 3 * kPi)
        report_untagged(static_cast<int>(g));
  }

  [[noreturn]] void report_untagged(int group) const {
    std::set<int> curves;
    for (const int i : members(group))
      for (const HalfEdge d : orbits_[i].half_edges)
        if (!segment(d).boundary) curves.insert(segment(d).curve);
    std::string names;
    for (const int c : curves) names += (names.empty() ? "" : ", ") + curve_name(network_, c);
    throw InvalidInput(concat(
        "the network has a border that is not tagged: ", names, curves.size() == 1 ? " has" : " have",
        " the outside of the surface on one side; tag ", curves.size() == 1 ? "it" : "them", " as boundary"));
  }

  /// Keys that order vertices by place and survive translation and scaling: positions in units of the
  /// diameter, rounded. The odd quantum keeps round coordinates away from the edges of its cells.
  std::vector<std::array<std::int64_t, 3>> place_keys() const {
    constexpr double kQuantum = 0.7548776662466927e-7;
    Eigen::RowVector3d low = Eigen::RowVector3d::Constant(std::numeric_limits<double>::infinity()),
                       high = -low;
    for (const NetworkSegment& s : topology_.segments)
      for (const int v : s.vertices) {
        low = low.cwiseMin(network_.positions.row(v));
        high = high.cwiseMax(network_.positions.row(v));
      }
    const double diameter = (high - low).norm();
    std::vector<std::array<std::int64_t, 3>> keys(network_.positions.rows());
    for (const NetworkSegment& s : topology_.segments)
      for (const int v : s.vertices)
        for (int k = 0; k < 3; ++k)
          keys[v][k] =
              std::llround((network_.positions(v, k) - 0.5 * (low[k] + high[k])) / diameter / kQuantum);
    return keys;
  }

  CycleReport collect() {
    const auto keys = place_keys();
    CycleReport report;
    for (std::size_t g = 0; g < orbits_.size(); ++g) {
      if (group_[g] != static_cast<int>(g) || outside_[g]) continue;
      NetworkCycle cycle;
      for (const int i : members(static_cast<int>(g)))
        cycle.loops.push_back(canonical_loop(orbits_[i], keys));
      std::sort(cycle.loops.begin(), cycle.loops.end(),
                [&](const auto& a, const auto& b) { return before(a.vertices, b.vertices, keys); });
      report.cycles.push_back(std::move(cycle));
    }
    if (report.cycles.empty())
      throw InvalidInput("the network has no patch to fill; its curves form no closed cycle");
    std::sort(report.cycles.begin(), report.cycles.end(), [&](const NetworkCycle& a, const NetworkCycle& b) {
      return before(a.loops.front().vertices, b.loops.front().vertices, keys);
    });
    for (std::size_t c = 0; c < report.cycles.size(); ++c)
      for (const NetworkCycle::Loop& loop : report.cycles[c].loops)
        if (loop.vertices.size() < 3)
          throw InvalidInput(
              concat("the patch between ",
                     name(loop.segments.front() < 0 ? ~loop.segments.front() : loop.segments.front()),
                     " and ", name(loop.segments.back() < 0 ? ~loop.segments.back() : loop.segments.back()),
                     " at vertex ", loop.vertices.front(), " has ", loop.vertices.size(),
                     " vertices; a patch needs at least three, so remove a duplicate curve or sample it more "
                     "densely"));
    return report;
  }

  static bool before(const std::vector<int>& a, const std::vector<int>& b,
                     const std::vector<std::array<std::int64_t, 3>>& keys) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                        [&](int v, int w) { return keys[v] < keys[w]; });
  }

  /// The loop begun at its vertex of least key. (A vertex passed twice: the pass whose successor is least.)
  NetworkCycle::Loop canonical_loop(const Orbit& orbit,
                                    const std::vector<std::array<std::int64_t, 3>>& keys) const {
    const std::size_t n = orbit.vertices.size();
    std::size_t first = 0;
    for (std::size_t i = 1; i < n; ++i) {
      const auto& a = keys[orbit.vertices[i]];
      const auto& b = keys[orbit.vertices[first]];
      if (a < b || (a == b && keys[orbit.vertices[(i + 1) % n]] < keys[orbit.vertices[(first + 1) % n]]))
        first = i;
    }
    NetworkCycle::Loop loop;
    loop.vertices = orbit.vertices;
    std::rotate(loop.vertices.begin(), loop.vertices.begin() + static_cast<std::ptrdiff_t>(first),
                loop.vertices.end());
    // The walk over segments begins with the one that holds the first edge.
    std::size_t passed = 0, begin = 0;
    for (std::size_t i = 0; i < orbit.half_edges.size(); ++i) {
      const std::size_t length = segment(orbit.half_edges[i]).vertices.size() - 1;
      if (first >= passed && first < passed + length) begin = i;
      passed += length;
    }
    for (std::size_t i = 0; i < orbit.half_edges.size(); ++i) {
      const HalfEdge d = orbit.half_edges[(begin + i) % orbit.half_edges.size()];
      loop.segments.push_back(d % 2 == 0 ? d / 2 : ~(d / 2));
    }
    return loop;
  }

  const CurveNetwork& network_;
  NetworkTopology topology_;
  const detail::NodeOrders* orders_;
  Points normals_;
  std::vector<HalfEdge> next_;
  std::vector<Orbit> orbits_;
  std::vector<int> orbit_of_half_edge_;
  std::vector<int> group_;  ///< per orbit: the least orbit of its patch
  std::vector<char> outside_;
};

}  // namespace

CycleReport find_cycles(const CurveNetwork& network) {
  return CycleFinder(network).find();
}

CycleReport detail::collect_cycles(const CurveNetwork& network, const NodeOrders& orders) {
  return CycleFinder(network, &orders).find();
}

}  // namespace batten
