#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/sheets_detail.hpp"

namespace batten::detail {

namespace {

/// The side that each side (3 · triangle + k) is joined to, or −1.
using Partners = std::vector<int>;

int from_of(const Triangles& triangles, int side) {
  return triangles(side / 3, side % 3);
}

/// Triangles that hang together through joined sides.
struct Parts {
  std::vector<int> part;       // per triangle
  std::vector<char> turned;    // per triangle: to be turned over to agree with the others
  std::vector<char> mixed;     // per part: some are turned, some not
  std::vector<char> closed;    // per part: every side is joined
  std::vector<int> conflicts;  // sides whose triangles cannot agree
  int n() const { return static_cast<int>(mixed.size()); }
};

Parts parts_of(const Triangles& triangles, const Partners& partners, const Eigen::VectorXd& areas) {
  const auto m = static_cast<size_t>(triangles.rows());
  Parts parts;
  parts.part.assign(m, -1);
  parts.turned.assign(m, 0);
  std::vector<int> members;
  for (int seed = 0; seed < static_cast<int>(m); ++seed) {
    if (parts.part[at(seed)] >= 0) continue;
    const int part = parts.n();
    members.assign(1, seed);
    parts.part[at(seed)] = part;
    bool closed = true;
    for (size_t k = 0; k < members.size(); ++k)  // breadth first: a cut, if there must be one, is short
      for (int side = 3 * members[k]; side < 3 * members[k] + 3; ++side) {
        const int other = partners[at(side)];
        if (other < 0) {
          closed = false;
          continue;
        }
        const bool agree = from_of(triangles, side) != from_of(triangles, other);
        const char turned = static_cast<char>((parts.turned[at(members[k])] != 0) == agree);
        if (parts.part[at(other / 3)] < 0) {
          parts.part[at(other / 3)] = part;
          parts.turned[at(other / 3)] = turned;
          members.push_back(other / 3);
        } else if (parts.turned[at(other / 3)] != turned) {
          parts.conflicts.push_back(side);
        }
      }
    double turned_area = 0, area = 0;
    size_t n_turned = 0;
    for (const int f : members) {
      area += areas(f);
      if (parts.turned[at(f)] != 0) turned_area += areas(f), ++n_turned;
    }
    parts.mixed.push_back(n_turned > 0);
    parts.closed.push_back(closed);
    if (2 * turned_area > area)
      for (const int f : members) parts.turned[at(f)] ^= 1;
  }
  return parts;
}

/// Six times the volume under a triangle as it is to be turned, from `centre`.
double signed_volume(const Points& positions, const Triangles& triangles, const Parts& parts, int f,
                     const Eigen::RowVector3d& centre) {
  const Eigen::RowVector3d a = positions.row(triangles(f, 0)) - centre,
                           b = positions.row(triangles(f, 1)) - centre,
                           c = positions.row(triangles(f, 2)) - centre;
  return (parts.turned[at(f)] != 0 ? -1.0 : 1.0) * a.dot(b.cross(c));
}

/// Volumes of the parts, each from a point of its own.
std::vector<double> volumes(const Points& positions, const Triangles& triangles, const Parts& parts) {
  std::vector<double> volume(at(parts.n()), 0);
  std::vector<int> first(at(parts.n()), -1);
  for (int f = 0; f < static_cast<int>(triangles.rows()); ++f) {
    const size_t part = at(parts.part[at(f)]);
    if (first[part] < 0) first[part] = triangles(f, 0);
    volume[part] += signed_volume(positions, triangles, parts, f, positions.row(first[part]));
  }
  return volume;
}

/// Joins the sides of edges with more than two triangles in pairs.
class BranchJoiner {
 public:
  BranchJoiner(const Points& positions, const Triangles& triangles, const MeshEdges& edges,
               const Parts& patches)
      : positions_(positions), triangles_(triangles), edges_(edges), patches_(patches) {}

