#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/patch_outlines_detail.hpp"

namespace batten::detail {

namespace {

constexpr double kKink = radians(40.0);       ///< turns of a curve that make a node
constexpr double kFlatNode = radians(150.0);  ///< interior angles from which sides go on straight
constexpr int kMostCuts = 1000;

Eigen::Vector3d outline_point(const Points& X, int v) {
  return X.row(v).transpose();
}

double outline_length(const Points& X, const std::vector<int>& vertices) {
  double length = 0;
  for (std::size_t i = 1; i < vertices.size(); ++i)
    length += (X.row(vertices[i]) - X.row(vertices[i - 1])).norm();
  return length;
}

class OutlineBuilder {
 public:
  OutlineBuilder(const Points& X, const Triangles& T, const std::vector<int>& patch_of_triangle,
                 double crease_angle)
      : X_(X),
        T_(T),
        patch_(patch_of_triangle),
        crease_angle_(crease_angle),
        edges_(mesh_edges(T, X.rows())) {
    is_curve_.assign(at(edges_.n_edges()), 0);
    is_cut_ = is_curve_;
    for (Eigen::Index e = 0; e < edges_.n_edges(); ++e) {
      if (edges_.n_triangles(e) > 2)
        throw InvalidInput(concat("the edge between vertices ", edges_.vertices(e, 0), " and ",
                                  edges_.vertices(e, 1),
                                  " has more than two triangles; batten repair takes such sheets apart"));
      is_curve_[at(e)] =
          edges_.n_triangles(e) == 1 || patch_[triangle_at(e, 0)] != patch_[triangle_at(e, 1)] ? 1 : 0;
    }
  }

  PatchOutlines build() {
    for (int cuts = 0;; ++cuts) {
      find_pieces();
      find_nodes();
      const int open = piece_to_cut();
      if (open < 0) break;
      if (cuts == kMostCuts) fail(open, "cannot be cut into parts with one outline each");
      cut(open);
    }
    while (add_nodes()) {
    }
    return outlines();
  }

 private:
  using Loop = std::vector<int>;  ///< vertices, the surface to the left

  std::size_t triangle_at(Eigen::Index e, int k) const {
    return at(edges_.sides[at(edges_.offsets[at(e)] + k)] / 3);
  }

  [[noreturn]] void fail(int piece, const std::string& what) const {
    const int patch = patch_[at(triangles_of_[at(piece)].front())];
    const Eigen::RowVector3d p = X_.row(T_(triangles_of_[at(piece)].front(), 0));
    throw InvalidInput(concat("patch ", patch, " near (", p.x(), ", ", p.y(), ", ", p.z(), ") ", what,
                              "; draw another curve across it"));
  }

  /// Parts of the surface between curves, and their outlines.
  void find_pieces() {
    DisjointSets sets(static_cast<int>(T_.rows()));
    for (Eigen::Index e = 0; e < edges_.n_edges(); ++e)
      if (!is_curve_[at(e)])
        sets.unite(static_cast<int>(triangle_at(e, 0)), static_cast<int>(triangle_at(e, 1)));
    piece_.assign(at(T_.rows()), -1);
    triangles_of_.clear();
    for (int f = 0; f < T_.rows(); ++f) {
      int& piece = piece_[at(sets.root(f))];
      if (sets.root(f) == f) {
        piece = static_cast<int>(triangles_of_.size());
        triangles_of_.emplace_back();
      }
      piece_[at(f)] = piece_[at(sets.root(f))];
      triangles_of_[at(piece_[at(f)])].push_back(f);
    }
    loops_.assign(triangles_of_.size(), {});
    std::vector<char> done(at(3 * T_.rows()), 0);
    for (int side = 0; side < 3 * T_.rows(); ++side)
      if (is_curve_[at(edges_.of_triangle(side / 3, side % 3))] && !done[at(side)])
        loops_[at(piece_[at(side / 3)])].push_back(walk(side, done));
  }

  /// Along the outline of a piece, from side to side, turning around each vertex within the piece.
  Loop walk(int start, std::vector<char>& done) const {
    Loop loop;
    int side = start;
    do {
      done[at(side)] = 1;
      loop.push_back(T_(side / 3, side % 3));
      side = next_side(side);
      while (!is_curve_[at(edges_.of_triangle(side / 3, side % 3))]) side = next_side(opposite(side));
    } while (side != start);
    return loop;
  }

  static int next_side(int side) { return 3 * (side / 3) + (side + 1) % 3; }
  int opposite(int side) const {
    const int e = edges_.of_triangle(side / 3, side % 3), first = edges_.offsets[at(e)];
    return edges_.sides[at(first)] == side ? edges_.sides[at(first + 1)] : edges_.sides[at(first)];
  }

