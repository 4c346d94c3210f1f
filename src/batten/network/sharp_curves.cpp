#include "batten/network/sharp_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/network/end_parabola.hpp"
#include "batten/network/sharp_chain_detail.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Two curves span a plane at a node where the sine of their angle is above this.
constexpr double kLeastSine = 0.17;
/// Samples of a curve from which its normal is carried on to its end.
constexpr std::size_t kNormalSamples = 6;

std::pair<int, int> edge_between(int a, int b) {
  return std::minmax(a, b);
}

/// The corners of the patches: places in their loops, joined into parts around each vertex that only sharp
/// curves divide.
class PatchCorners {
 public:
  PatchCorners(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
               const std::vector<char>& sharp)
      : network_(network), topology_(network_topology(network)), parts_(0) {
    const auto n = at(static_cast<int>(network.positions.rows()));
    on_sharp_.assign(n, 0);
    for (std::size_t c = 0; c < network.curves.size(); ++c) {
      if (!sharp[c]) continue;
      const std::vector<int>& walk = network.curves[c].vertices;
      for (std::size_t k = 0; k < walk.size(); ++k) {
        on_sharp_[at(walk[k])] = 1;
        if (k > 0) sharp_edges_.insert({edge_between(walk[k - 1], walk[k]), 1});
      }
    }
    for (std::size_t c = 0; c < cycles.size(); ++c)
      for (const NetworkCycle::Loop& loop : cycles[c].loops) {
        const int first = size(), count = static_cast<int>(loop.vertices.size());
        for (int i = 0; i < count; ++i) {
          vertex_.push_back(loop.vertices[at(i)]);
          cycle_.push_back(static_cast<int>(c));
          next_.push_back(first + (i + 1) % count);
          previous_.push_back(first + (i + count - 1) % count);
          parts_.add();
          leaving_[{loop.vertices[at(i)], loop.vertices[at((i + 1) % count)]}] = first + i;
        }
      }
    for (int c = 0; c < size(); ++c) {
      if (is_sharp(vertex(c), vertex(next(c)))) continue;
      const int other = leaving(vertex(next(c)), vertex(c));
      if (other < 0) continue;
      parts_.unite(c, next(other));
      parts_.unite(next(c), other);
    }
  }

  const CurveNetwork& network() const { return network_; }
  const NetworkTopology& topology() const { return topology_; }
  int size() const { return static_cast<int>(vertex_.size()); }
  int vertex(int corner) const { return vertex_[at(corner)]; }
  int cycle(int corner) const { return cycle_[at(corner)]; }
  int next(int corner) const { return next_[at(corner)]; }
  int previous(int corner) const { return previous_[at(corner)]; }
  /// The corner from which a patch walks from a to b, to the left of that way; −1: none.
  int leaving(int a, int b) const {
    const auto found = leaving_.find({a, b});
    return found == leaving_.end() ? -1 : found->second;
  }
  /// The first corner of the part that holds a corner.
  int part(int corner) { return parts_.root(corner); }
  bool is_sharp(int a, int b) const { return sharp_edges_.count(edge_between(a, b)) > 0; }
  bool on_sharp(int v) const { return on_sharp_[at(v)] != 0; }
  bool is_node(int v) const { return topology_.node_of_vertex[at(v)] >= 0; }

  Vector3d point(int v) const { return network_.positions.row(v); }
  Vector3d normal(int v) const { return network_.normals.row(v); }

  /// The vertices behind a corner, on its loop up to the next node, that node included; at most `count`.
  std::vector<int> walk(int corner, bool forwards, std::size_t count) const {
    std::vector<int> vertices;
    for (int c = corner; vertices.size() < count;) {
      c = forwards ? next(c) : previous(c);
      vertices.push_back(vertex(c));
      if (is_node(vertex(c))) break;
    }
    return vertices;
  }
  /// The direction in which a corner's loop leaves its vertex, to the next or to the previous.
  Vector3d direction(int corner, bool forwards) const {
    detail::EndParabola parabola(point(vertex(corner)));
    for (const int v : walk(corner, forwards, 4)) parabola.add(point(v));
    return parabola.tangent().normalized();
  }
  /// The normal of a curve carried on to the corner where it ends: the parabola over arc length that fits its
  /// samples. @param turn set to the angle between the last two. @return 0 where it has no samples of its
  /// own.
  Vector3d arriving_normal(int corner, bool forwards, double& turn) const {
    std::vector<double> arcs;
    std::vector<Vector3d> normals;
    Vector3d before = point(vertex(corner));
    double arc = 0;
    for (const int v : walk(corner, forwards, kNormalSamples)) {
      arc += (point(v) - before).norm();
      before = point(v);
      if (on_sharp(v)) break;
      arcs.push_back(arc);
      normals.push_back(normal(v));
    }
    if (normals.empty()) return Vector3d::Zero();
    turn =
        normals.size() > 1 ? std::atan2(normals[0].cross(normals[1]).norm(), normals[0].dot(normals[1])) : 0;
    const auto k = static_cast<Eigen::Index>(normals.size());
    const Eigen::Index order = k >= 5 ? 3 : std::min<Eigen::Index>(k, 2);
    Eigen::MatrixXd A(k, order), right(k, 3);
    for (Eigen::Index i = 0; i < k; ++i) {
      for (Eigen::Index j = 0; j < order; ++j) A(i, j) = std::pow(arcs[at(i)] / arc, static_cast<double>(j));
      right.row(i) = normals[at(i)];
    }
    const Eigen::MatrixXd fitted = A.colPivHouseholderQr().solve(right);
    return Vector3d(fitted.row(0)).normalized();
  }

