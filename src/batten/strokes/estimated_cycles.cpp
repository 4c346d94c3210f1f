#include "batten/strokes/estimated_cycles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/network/cycles.hpp"
#include "batten/strokes/node_orders_detail.hpp"

namespace batten {

namespace {

using detail::LinkGraph;
using detail::NetworkLink;
using Eigen::Vector3d;

/// Pieces that a link counts as in the outline of a patch.
constexpr size_t kPieces = 10;
/// A region is outside when its normal and those of its neighbours differ by more than this on average: it
/// folds back. (Three patches around an axis differ by 120 degrees, and close.)
const double kFoldedBack = std::cos(radians(140));
/// And they differ by more than this from each neighbour: the back of a flat body has sides.
const double kNoEdge = std::cos(radians(115));
/// The curves of a node lie in a plane when they leave it by no more than this (root mean square).
constexpr double kPlanar = 0.2;
/// A patch beside a curve that passes through a T turned away this far from the plane of the T shows an edge.
const double kEdge = std::cos(radians(55));

/// A region between curves: what the walk over following half-edges goes around.
struct Region {
  std::vector<int> half_edges;    ///< of links
  std::vector<Vector3d> outline;  ///< thinned; closed, the first point not repeated
  bool only_border = true;
  bool outside = false;
};

class Estimate {
 public:
  Estimate(const CurveNetwork& network, const Progress& progress)
      : network_(network), progress_(progress), graph_(detail::link_graph(network)) {}

  EstimatedCycles run() {
    if (network_.curves.empty()) throw InvalidInput("the network has no curves; there is nothing to surface");
    size_ = detail::network_size(network_, graph_);
    detail::OrderSearchResult search = detail::search_node_orders(network_, graph_, progress_);
    orders_ = std::move(search.orders);
    trace();
    look_at_patches();
    find_outside();
    progress_.report("cycles", 0.9);
    normals_at_nodes();
    normals_along_links();
    turn_outward();
    EstimatedCycles result;
    result.normals = normals_;
    count(result);
    CurveNetwork with_normals = network_;
    with_normals.normals = normals_;
    CycleReport report = detail::collect_cycles(with_normals, node_orders());
    result.cycles = std::move(report.cycles);
    tell_open_curves(result);
    result.warnings.insert(result.warnings.end(), report.warnings.begin(), report.warnings.end());
    for (const detail::DoubtfulOrder& doubt : search.doubtful) result.warnings.push_back(in_words(doubt));
    return result;
  }

 private:
  Vector3d point(int v) const { return network_.positions.row(v); }
  int node_of(int half_edge) const {
    const NetworkLink& link = graph_.links[at(half_edge / 2)];
    return half_edge % 2 == 0 ? link.from : link.to;
  }

  void trace() {
    const size_t n_links = graph_.links.size();
    samples_.resize(n_links);
    for (size_t l = 0; l < n_links; ++l) {
      const size_t edges = graph_.links[l].vertices.size() - 1, pieces = std::min(edges, kPieces);
      for (size_t i = 0; i <= pieces; ++i) samples_[l].push_back(static_cast<int>(edges * i / pieces));
    }
    const std::vector<int> follow = detail::following_half_edges(orders_, 2 * n_links);
    region_of_.assign(2 * n_links, -1);
    for (size_t first = 0; first < follow.size(); ++first) {
      if (region_of_[first] >= 0) continue;
      Region region;
      for (auto d = static_cast<int>(first); region_of_[at(d)] < 0; d = follow[at(d)]) {
        region_of_[at(d)] = static_cast<int>(regions_.size());
        region.half_edges.push_back(d);
        const NetworkLink& link = graph_.links[at(d / 2)];
        region.only_border = region.only_border && link.border;
        const std::vector<int>& samples = samples_[at(d / 2)];
        for (size_t i = 0; i + 1 < samples.size(); ++i)
          region.outline.push_back(
              point(link.vertices[at(d % 2 == 0 ? samples[i] : samples[samples.size() - 1 - i])]));
      }
      regions_.push_back(std::move(region));
    }
  }