  /// Ends and crossings of curves, and kinks. Cuts go from edge to edge of the mesh: their kinks mean
  /// nothing.
  void find_nodes() {
    std::vector<std::vector<int>> neighbours(at(X_.rows()));
    std::vector<char> on_cut(at(X_.rows()), 0);
    for (Eigen::Index e = 0; e < edges_.n_edges(); ++e)
      if (is_curve_[at(e)])
        for (int k = 0; k < 2; ++k) {
          neighbours[at(edges_.vertices(e, k))].push_back(edges_.vertices(e, 1 - k));
          if (is_cut_[at(e)]) on_cut[at(edges_.vertices(e, k))] = 1;
        }
    is_node_.resize(at(X_.rows()), 0);
    for (int v = 0; v < X_.rows(); ++v) {
      const std::vector<int>& around = neighbours[at(v)];
      if (around.empty()) continue;
      if (around.size() != 2) {
        is_node_[at(v)] = 1;
        continue;
      }
      if (on_cut[at(v)]) continue;
      const Eigen::Vector3d in = outline_point(X_, v) - outline_point(X_, around[0]);
      const Eigen::Vector3d out = outline_point(X_, around[1]) - outline_point(X_, v);
      if (std::atan2(in.cross(out).norm(), in.dot(out)) > kKink) is_node_[at(v)] = 1;
    }
  }

  /// The first piece that is no disc, −1 where there is none.
  int piece_to_cut() const {
    for (int p = 0; p < static_cast<int>(triangles_of_.size()); ++p) {
      std::set<int> vertices;
      std::size_t inner = 0, outer = 0;
      for (const int f : triangles_of_[at(p)])
        for (int k = 0; k < 3; ++k) {
          vertices.insert(T_(f, k));
          (is_curve_[at(edges_.of_triangle(f, k))] ? outer : inner) += 1;
        }
      const std::vector<Loop>& loops = loops_[at(p)];
      if (loops.empty()) fail(p, "closes without any curve");
      const long euler = static_cast<long>(vertices.size()) - static_cast<long>(inner / 2 + outer) +
                         static_cast<long>(triangles_of_[at(p)].size());
      for (const Loop& loop : loops)
        if (std::set<int>(loop.begin(), loop.end()).size() != loop.size())
          fail(p, "has an outline that meets itself in a point");
      if (euler != 2 - static_cast<long>(loops.size()))
        fail(p, "has a handle, or outlines that meet in a point");
      if (loops.size() > 1) return p;
    }
    return -1;
  }

  std::vector<int> nodes_of(const Loop& loop) const {
    std::vector<int> places;
    for (std::size_t i = 0; i < loop.size(); ++i)
      if (is_node_[at(loop[i])]) places.push_back(static_cast<int>(i));
    return places;
  }

  /// `n` places spread along a loop by length, the first at `start`.
  std::vector<int> spread(const Loop& loop, int start, int n) const {
    std::vector<double> along{0};
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const int a = loop[(at(start) + i) % loop.size()], b = loop[(at(start) + i + 1) % loop.size()];
      along.push_back(along.back() + (X_.row(b) - X_.row(a)).norm());
    }
    std::vector<int> places;
    for (int k = 0; k < n; ++k) {
      const double wanted = along.back() * k / n;
      const auto found = std::lower_bound(along.begin(), along.end(), wanted - 1e-12 * along.back());
      places.push_back((start + static_cast<int>(found - along.begin())) % static_cast<int>(loop.size()));
    }
    return places;
  }

  /// Cuts a piece between two of its outlines, from node to node where both have as many, along disjoint
  /// shortest paths.
  void cut(int piece) {
    const std::vector<Loop>& loops = loops_[at(piece)];
    const Loop& a = loops[0];
    std::size_t nearest = 1;
    std::pair<int, int> closest{0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t l = 1; l < loops.size(); ++l)
      for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < loops[l].size(); ++j) {
          const double distance = (X_.row(a[i]) - X_.row(loops[l][j])).norm();
          if (distance < least * (1 - 1e-9)) {
            least = distance;
            nearest = l;
            closest = {static_cast<int>(i), static_cast<int>(j)};
          }
        }
    const Loop& b = loops[nearest];
    std::vector<int> from = nodes_of(a), to = nodes_of(b);
    const int most = static_cast<int>(std::max(from.size(), to.size()));
    if (loops.size() > 2) {
      from = spread(a, closest.first, 2);
      to = spread(b, closest.second, 2);
    } else if (from.size() != to.size() || from.size() < 3) {
      // Those of one loop with nodes are kept where the other has none.
      const int n = std::min(from.size(), to.size()) < 3 && most >= 3 ? most : (most < 3 ? 4 : 2);
      if (static_cast<int>(from.size()) != n) from = spread(a, from.empty() ? closest.first : from[0], n);
      if (static_cast<int>(to.size()) != n) to = spread(b, to.empty() ? closest.second : to[0], n);
    }
    // The outlines run in opposite senses.
    const int n = static_cast<int>(from.size());
    int shift = 0;
    double shortest = std::numeric_limits<double>::infinity();
    for (int s = 0; s < n; ++s) {
      double sum = 0;
      for (int i = 0; i < n; ++i)
        sum += (X_.row(a[at(from[at(i)])]) - X_.row(b[at(to[at((s - i + 2 * n) % n)])])).squaredNorm();
      if (sum < shortest * (1 - 1e-9)) {
        shortest = sum;
        shift = s;
      }
    }
    std::vector<char> blocked(at(X_.rows()), 0);
    for (const Loop& loop : loops)
      for (const int v : loop) blocked[at(v)] = 1;
    for (int i = 0; i < n; ++i)
      cut_along(piece, a[at(from[at(i)])], b[at(to[at((shift - i + 2 * n) % n)])], blocked);
  }