 private:
  const CurveNetwork& network_;
  NetworkTopology topology_;
  DisjointSets parts_;
  std::vector<int> vertex_, cycle_, next_, previous_;
  std::map<std::pair<int, int>, int> leaving_;
  std::map<std::pair<int, int>, char> sharp_edges_;
  std::vector<char> on_sharp_;
};

/// The normals of all parts around vertices of sharp curves.
class PartNormals {
 public:
  PartNormals(PatchCorners& corners, const std::vector<NetworkCycle>& cycles, const std::vector<char>& sharp)
      : corners_(corners), cycles_(cycles), normals_(at(corners.size()), Vector3d::Zero()) {
    take_undivided();
    look_at_nodes();
    for (std::size_t c = 0; c < sharp.size(); ++c)
      if (sharp[c])
        for (const bool left : {true, false}) follow(corners_.network().curves[c], left);
  }

  /// @param part as PatchCorners::part().
  Vector3d of_part(int part) const { return normals_[at(part)]; }

 private:
  bool known(int part) const { return normals_[at(part)].squaredNorm() > 0; }

  /// Where a vertex is one part, sharp curves fade out: it keeps its normal.
  void take_undivided() {
    std::vector<int> part_of(at(static_cast<int>(corners_.network().positions.rows())), -1);
    for (int c = 0; c < corners_.size(); ++c) {
      int& part = part_of[at(corners_.vertex(c))];
      if (part == -1) part = corners_.part(c);
      if (part != corners_.part(c)) part = -2;
    }
    for (std::size_t v = 0; v < part_of.size(); ++v)
      if (part_of[v] >= 0) normals_[at(part_of[v])] = corners_.normal(static_cast<int>(v)).normalized();
  }

  void look_at_nodes() {
    std::vector<Vector3d> sums(normals_.size(), Vector3d::Zero());
    double turn = 0;
    const auto looked_at = [&](int c) {
      const int v = corners_.vertex(c);
      return corners_.on_sharp(v) && corners_.is_node(v) && !known(corners_.part(c));
    };
    for (int c = 0; c < corners_.size(); ++c) {
      if (!looked_at(c)) continue;
      const int v = corners_.vertex(c);
      if (!corners_.is_sharp(v, corners_.vertex(corners_.next(c))))
        sums[at(corners_.part(c))] += corners_.arriving_normal(c, true, turn);
      if (!corners_.is_sharp(v, corners_.vertex(corners_.previous(c))))
        sums[at(corners_.part(c))] += corners_.arriving_normal(c, false, turn);
    }
    // Normals of samples are as good as they were measured, a plane only as good as two tangents.
    const std::vector<Vector3d> arriving = sums;
    for (int c = 0; c < corners_.size(); ++c) {
      if (!looked_at(c) || arriving[at(corners_.part(c))].norm() > 0.1) continue;
      Vector3d plane = corners_.direction(c, true).cross(corners_.direction(c, false));
      const double sine = plane.norm();
      if (sine < kLeastSine) continue;
      // At a corner of more than 180° the plane looks inwards.
      if (plane.dot(corners_.normal(corners_.vertex(c))) < 0) plane = -plane;
      sums[at(corners_.part(c))] += plane / sine;
    }
    for (std::size_t part = 0; part < sums.size(); ++part)
      if (sums[part].norm() > 0.1) normals_[part] = sums[part].normalized();
  }