  /// The mean normal of the patch that an outline bounds, seen from x: the cone to every edge weighted with
  /// the angle under which x sees it. On a flat outline, convex or not, this is its normal times the angle
  /// inside at x.
  static Vector3d view(const Region& region, const Vector3d& x) {
    Vector3d sum = Vector3d::Zero();
    const size_t n = region.outline.size();
    Vector3d a = region.outline[n - 1] - x;
    double length_a = a.norm();
    for (size_t i = 0; i < n; ++i) {
      const Vector3d b = region.outline[i] - x;
      const double length_b = b.norm(), both = length_a * length_b;
      // 2 tan(θ/2) for θ, bounded where x all but lies on the edge.
      if (both > 0) sum += a.cross(b) * (2 / std::max(both + a.dot(b), 0.1 * both));
      a = b;
      length_a = length_b;
    }
    return sum;
  }

  /// Unit normals of the patches beside every inner sample of every link.
  void look_at_patches() {
    views_.resize(2 * graph_.links.size());
    for (size_t d = 0; d < views_.size(); ++d) {
      const Region& region = regions_[at(region_of_[d])];
      const std::vector<int>& samples = samples_[d / 2];
      for (size_t i = 1; i + 1 < samples.size(); ++i) {
        const Vector3d normal = view(region, point(graph_.links[d / 2].vertices[at(samples[i])]));
        views_[d].push_back(normal.norm() > 0 ? Vector3d(normal.normalized()) : normal);
      }
    }
  }

  /// Cosines between the normals of a region and of those beside it: the mean along its whole outline, and
  /// the greatest mean along one link.
  struct Agreement {
    double mean = 1, greatest = 1;
  };
  Agreement agreement(const Region& region) const {
    Agreement result;
    double sum = 0, length = 0, greatest = -1;
    for (const int d : region.half_edges) {
      const std::vector<Vector3d>&own = views_[at(d)], &other = views_[at(d ^ 1)];
      double of_link = 0;
      for (size_t i = 0; i < own.size(); ++i)
        of_link += own[i].dot(other[i]) / static_cast<double>(own.size());
      if (own.empty()) continue;
      sum += graph_.links[at(d / 2)].length * of_link;
      length += graph_.links[at(d / 2)].length;
      greatest = std::max(greatest, of_link);
    }
    if (length > 0) result = {sum / length, greatest};
    return result;
  }

  void find_outside() {
    std::vector<Agreement> agreements;
    for (const Region& region : regions_) agreements.push_back(agreement(region));
    std::vector<int> by_agreement(regions_.size());
    std::iota(by_agreement.begin(), by_agreement.end(), 0);
    std::stable_sort(by_agreement.begin(), by_agreement.end(),
                     [&](int a, int b) { return agreements[at(a)].mean < agreements[at(b)].mean; });
    std::vector<char> has_tags(at(graph_.topology.n_components), 0);
    for (const NetworkLink& link : graph_.links)
      if (link.border) has_tags[at(component(link.from))] = 1;
    const auto beside_outside = [&](const Region& region) {
      return std::any_of(region.half_edges.begin(), region.half_edges.end(),
                         [&](int d) { return regions_[at(region_of_[at(d ^ 1)])].outside; });
    };
    for (const int r : by_agreement) {
      Region& region = regions_[at(r)];
      const bool tagged = has_tags[at(component(node_of(region.half_edges.front())))] != 0;
      const bool may_be = tagged
                              ? region.only_border
                              : agreements[at(r)].mean < kFoldedBack && agreements[at(r)].greatest < kNoEdge;
      if (may_be && !beside_outside(region)) region.outside = true;
    }
  }

  int component(int node) const { return graph_.topology.component_of_node[at(node)]; }