  /// Makes the shortest path within a piece a curve and blocks its vertices.
  void cut_along(int piece, int from, int to, std::vector<char>& blocked) {
    if (neighbours_.empty()) {
      neighbours_.resize(at(X_.rows()));
      for (int e = 0; e < edges_.n_edges(); ++e)
        for (int k = 0; k < 2; ++k) neighbours_[at(edges_.vertices(e, k))].push_back(e);
    }
    std::vector<double> distance(at(X_.rows()), std::numeric_limits<double>::infinity());
    std::vector<int> by(at(X_.rows()), -1);
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> queue;
    distance[at(from)] = 0;
    queue.emplace(0.0, from);
    while (!queue.empty()) {
      const auto [length, v] = queue.top();
      queue.pop();
      if (v == to) break;
      if (length > distance[at(v)]) continue;
      for (const int e : neighbours_[at(v)]) {
        if (is_curve_[at(e)] || piece_[triangle_at(e, 0)] != piece) continue;
        const int w = edges_.vertices(e, 0) == v ? edges_.vertices(e, 1) : edges_.vertices(e, 0);
        if (w != to && blocked[at(w)]) continue;
        const double next = length + (X_.row(v) - X_.row(w)).norm();
        if (next < distance[at(w)]) {
          distance[at(w)] = next;
          by[at(w)] = e;
          queue.emplace(next, w);
        }
      }
    }
    if (by[at(to)] < 0) fail(piece, "is too narrow to be cut between its outlines");
    for (int v = to; v != from;) {
      const int e = by[at(v)];
      is_curve_[at(e)] = is_cut_[at(e)] = 1;
      blocked[at(v)] = 1;
      v = edges_.vertices(e, 0) == v ? edges_.vertices(e, 1) : edges_.vertices(e, 0);
    }
    blocked[at(from)] = 1;
  }

  /// Interior angle of a piece at a vertex.
  double angle_at(int piece, int vertex) const {
    double angle = 0;
    for (const int f : triangles_of_[at(piece)])
      for (int k = 0; k < 3; ++k) {
        if (T_(f, k) != vertex) continue;
        const Eigen::Vector3d p = outline_point(X_, vertex), u = outline_point(X_, T_(f, (k + 1) % 3)) - p,
                              w = outline_point(X_, T_(f, (k + 2) % 3)) - p;
        angle += std::atan2(u.cross(w).norm(), u.dot(w));
      }
    return angle;
  }

  /// Adds a node to the first piece that has too few. @return false where all have enough.
  bool add_nodes() {
    bool added = false;
    for (int p = 0; p < static_cast<int>(triangles_of_.size()); ++p) {
      const Loop& loop = loops_[at(p)][0];
      const std::vector<int> places = nodes_of(loop);
      bool flat = places.size() < 3;
      for (const int i : places) flat = flat || angle_at(p, loop[at(i)]) > kFlatNode;
      if (!flat || places.size() >= 4) continue;
      if (places.empty()) {
        is_node_[at(loop[0])] = 1;
        for (const int i : spread(loop, 0, 4)) is_node_[at(loop[at(i)])] = 1;
        if (nodes_of(loop).size() < 4) fail(p, "has an outline of fewer than four edges");
      } else {
        split_longest_side(p, loop, places);
      }
      added = true;
    }
    return added;
  }

  void split_longest_side(int piece, const Loop& loop, const std::vector<int>& places) {
    double longest = 0;
    int middle = -1;
    const int n = static_cast<int>(loop.size());
    for (std::size_t s = 0; s < places.size(); ++s) {
      std::vector<int> side;
      const int end = s + 1 < places.size() ? places[s + 1] : places[0] + n;
      for (int i = places[s]; i <= end; ++i) side.push_back(loop[at(i % n)]);
      const double length = outline_length(X_, side);
      if (side.size() < 3 || length <= longest) continue;
      longest = length;
      double along = 0, best = std::numeric_limits<double>::infinity();
      for (std::size_t i = 1; i + 1 < side.size(); ++i) {
        along += (X_.row(side[i]) - X_.row(side[i - 1])).norm();
        if (std::abs(along - length / 2) < best) {
          best = std::abs(along - length / 2);
          middle = side[i];
        }
      }
    }
    if (middle < 0) fail(piece, "has fewer than three corners and no vertices between them");
    is_node_[at(middle)] = 1;
  }