  void join(Partners& partners) const {
    // Along a chain of edges where the same patches meet, they are joined alike.
    std::map<std::vector<int>, std::vector<int>> chains;
    for (int e = 0; e < static_cast<int>(edges_.n_edges()); ++e) {
      if (edges_.n_triangles(e) <= 2) continue;
      std::vector<int> sides = sides_by_patch(e), key;
      key.reserve(sides.size());
      for (const int side : sides) key.push_back(patch(side));
      if (std::adjacent_find(key.begin(), key.end()) != key.end())
        join_alike({e}, partners);  // a patch meets itself: every edge by itself
      else
        chains[key].push_back(e);
    }
    for (const auto& [key, chain] : chains) join_alike(chain, partners);
  }

 private:
  int patch(int side) const { return patches_.part[at(side / 3)]; }

  std::vector<int> sides_by_patch(int e) const {
    std::vector<int> sides(edges_.sides.begin() + edges_.offsets[at(e)],
                           edges_.sides.begin() + edges_.offsets[at(e) + 1]);
    std::stable_sort(sides.begin(), sides.end(), [&](int s, int t) { return patch(s) < patch(t); });
    return sides;
  }

  /// How well two sides of an edge go together, per pair of places in sides_by_patch().
  Eigen::MatrixXd scores(int e) const {
    const std::vector<int> sides = sides_by_patch(e);
    const auto n = static_cast<Eigen::Index>(sides.size());
    const Eigen::RowVector3d a = positions_.row(edges_.vertices(e, 0)),
                             along = (positions_.row(edges_.vertices(e, 1)) - a).stableNormalized();
    Points away(n, 3);
    std::vector<char> forward(at(n));  // runs along the edge, once it is turned
    for (Eigen::Index i = 0; i < n; ++i) {
      const int side = sides[at(i)];
      const Eigen::RowVector3d d = positions_.row(triangles_(side / 3, (side % 3 + 2) % 3)) - a;
      away.row(i) = (d - d.dot(along) * along).stableNormalized();
      forward[at(i)] =
          (from_of(triangles_, side) == edges_.vertices(e, 0)) != (patches_.turned[at(side / 3)] != 0);
    }
    const Eigen::RowVector3d x = away.row(0), y = along.cross(x);
    std::vector<double> angle(at(n));
    for (Eigen::Index i = 0; i < n; ++i) angle[at(i)] = std::atan2(away.row(i).dot(y), away.row(i).dot(x));
    std::vector<int> around(at(n));
    std::iota(around.begin(), around.end(), 0);
    std::stable_sort(around.begin(), around.end(), [&](int i, int j) { return angle[at(i)] < angle[at(j)]; });
    bool bodies = n % 2 == 0;  // inside and outside take turns around the edge
    for (size_t k = 0; k < around.size(); ++k)
      bodies = bodies && forward[at(around[k])] != forward[at(around[(k + 1) % around.size()])];
    Eigen::MatrixXd score = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        if (i == j) continue;
        score(i, j) = -away.row(i).dot(away.row(j));  // 1: straight on, −1: folded back
        if (forward[at(i)] == forward[at(j)]) score(i, j) -= 1;
      }
    // Outside lies behind a triangle that runs along the edge, by growing angle; before one that runs back.
    if (bodies)
      for (size_t k = 0; k < around.size(); ++k) {
        const int i = around[k], j = around[(k + 1) % around.size()];
        if (forward[at(i)] != 0) continue;
        score(i, j) += 8;
        score(j, i) += 8;
      }
    return score;
  }

  void join_alike(const std::vector<int>& chain, Partners& partners) const {
    Eigen::MatrixXd score = scores(chain[0]);
    for (size_t k = 1; k < chain.size(); ++k) score += scores(chain[k]);
    const Eigen::Index n = score.rows();
    std::vector<char> done(at(n), 0);
    while (true) {
      Eigen::Index best_i = -1, best_j = -1;
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = i + 1; j < n; ++j)
          if (done[at(i)] == 0 && done[at(j)] == 0 && (best_i < 0 || score(i, j) > score(best_i, best_j)))
            best_i = i, best_j = j;
      if (best_i < 0) return;
      done[at(best_i)] = done[at(best_j)] = 1;
      for (const int e : chain) {
        const std::vector<int> sides = sides_by_patch(e);
        partners[at(sides[at(best_i)])] = sides[at(best_j)];
        partners[at(sides[at(best_j)])] = sides[at(best_i)];
      }
    }
  }

  const Points& positions_;
  const Triangles& triangles_;
  const MeshEdges& edges_;
  const Parts& patches_;
};