  /// Goes along one side of a sharp curve, in pieces that one patch after the other borders smoothly.
  void follow(const NetworkCurve& curve, bool left) {
    const Points& given = left ? curve.left_normals : curve.right_normals;
    const bool has_given = given.rows() == static_cast<Eigen::Index>(curve.vertices.size());
    std::vector<detail::SharpChain> chains;
    bool begins_new = true;
    for (std::size_t k = 0; k + 1 < curve.vertices.size(); ++k) {
      const int a = curve.vertices[k], b = curve.vertices[k + 1];
      const int corner = left ? corners_.leaving(a, b) : corners_.leaving(b, a);
      if (corner < 0) {
        begins_new = true;
        continue;
      }
      const int here = left ? corner : corners_.next(corner), there = left ? corners_.next(corner) : corner;
      if (begins_new || corners_.part(chains.back().corners.back()) != corners_.part(here)) {
        chains.emplace_back();
        chains.back().corners.push_back(here);
        chains.back().places.push_back(k);
      }
      chains.back().corners.push_back(there);
      chains.back().places.push_back(k + 1);
      begins_new = false;
    }
    detail::close_chains(curve, chains, [&](int corner) { return corners_.part(corner); });
    for (detail::SharpChain& chain : chains) {
      chain.left = left;
      if (has_given)
        for (std::size_t k = 0; k < chain.corners.size(); ++k)
          if (const int part = corners_.part(chain.corners[k]); !known(part))
            normals_[at(part)] = Vector3d(given.row(static_cast<Eigen::Index>(chain.places[k]))).normalized();
      fill(chain);
    }
  }

  void fill(detail::SharpChain& chain) {
    bool any = false;
    for (const int corner : chain.corners) {
      chain.points.push_back(corners_.point(corners_.vertex(corner)));
      chain.references.push_back(corners_.normal(corners_.vertex(corner)));
      chain.is_node.push_back(corners_.is_node(corners_.vertex(corner)));
      chain.normals.push_back(normals_[at(corners_.part(corner))]);
      any = any || chain.normals.back().squaredNorm() > 0;
    }
    if (any)
      detail::interpolate_normals(chain);
    else
      from_outline(chain);
    for (std::size_t k = 0; k < chain.corners.size(); ++k)
      if (const int part = corners_.part(chain.corners[k]); !known(part))
        normals_[at(part)] = chain.normals[k];
  }

  /// The plane of the outline of the patch, where it lies in one; else the cone from the curve to the middle
  /// of the patch, or to its other outline.
  void from_outline(detail::SharpChain& chain) const {
    for (std::size_t k = 0; k < chain.corners.size(); ++k) {
      const NetworkCycle& cycle = cycles_[at(corners_.cycle(chain.corners[k]))];
      const int v = corners_.vertex(chain.corners[k]);
      const Vector3d x = chain.points[k], t = chain.tangent(k);
      Vector3d area = Vector3d::Zero(), middle = Vector3d::Zero(), nearest = Vector3d::Zero();
      double count = 0, size = 0, off = 0, least = std::numeric_limits<double>::infinity();
      for (const NetworkCycle::Loop& loop : cycle.loops) {
        const bool own = std::find(loop.vertices.begin(), loop.vertices.end(), v) != loop.vertices.end();
        for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
          const Vector3d p = corners_.point(loop.vertices[i]) - x;
          const Vector3d q = corners_.point(loop.vertices[(i + 1) % loop.vertices.size()]) - x;
          area += p.cross(q);
          middle += p;
          ++count;
          size = std::max(size, p.norm());
          if (!own && p.norm() < least) {
            least = p.norm();
            nearest = p;
          }
        }
      }
      const Vector3d plane = area.stableNormalized();
      for (const NetworkCycle::Loop& loop : cycle.loops)
        for (const int w : loop.vertices) off = std::max(off, std::abs(plane.dot(corners_.point(w) - x)));
      Vector3d n = plane;
      if (off > 1e-3 * size) {
        const Vector3d into = cycle.loops.size() > 1 ? nearest : Vector3d(middle / count);
        const Vector3d sideways = chain.left ? t.cross(into) : into.cross(t);
        if (sideways.norm() > 1e-6 * size) n = sideways;
      }
      n -= t * t.dot(n);
      chain.normals[k] = n.norm() > 0 ? n.normalized() : chain.references[k].normalized();
    }
  }

  PatchCorners& corners_;
  const std::vector<NetworkCycle>& cycles_;
  std::vector<Vector3d> normals_;  ///< at the first corner of each part; 0: unknown
};

std::vector<char> tagged_sharp(const CurveNetwork& network) {
  std::vector<char> sharp;
  for (const NetworkCurve& curve : network.curves) sharp.push_back(curve.sharp && !curve.boundary);
  return sharp;
}

}  // namespace