  void normals_at_nodes() {
    node_normals_.assign(graph_.half_edges.size(), Vector3d::Zero());
    for (size_t n = 0; n < orders_.size(); ++n) {
      const std::vector<int>& around = orders_[n];
      if (around.empty()) continue;
      const Vector3d x = point(graph_.topology.nodes[n]);
      std::vector<Vector3d> tangents;
      tangents.reserve(around.size());
      for (const int d : around) tangents.push_back(detail::link_direction(network_, graph_, d, size_));
      // What the sectors turn about, and what the patches look like.
      Vector3d turn = Vector3d::Zero(), mean = Vector3d::Zero(), across = Vector3d::Zero();
      double widest = 0, weights = 0;
      for (size_t i = 0; i < around.size(); ++i) {
        const Region& region = regions_[at(region_of_[at(around[i])])];
        if (region.outside) continue;
        const Vector3d &a = tangents[i], &b = tangents[(i + 1) % around.size()];
        const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
        turn += a.cross(b);
        const Vector3d seen = view(region, x);
        if (!(seen.norm() > 0)) continue;
        mean += std::max(angle, 0.1) * seen.normalized();
        weights += std::max(angle, 0.1);
        if (angle > widest) {
          widest = angle;
          across = seen.normalized();
        }
      }
      Vector3d normal = mean.norm() > 0.01 * weights ? mean : turn;
      Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
      for (const Vector3d& t : tangents) moments += t * t.transpose();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
      const auto k = static_cast<double>(around.size());
      if (solver.eigenvalues()(0) < kPlanar * kPlanar * k && solver.eigenvalues()(1) > 0.1 * k) {
        Vector3d plane = solver.eigenvectors().col(0);
        if (plane.dot(turn.norm() > 0.3 ? turn : normal) < 0) plane = -plane;
        // A curve that passes through a T may be an edge: then the far patch looks elsewhere.
        const bool at_edge = widest > radians(150) && across.dot(plane) < kEdge;
        if (!at_edge) normal = plane;
      }
      node_normals_[n] = normal.norm() > 0 ? Vector3d(normal.normalized()) : tangents[0].unitOrthogonal();
    }
  }

  void normals_along_links() {
    normals_.resize(network_.positions.rows(), 3);
    normals_.rowwise() = Eigen::RowVector3d::UnitZ();
    for (size_t l = 0; l < graph_.links.size(); ++l) normals_along(static_cast<int>(l));
    for (size_t n = 0; n < node_normals_.size(); ++n)
      if (!orders_[n].empty()) normals_.row(graph_.topology.nodes[n]) = node_normals_[n];
  }

  /// The normal along a link as an angle in a rotation-minimising frame: the line between the angles at its
  /// nodes plus the two lowest bubbles that fit what the patches on both sides look like.
  void normals_along(int l) {
    const NetworkLink& link = graph_.links[at(l)];
    const size_t n = link.vertices.size();
    std::vector<Vector3d> tangents(n), first(n), second(n);
    std::vector<double> along(n, 0);
    for (size_t i = 0; i < n; ++i) {
      if (i > 0) along[i] = along[i - 1] + (point(link.vertices[i]) - point(link.vertices[i - 1])).norm();
      Vector3d t = Vector3d::Zero();
      if (i > 0) t += (point(link.vertices[i]) - point(link.vertices[i - 1])).normalized();
      if (i + 1 < n) t += (point(link.vertices[i + 1]) - point(link.vertices[i])).normalized();
      tangents[i] = t.norm() > 1e-9 ? Vector3d(t.normalized()) : tangents[i - 1];
      if (i == 0) {
        first[0] = tangents[0].unitOrthogonal();
      } else {
        const Vector3d v = detail::carried(first[i - 1], tangents[i - 1], tangents[i]);
        first[i] = (v - tangents[i] * tangents[i].dot(v)).normalized();
      }
      second[i] = tangents[i].cross(first[i]);
    }
    const auto angle = [&](size_t i, const Vector3d& v) {
      return std::atan2(v.dot(second[i]), v.dot(first[i]));
    };
    const auto near = [](double value, double to) { return to + std::remainder(value - to, 2 * kPi); };
    const double begin = angle(0, node_normals_[at(link.from)]);
    std::vector<std::array<double, 2>> seen;  // place along the link from 0 to 1, angle
    double last = begin;
    const Region &left = regions_[at(region_of_[at(2 * l)])],
                 &right = regions_[at(region_of_[at(2 * l + 1)])];
    for (size_t i = 1; i + 1 < samples_[at(l)].size(); ++i) {
      const size_t k = at(samples_[at(l)][i]);
      const Vector3d mean = (left.outside ? 0.0 : 1.0) * views_[at(2 * l)][i - 1] +
                            (right.outside ? 0.0 : 1.0) * views_[at(2 * l + 1)][i - 1];
      const Vector3d across = mean - tangents[k] * tangents[k].dot(mean);
      if (across.norm() < 0.2) continue;  // the patches contradict each other here
      last = near(angle(k, across), last);
      seen.push_back({along[k] / along.back(), last});
    }
    const double end = near(angle(n - 1, node_normals_[at(link.to)]), last);
    Eigen::Matrix2d A = 1e-3 * Eigen::Matrix2d::Identity();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (const auto& [s, value] : seen) {
      const Eigen::Vector2d bubbles(s * (1 - s), s * (1 - s) * (2 * s - 1));
      A += bubbles * bubbles.transpose();
      b += bubbles * (value - begin - s * (end - begin));
    }
    const Eigen::Vector2d c = A.ldlt().solve(b);
    for (size_t i = 1; i + 1 < n; ++i) {
      const double s = along[i] / along.back();
      const double phi = begin + s * (end - begin) + s * (1 - s) * (c(0) + c(1) * (2 * s - 1));
      normals_.row(link.vertices[i]) = std::cos(phi) * first[i] + std::sin(phi) * second[i];
    }
  }