  /// Whether the surface turns along a curve, in the median.
  bool is_sharp(const std::vector<int>& vertices, const std::vector<int>& edges) const {
    std::vector<double> angles;
    for (const int e : edges) {
      if (edges_.n_triangles(e) != 2) return false;
      const auto normal = [&](int k) {
        const auto f = static_cast<Eigen::Index>(triangle_at(e, k));
        return (outline_point(X_, T_(f, 1)) - outline_point(X_, T_(f, 0)))
            .cross(outline_point(X_, T_(f, 2)) - outline_point(X_, T_(f, 0)));
      };
      const Eigen::Vector3d n = normal(0), m = normal(1);
      angles.push_back(std::atan2(n.cross(m).norm(), n.dot(m)));
    }
    if (vertices.size() < 2) return false;
    std::nth_element(angles.begin(), angles.begin() + static_cast<long>(angles.size() / 2), angles.end());
    return angles[angles.size() / 2] > crease_angle_;
  }

  PatchOutlines outlines() const {
    PatchOutlines result;
    std::vector<int> segment_of_edge(at(edges_.n_edges()), -1);
    for (int p = 0; p < static_cast<int>(triangles_of_.size()); ++p) {
      OutlinePiece piece;
      piece.triangles = triangles_of_[at(p)];
      piece.patch = patch_[at(piece.triangles.front())];
      const Loop& loop = loops_[at(p)][0];
      const std::vector<int> places = nodes_of(loop);
      const int n = static_cast<int>(loop.size());
      for (std::size_t s = 0; s < places.size(); ++s) {
        const int end = s + 1 < places.size() ? places[s + 1] : places[0] + n;
        std::vector<int> vertices, edges;
        for (int i = places[s]; i <= end; ++i) vertices.push_back(loop[at(i % n)]);
        for (std::size_t i = 0; i + 1 < vertices.size(); ++i)
          edges.push_back(edge_between(p, vertices[i], vertices[i + 1]));
        int& segment = segment_of_edge[at(edges.front())];
        if (segment < 0) {
          segment = static_cast<int>(result.segments.size());
          for (const int e : edges) segment_of_edge[at(e)] = segment;
          result.segments.push_back({vertices, is_sharp(vertices, edges)});
        }
        // Both directions of a segment of one edge have the same edge first: the order of its vertices tells
        // them apart.
        piece.sides.push_back({segment, result.segments[at(segment)].vertices.front() == vertices.front() &&
                                            result.segments[at(segment)].vertices[1] == vertices[1]});
        piece.is_flat.push_back(angle_at(p, vertices.front()) > kFlatNode ? 1 : 0);
      }
      result.pieces.push_back(std::move(piece));
    }
    return result;
  }

  int edge_between(int piece, int a, int b) const {
    const std::array<int, 2> wanted{std::min(a, b), std::max(a, b)};
    Eigen::Index low = 0, high = edges_.n_edges();
    while (low < high) {
      const Eigen::Index middle = (low + high) / 2;
      if (std::array<int, 2>{edges_.vertices(middle, 0), edges_.vertices(middle, 1)} < wanted)
        low = middle + 1;
      else
        high = middle;
    }
    if (low == edges_.n_edges() || edges_.vertices(low, 0) != wanted[0] ||
        edges_.vertices(low, 1) != wanted[1])
      fail(piece, "has an outline that leaves its edges");
    return static_cast<int>(low);
  }

  const Points& X_;
  const Triangles& T_;
  const std::vector<int>& patch_;
  double crease_angle_;
  MeshEdges edges_;
  std::vector<char> is_curve_;  ///< per edge
  std::vector<char> is_cut_;    ///< per edge: a curve only because of cut()
  std::vector<char> is_node_;   ///< per vertex
  std::vector<int> piece_;      ///< per triangle
  std::vector<std::vector<int>> triangles_of_;
  std::vector<std::vector<Loop>> loops_;      ///< per piece
  std::vector<std::vector<int>> neighbours_;  ///< edges per vertex
};

}  // namespace

PatchOutlines patch_outlines(const Points& positions, const Triangles& triangles,
                             const std::vector<int>& patch_of_triangle, double crease_angle) {
  return OutlineBuilder(positions, triangles, patch_of_triangle, crease_angle).build();
}

}  // namespace batten::detail