/// Turns of a closed part around a point: ±1 inside, 0 outside [vanoosterom1983].
double winding_number(const Points& positions, const Triangles& triangles, const std::vector<int>& members,
                      const Parts& parts, const Eigen::RowVector3d& point) {
  const double angle = parallel_sum(
      static_cast<Eigen::Index>(members.size()), 4096, [&](Eigen::Index begin, Eigen::Index end) {
        double sum = 0;
        for (Eigen::Index k = begin; k < end; ++k) {
          const int f = members[at(k)];
          const Eigen::RowVector3d a = positions.row(triangles(f, 0)) - point,
                                   b = positions.row(triangles(f, 1)) - point,
                                   c = positions.row(triangles(f, 2)) - point;
          const double la = a.norm(), lb = b.norm(), lc = c.norm();
          const double solid =
              2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
          sum += parts.turned[at(f)] != 0 ? -solid : solid;
        }
        return sum;
      });
  return angle / (4 * kPi);
}

/// An open part lies around its middle where the volume under it is this share of that of a ball of its area.
constexpr double kAround = 0.2;

/// Turns closed parts so that they bound a volume, as far as `orient` asks for it.
void turn_outward(const Points& positions, const Triangles& triangles, const Eigen::VectorXd& areas,
                  bool orient, Parts& parts, MendingReport& report, const Progress& progress) {
  std::vector<std::vector<int>> members(at(parts.n()));
  for (int f = 0; f < static_cast<int>(triangles.rows()); ++f) members[at(parts.part[at(f)])].push_back(f);
  std::vector<int> closed;
  std::vector<Box> boxes;
  for (int part = 0; part < parts.n(); ++part) {
    if (parts.closed[at(part)] == 0) continue;
    closed.push_back(part);
    Box box{positions.row(triangles(members[at(part)][0], 0)),
            positions.row(triangles(members[at(part)][0], 0))};
    for (const int f : members[at(part)])
      for (int k = 0; k < 3; ++k)
        box.include({positions.row(triangles(f, k)), positions.row(triangles(f, k))});
    boxes.push_back(box);
  }
  // Where chance has turned the triangles of an open part, their majority says nothing; the part looks away
  // from its middle where it lies around it.
  for (int part = 0; part < parts.n(); ++part) {
    if (parts.closed[at(part)] != 0 || parts.mixed[at(part)] == 0) continue;
    Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
    double area = 0, volume = 0;
    for (const int f : members[at(part)]) {
      middle +=
          areas(f) / 3 *
          (positions.row(triangles(f, 0)) + positions.row(triangles(f, 1)) + positions.row(triangles(f, 2)));
      area += areas(f);
    }
    middle /= area;
    for (const int f : members[at(part)]) volume += signed_volume(positions, triangles, parts, f, middle) / 6;
    const double of_ball = std::pow(area, 1.5) / (6 * std::sqrt(kPi));
    if (-volume > kAround * of_ball)
      for (const int f : members[at(part)]) parts.turned[at(f)] ^= 1;
  }
  const std::vector<double> volume = volumes(positions, triangles, parts);
  const BoxTree tree(boxes);
  for (size_t i = 0; i < closed.size(); ++i) {
    if (i % 64 == 0)
      progress.report("orientation", static_cast<double>(i) / static_cast<double>(closed.size()));
    const int part = closed[i];
    // On the surface of another part, the number is a half or a quarter: touching is not lying within.
    const Eigen::RowVector3d point = positions.row(triangles(members[at(part)][0], 0));
    constexpr double kInside = 0.75;
    int depth = 0;
    tree.query(boxes[i], [&](int j) {
      const auto& around = boxes[at(j)];
      if (at(j) != i && (around.low.array() <= boxes[i].low.array()).all() &&
          (around.high.array() >= boxes[i].high.array()).all() &&
          std::abs(winding_number(positions, triangles, members[at(closed[at(j)])], parts, point)) > kInside)
        ++depth;
      return true;
    });
    const bool is_positive = volume[at(part)] > 0, should_be = depth % 2 == 0;
    if (is_positive == should_be || volume[at(part)] == 0) continue;
    if (orient || parts.mixed[at(part)] != 0 || depth == 0)
      for (const int f : members[at(part)]) parts.turned[at(f)] ^= 1;
    else if (is_positive)
      ++report.nested;
  }
}