SharpSplit split_at_sharp_curves(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles) {
  const std::vector<char> sharp = tagged_sharp(network);
  PatchCorners corners(network, cycles, sharp);
  const PartNormals normals(corners, cycles, sharp);
  SharpSplit split;
  const auto n = static_cast<int>(network.positions.rows());
  for (int v = 0; v < n; ++v) split.place.push_back(v);
  // The first part of a vertex keeps its number.
  std::vector<int> vertex_of_part(at(corners.size()), -1);
  std::vector<char> taken(at(n), 0);
  std::vector<int> part_of_vertex(at(n), -1);
  const auto vertex_at = [&](int corner) {
    const int v = corners.vertex(corner);
    if (!corners.on_sharp(v)) return v;
    int& vertex = vertex_of_part[at(corners.part(corner))];
    if (vertex >= 0) return vertex;
    vertex = v;
    if (std::exchange(taken[at(v)], 1)) {
      vertex = static_cast<int>(split.place.size());
      split.place.push_back(v);
      part_of_vertex.push_back(-1);
    }
    part_of_vertex[at(vertex)] = corners.part(corner);
    return vertex;
  };
  split.cycles = cycles;
  int corner = 0;
  for (NetworkCycle& cycle : split.cycles)
    for (NetworkCycle::Loop& loop : cycle.loops) {
      loop.segments.clear();
      for (int& v : loop.vertices) v = vertex_at(corner++);
    }
  for (const NetworkSegment& segment : corners.topology().segments)
    for (const bool left : {true, false}) {
      NetworkCurve piece{network.curves[at(segment.curve)].name, segment.boundary, {}};
      for (std::size_t k = 0; k + 1 < segment.vertices.size(); ++k) {
        const int a = segment.vertices[k], b = segment.vertices[k + 1];
        const int c = left ? corners.leaving(a, b) : corners.leaving(b, a);
        if (c < 0) continue;
        if (piece.vertices.empty()) piece.vertices.push_back(vertex_at(left ? c : corners.next(c)));
        piece.vertices.push_back(vertex_at(left ? corners.next(c) : c));
      }
      const bool is_new =
          left || split.network.curves.empty() || piece.vertices != split.network.curves.back().vertices;
      if (piece.vertices.size() > 1 && is_new) split.network.curves.push_back(std::move(piece));
    }
  split.network.unit = network.unit;
  const auto count = static_cast<Eigen::Index>(split.place.size());
  split.network.positions.resize(count, 3);
  split.network.normals.resize(count, 3);
  for (Eigen::Index v = 0; v < count; ++v) {
    split.network.positions.row(v) = network.positions.row(split.place[at(v)]);
    split.network.normals.row(v) = network.normals.row(split.place[at(v)]);
    if (const int part = part_of_vertex[at(v)]; part >= 0)
      split.network.normals.row(v) = normals.of_part(part);
  }
  return split;
}

std::vector<SharpFinding> find_sharp_curves(const CurveNetwork& network,
                                            const std::vector<NetworkCycle>& cycles) {
  constexpr double kLeastJump = radians(20);
  std::vector<SharpFinding> findings;
  const std::vector<char> none(network.curves.size(), 0);
  PatchCorners corners(network, cycles, none);
  for (std::size_t c = 0; c < network.curves.size(); ++c) {
    const NetworkCurve& curve = network.curves[c];
    if (curve.sharp || curve.boundary) continue;
    int n_nodes = 0;
    double least = kPi;
    const auto count = static_cast<int>(curve.vertices.size());
    for (int k = curve.closed() ? 0 : 1; k + 1 < count; ++k) {
      const int v = curve.vertices[at(k)], after = curve.vertices[at(k + 1)];
      const int before = k > 0 ? curve.vertices[at(k - 1)] : curve.vertices[at(count - 2)];
      if (!corners.is_node(v)) continue;
      // Turn around the vertex from the curve's one direction to its other: what is met first arrives there.
      const auto side = [&](int from, int to, double& turn) {
        Vector3d sum = Vector3d::Zero();
        int corner = corners.leaving(v, from);
        while (corner >= 0) {
          const int rib = corners.vertex(corners.previous(corner));
          if (rib == to || rib == from) break;
          double own = 0;
          sum += corners.arriving_normal(corner, false, own);
          turn = std::max(turn, own);
          corner = corners.leaving(v, rib);
        }
        return sum;
      };
      double turn = 0;
      const Vector3d left = side(after, before, turn), right = side(before, after, turn);
      if (left.norm() < 0.1 || right.norm() < 0.1) continue;
      ++n_nodes;
      const double jump = std::atan2(left.cross(right).norm(), left.dot(right));
      least = std::min(least, jump > 3 * turn ? jump : 0);
    }
    if (n_nodes < 2 || least < kLeastJump) continue;
    findings.push_back({static_cast<int>(c), least,
                        concat(curve_name(network, static_cast<int>(c)),
                               " was taken as sharp: the normals on its two sides differ by ", degrees(least),
                               " degrees or more")});
  }
  return findings;
}

}  // namespace batten