  /// Turns every component over whose normals point inwards.
  void turn_outward() {
    const auto n_components = at(graph_.topology.n_components);
    std::vector<Vector3d> centre(n_components, Vector3d::Zero());
    std::vector<double> count(n_components, 0), volume(n_components, 0);
    for (const Region& region : regions_) {
      const size_t c = at(component(node_of(region.half_edges.front())));
      for (const Vector3d& p : region.outline) centre[c] += p;
      count[c] += static_cast<double>(region.outline.size());
    }
    std::vector<Vector3d> area(n_components, Vector3d::Zero());
    for (const Region& region : regions_) {
      if (region.outside) continue;
      const size_t c = at(component(node_of(region.half_edges.front())));
      const Vector3d o = centre[c] / count[c];
      Vector3d middle = Vector3d::Zero(), vector_area = Vector3d::Zero();
      const size_t n = region.outline.size();
      for (size_t i = 0; i < n; ++i) {
        middle += (region.outline[i] - o) / static_cast<double>(n);
        vector_area += 0.5 * (region.outline[i] - o).cross(region.outline[(i + 1) % n] - o);
      }
      volume[c] += middle.dot(vector_area) / 3;
      area[c] += vector_area;
    }
    for (size_t c = 0; c < n_components; ++c) {
      bool inwards = volume[c] < 0;
      // A flat surface has no outside; its normals then point along the positive axes.
      if (std::abs(volume[c]) < 1e-4 * std::pow(area[c].norm(), 1.5)) {
        Eigen::Index axis = 0;
        area[c].cwiseAbs().maxCoeff(&axis);
        inwards = area[c](axis) < 0;
      }
      if (inwards) turn_over(static_cast<int>(c));
    }
  }

  void turn_over(int c) {
    for (size_t n = 0; n < orders_.size(); ++n)
      if (component(static_cast<int>(n)) == c) {
        std::reverse(orders_[n].begin(), orders_[n].end());
        node_normals_[n] = -node_normals_[n];
        normals_.row(graph_.topology.nodes[n]) *= -1;
      }
    for (size_t l = 0; l < graph_.links.size(); ++l) {
      const NetworkLink& link = graph_.links[l];
      if (component(link.from) != c) continue;
      for (size_t i = 1; i + 1 < link.vertices.size(); ++i)
        // Nodes that the link passes through were turned above.
        if (graph_.topology.node_of_vertex[at(link.vertices[i])] < 0) normals_.row(link.vertices[i]) *= -1;
      std::swap(region_of_[2 * l], region_of_[2 * l + 1]);
    }
  }