/// Gives every fan of triangles, joined through partners, its own vertex.
void split_fans(const Partners& partners, Points& positions, Triangles& triangles, Origins& origins) {
  DisjointSets fans(static_cast<int>(3 * triangles.rows()));
  const auto corner_at = [&](int triangle, int vertex) {
    for (int k = 0; k < 3; ++k)
      if (triangles(triangle, k) == vertex) return 3 * triangle + k;
    return -1;
  };
  for (int side = 0; side < static_cast<int>(partners.size()); ++side) {
    const int other = partners[at(side)];
    if (other < side) continue;
    for (int end = 0; end < 2; ++end) {
      const int f = side / 3, corner = 3 * f + (side % 3 + end) % 3;
      fans.unite(corner, corner_at(other / 3, triangles(f, corner % 3)));
    }
  }
  // The first fan of a vertex keeps it; the others get theirs behind all vertices, in the order of triangles.
  std::vector<int> fan_of(static_cast<size_t>(positions.rows()), -1);
  std::vector<int> vertex_of(partners.size(), -1);  // per root corner
  auto n = static_cast<int>(positions.rows());
  for (int corner = 0; corner < static_cast<int>(partners.size()); ++corner) {
    const int root = fans.root(corner);
    if (root != corner) continue;
    const int vertex = triangles(corner / 3, corner % 3);
    if (fan_of[at(vertex)] < 0) {
      fan_of[at(vertex)] = root;
      vertex_of[at(root)] = vertex;
    } else {
      vertex_of[at(root)] = n++;
      origins.push_back(origins[at(vertex)]);
    }
  }
  const Eigen::Index before = positions.rows();
  positions.conservativeResize(n, 3);
  for (int corner = 0; corner < static_cast<int>(partners.size()); ++corner) {
    const int vertex = vertex_of[at(fans.root(corner))];
    if (vertex >= before) positions.row(vertex) = positions.row(triangles(corner / 3, corner % 3)).eval();
  }
  for (int corner = 0; corner < static_cast<int>(partners.size()); ++corner)
    triangles(corner / 3, corner % 3) = vertex_of[at(fans.root(corner))];
}

/// Divides a triangle at a vertex in the middle of one of its sides. The side keeps its number and its first
/// half; the second half is side 0 of the triangle that is added. @return that side.
int divide_side(int side, int middle, std::vector<std::array<int, 3>>& triangles, Partners& partners) {
  const int f = side / 3, k = side % 3, next = 3 * f + (k + 1) % 3;
  const auto added = static_cast<int>(triangles.size());
  auto& corners = triangles[at(f)];
  triangles.push_back({middle, corners[at((k + 1) % 3)], corners[at((k + 2) % 3)]});
  triangles[at(f)][at((k + 1) % 3)] = middle;
  const int beyond = partners[at(next)];
  partners.insert(partners.end(), {-1, beyond, next});
  if (beyond >= 0) partners[at(beyond)] = 3 * added + 1;
  partners[at(next)] = 3 * added + 2;
  return 3 * added;
}