  detail::NodeOrders node_orders() const {
    detail::NodeOrders result;
    const std::vector<NetworkSegment>& segments = graph_.topology.segments;
    result.half_edges.resize(graph_.topology.nodes.size());
    result.outside.assign(2 * segments.size(), 0);
    for (size_t n = 0; n < orders_.size(); ++n)
      for (const int d : orders_[n]) {
        const NetworkLink& link = graph_.links[at(d / 2)];
        result.half_edges[n].push_back(d % 2 == 0 ? link.half_edges.front() : link.half_edges.back() ^ 1);
      }
    for (size_t s = 0; s < segments.size(); ++s)  // nodes that links pass through
      for (const int half_edge : {static_cast<int>(2 * s), static_cast<int>(2 * s + 1)}) {
        const int n = half_edge % 2 == 0 ? segments[s].from : segments[s].to;
        if (orders_[at(n)].empty()) result.half_edges[at(n)].push_back(half_edge);
      }
    for (size_t d = 0; d < region_of_.size(); ++d) {
      if (!regions_[at(region_of_[d])].outside) continue;
      for (const int half_edge : graph_.links[d / 2].half_edges)
        result.outside[at(d % 2 == 0 ? half_edge : half_edge ^ 1)] = 1;
    }
    return result;
  }

  /// Curves with one patch that are not tagged as border.
  void tell_open_curves(EstimatedCycles& result) const {
    std::vector<int> n_patches(graph_.topology.segments.size(), 0);
    for (const NetworkCycle& cycle : result.cycles)
      for (const NetworkCycle::Loop& loop : cycle.loops)
        for (const int s : loop.segments) ++n_patches[at(s < 0 ? ~s : s)];
    std::set<int> curves;
    for (size_t s = 0; s < n_patches.size(); ++s) {
      const NetworkSegment& segment = graph_.topology.segments[s];
      if (n_patches[s] < 2 && !segment.boundary) curves.insert(segment.curve);
    }
    result.open_curves.assign(curves.begin(), curves.end());
  }

  void count(EstimatedCycles& result) const {
    int characteristic = static_cast<int>(regions_.size()) - static_cast<int>(graph_.links.size());
    for (const std::vector<int>& around : orders_) characteristic += !around.empty();
    result.n_handles = graph_.topology.n_components - characteristic / 2;
    for (size_t l = 0; l < graph_.links.size(); ++l)
      result.n_one_sided += region_of_[2 * l] == region_of_[2 * l + 1];
  }

  std::string in_words(const detail::DoubtfulOrder& doubt) const {
    const int vertex = graph_.topology.nodes[at(doubt.node)];
    std::string names;
    std::set<int> told;
    for (const int d : orders_[at(doubt.node)]) {
      const std::vector<int>& half_edges = graph_.links[at(d / 2)].half_edges;
      const int half_edge = d % 2 == 0 ? half_edges.front() : half_edges.back();
      const int curve = graph_.topology.segments[at(half_edge / 2)].curve;
      if (told.insert(curve).second) names += (names.empty() ? "" : ", ") + curve_name(network_, curve);
    }
    const Vector3d x = point(vertex);
    const std::string place = concat("vertex ", vertex, " at (", x.x(), ", ", x.y(), ", ", x.z(), ")");
    return doubt.turned_over
               ? concat("which patches continue each other past ", place, " is not certain (", names,
                        "); look at them, and draw a curve across the one that is wrong")
               : concat("the order of the curves around ", place, " is not certain (", names,
                        "); look at the patches there, and draw a curve across the one that is wrong");
  }

  const CurveNetwork& network_;
  const Progress& progress_;
  LinkGraph graph_;
  double size_ = 0;
  std::vector<std::vector<int>> orders_;   ///< per node: link half-edges counter-clockwise
  std::vector<std::vector<int>> samples_;  ///< per link: places in its vertex list
  std::vector<int> region_of_;             ///< per link half-edge
  std::vector<Region> regions_;
  std::vector<std::vector<Vector3d>> views_;  ///< per link half-edge, at the inner samples of the link
  std::vector<Vector3d> node_normals_;
  Points normals_;
};

}  // namespace

EstimatedCycles estimate_cycles(const CurveNetwork& network, const Progress& progress) {
  return Estimate(network, progress).run();
}

}  // namespace batten