/// Where two sheets share both ends of an edge that each of them passes, no splitting of vertices parts them.
/// All triangles of such edges are divided in the middle, every sheet with a vertex of its own, all at one
/// place. @return false when there are none.
bool divide_shared_edges(Partners& partners, Points& positions, Triangles& triangles, Origins& origins) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  std::vector<std::array<int, 3>> list;
  std::vector<char> is_divided(static_cast<size_t>(triangles.rows()), 0);
  for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e) {
    if (edges.n_triangles(e) <= 2) continue;
    const std::vector<int> sides(edges.sides.begin() + edges.offsets[at(e)],
                                 edges.sides.begin() + edges.offsets[at(e) + 1]);
    // One edge of a triangle at a time; others are met when this is called again.
    if (std::any_of(sides.begin(), sides.end(), [&](int side) { return is_divided[at(side / 3)] != 0; }))
      continue;
    if (list.empty())
      for (Eigen::Index f = 0; f < triangles.rows(); ++f)
        list.push_back({triangles(f, 0), triangles(f, 1), triangles(f, 2)});
    const int a = edges.vertices(e, 0), b = edges.vertices(e, 1);
    for (const int side : sides) {
      if (is_divided[at(side / 3)] != 0) continue;  // done with its partner
      const int partner = partners[at(side)];
      is_divided[at(side / 3)] = 1;
      if (partner >= 0) is_divided[at(partner / 3)] = 1;
      const auto middle = static_cast<int>(positions.rows());
      positions.conservativeResize(middle + 1, 3);
      positions.row(middle) = (positions.row(a) + positions.row(b)) / 2;
      origins.push_back({origins[at(a)][0], origins[at(b)][0]});
      const int half = divide_side(side, middle, list, partners);
      if (partner < 0) continue;
      const int other = divide_side(partner, middle, list, partners);
      partners[at(side)] = other;
      partners[at(other)] = side;
      partners[at(half)] = partner;
      partners[at(partner)] = half;
    }
  }
  if (list.empty()) return false;
  triangles = Eigen::Map<const Triangles>(list[0].data(), static_cast<Eigen::Index>(list.size()), 3);
  return true;
}

}  // namespace

void cut_into_sheets(Points& positions, Triangles& triangles, Origins& origins, bool orient,
                     MendingReport& report, const Progress& progress) {
  progress.report("sheets", 0);
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  const Eigen::VectorXd areas = face_areas(positions, triangles);
  Partners partners(static_cast<size_t>(3 * triangles.rows()), -1);
  for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e) {
    if (edges.n_triangles(e) > 2) ++report.branching;
    if (edges.n_triangles(e) != 2) continue;
    const int s = edges.sides[at(edges.offsets[at(e)])], t = edges.sides[at(edges.offsets[at(e)]) + 1];
    partners[at(s)] = t;
    partners[at(t)] = s;
  }
  if (report.branching > 0) {
    Parts patches = parts_of(triangles, partners, areas);
    // A patch that closes on itself, but for passing an edge twice, has an outside; see it from there.
    std::vector<char> has_outside(at(patches.n()), 1);
    for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e) {
      if (edges.n_triangles(e) == 2) continue;
      std::map<int, int> n_sides;
      for (int s = edges.offsets[at(e)]; s < edges.offsets[at(e) + 1]; ++s)
        ++n_sides[patches.part[at(edges.sides[at(s)] / 3)]];
      for (const auto& [patch, n] : n_sides)
        if (n % 2 != 0) has_outside[at(patch)] = 0;
    }
    const std::vector<double> volume = volumes(positions, triangles, patches);
    for (size_t f = 0; f < patches.part.size(); ++f) {
      const size_t patch = at(patches.part[f]);
      if (has_outside[patch] != 0 && volume[patch] < 0) patches.turned[f] ^= 1;
    }
    BranchJoiner(positions, triangles, edges, patches).join(partners);
  }
  progress.report("sheets", 0.5);
  Parts parts = parts_of(triangles, partners, areas);
  for (const int side : parts.conflicts) {
    const int other = partners[at(side)];
    if (other < 0) continue;
    partners[at(side)] = partners[at(other)] = -1;
    parts.closed[at(parts.part[at(side / 3)])] = 0;
    ++report.cut;
  }
  turn_outward(positions, triangles, areas, orient, parts, report, progress);
  const Eigen::Index before = positions.rows();
  split_fans(partners, positions, triangles, origins);
  for (int f = 0; f < static_cast<int>(triangles.rows()); ++f)
    if (parts.turned[at(f)] != 0) {
      std::swap(triangles(f, 1), triangles(f, 2));
      ++report.turned;
    }
  // Sides of a turned triangle have other numbers.
  const auto renumbered = [&](int side) {
    return parts.turned[at(side / 3)] != 0 ? side / 3 * 3 + (2 - side % 3) : side;
  };
  Partners turned(partners.size(), -1);
  for (int side = 0; side < static_cast<int>(partners.size()); ++side)
    if (partners[at(side)] >= 0) turned[at(renumbered(side))] = renumbered(partners[at(side)]);
  while (divide_shared_edges(turned, positions, triangles, origins)) {
  }
  report.split_vertices += positions.rows() - before;
}

}  // namespace batten::detail
