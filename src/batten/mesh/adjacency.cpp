#include "batten/mesh/adjacency.hpp"

#include <algorithm>
#include <numeric>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

void check_indices(const Triangles& triangles, Eigen::Index n_vertices) {
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (triangles(f, k) < 0 || triangles(f, k) >= n_vertices)
        throw InvalidInput(
            concat("triangle ", f, " names vertex ", triangles(f, k), ", but there are ", n_vertices));
}

/// Corners (3 · triangle + k) around each vertex.
struct Corners {
  std::vector<int> offsets, corners;
};

Corners corners_of_vertices(const Triangles& triangles, Eigen::Index n_vertices) {
  Corners result;
  result.offsets.assign(static_cast<size_t>(n_vertices) + 1, 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++result.offsets[at(triangles(f, k)) + 1];
  std::partial_sum(result.offsets.begin(), result.offsets.end(), result.offsets.begin());
  result.corners.resize(static_cast<size_t>(3 * triangles.rows()));
  std::vector<int> next(result.offsets.begin(), result.offsets.end() - 1);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) result.corners[at(next[at(triangles(f, k))]++)] = static_cast<int>(3 * f + k);
  return result;
}

}  // namespace

MeshEdges mesh_edges(const Triangles& triangles, Eigen::Index n_vertices) {
  check_indices(triangles, n_vertices);
  MeshEdges edges;
  // Sides grouped by their lower vertex (counting), then by the upper one (a handful each).
  struct Side {
    int upper, side;
  };
  std::vector<int> begin(static_cast<size_t>(n_vertices) + 1, 0);
  const auto lower_of = [&](Eigen::Index f, int k) {
    return std::min(triangles(f, k), triangles(f, (k + 1) % 3));
  };
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++begin[at(lower_of(f, k)) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Side> sorted(static_cast<size_t>(3 * triangles.rows()));
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      sorted[at(next[at(lower_of(f, k))]++)] = {std::max(triangles(f, k), triangles(f, (k + 1) % 3)),
                                                static_cast<int>(3 * f + k)};
  edges.of_triangle.resize(triangles.rows(), 3);
  edges.sides.reserve(sorted.size());
  edges.offsets.push_back(0);
  std::vector<int> ends;
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    const auto first = sorted.begin() + begin[static_cast<size_t>(v)],
               last = sorted.begin() + begin[static_cast<size_t>(v) + 1];
    std::sort(first, last, [](const Side& a, const Side& b) {
      return a.upper != b.upper ? a.upper < b.upper : a.side < b.side;
    });
    for (auto side = first; side != last; ++side) {
      if (side == first || side->upper != (side - 1)->upper) {
        ends.push_back(static_cast<int>(v));
        ends.push_back(side->upper);
        edges.offsets.push_back(edges.offsets.back());
      }
      ++edges.offsets.back();
      edges.sides.push_back(side->side);
      edges.of_triangle(side->side / 3, side->side % 3) = static_cast<int>(edges.offsets.size()) - 2;
    }
  }
  edges.vertices = Eigen::Map<const Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor>>(
      ends.data(), static_cast<Eigen::Index>(ends.size() / 2), 2);
  return edges;
}

OneRings one_rings(const Triangles& triangles, Eigen::Index n_vertices) {
  check_indices(triangles, n_vertices);
  const Corners corners = corners_of_vertices(triangles, n_vertices);
  OneRings rings;
  rings.offsets.push_back(0);
  rings.is_closed.assign(static_cast<size_t>(n_vertices), 0);
  std::vector<std::pair<int, int>> spokes;  // (neighbour where a triangle begins, where it ends)
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    spokes.clear();
    for (int c = corners.offsets[static_cast<size_t>(v)]; c < corners.offsets[static_cast<size_t>(v) + 1];
         ++c) {
      const int corner = corners.corners[at(c)];
      spokes.emplace_back(triangles(corner / 3, (corner % 3 + 1) % 3),
                          triangles(corner / 3, (corner % 3 + 2) % 3));
    }
    const size_t n = spokes.size();
    if (n > 0) {
      std::sort(spokes.begin(), spokes.end());
      const auto fail = [&] {
        throw InvalidInput(
            concat("the triangles around vertex ", v,
                   " do not form one fan of consistent orientation; batten repair IN -o OUT mends that"));
      };
      for (size_t k = 1; k < n; ++k)
        if (spokes[k].first == spokes[k - 1].first) fail();
      const auto beginning_at = [&](int vertex) {
        const auto place = std::lower_bound(spokes.begin(), spokes.end(), std::make_pair(vertex, -1));
        return place != spokes.end() && place->first == vertex ? static_cast<int>(place - spokes.begin())
                                                               : -1;
      };
      // An open fan begins at the triangle that no other ends at.
      std::vector<char> has_before(n, 0);
      for (const auto& [first, second] : spokes)
        if (const int k = beginning_at(second); k >= 0) {
          if (has_before[at(k)]) fail();
          has_before[at(k)] = 1;
        }
      const auto start = std::find(has_before.begin(), has_before.end(), 0);
      const bool closed = start == has_before.end();
      int k = closed ? 0 : static_cast<int>(start - has_before.begin());
      size_t walked = 0;
      rings.vertices.push_back(spokes[at(k)].first);
      while (true) {
        ++walked;
        const int end = spokes[at(k)].second;
        if (walked > n) fail();
        if (closed && end == spokes[0].first) break;
        rings.vertices.push_back(end);
        k = beginning_at(end);
        if (k < 0) break;
      }
      if (walked != n) fail();
      rings.is_closed[static_cast<size_t>(v)] = closed;
    }
    rings.offsets.push_back(static_cast<int>(rings.vertices.size()));
  }
  return rings;
}

std::vector<std::vector<int>> boundary_loops(const Triangles& triangles, const MeshEdges& edges) {
  // partner[2 e + side]: the border edge reached from border edge e around its end `side` (0: where its
  // triangle's side begins, 1: where it ends), turning through the triangles of the fan; −1 where an edge of
  // three triangles stops the turn.
  struct End {
    int edge = -1, side = 0;
  };
  const auto is_border = [&](int e) { return edges.n_triangles(e) == 1; };
  const auto side_of = [&](int e) { return edges.sides[at(edges.offsets[at(e)])]; };
  const auto vertex_at = [&](int e, int side) {
    const int s = side_of(e);
    return triangles(s / 3, (s % 3 + side) % 3);
  };
  const auto turned = [&](int e, int side) {
    const int pivot = vertex_at(e, side);
    int triangle = side_of(e) / 3, edge = e;
    for (Eigen::Index guard = 0; guard <= triangles.rows(); ++guard) {
      int other = -1;  // the other edge of the triangle at the pivot
      for (int k = 0; k < 3; ++k) {
        const int candidate = edges.of_triangle(triangle, k);
        if (candidate != edge &&
            (triangles(triangle, k) == pivot || triangles(triangle, (k + 1) % 3) == pivot))
          other = candidate;
      }
      if (other < 0 || edges.n_triangles(other) > 2) return End{};
      if (is_border(other)) return End{other, vertex_at(other, 0) == pivot ? 0 : 1};
      const int begin = edges.offsets[at(other)];
      const int first = edges.sides[at(begin)] / 3, second = edges.sides[at(begin) + 1] / 3;
      if (first == second) return End{};
      triangle = first == triangle ? second : first;
      edge = other;
    }
    return End{};
  };
  std::vector<std::vector<int>> loops;
  std::vector<char> done(static_cast<size_t>(edges.n_edges()), 0);
  const auto walk = [&](int first, int first_side) {
    std::vector<int> loop;
    End here{first, first_side};  // enter the edge at this end
    while (here.edge >= 0 && !done[at(here.edge)]) {
      done[at(here.edge)] = 1;
      loop.push_back(vertex_at(here.edge, here.side));
      const End next = turned(here.edge, 1 - here.side);
      if (next.edge < 0) loop.push_back(vertex_at(here.edge, 1 - here.side));
      here = next;
    }
    loops.push_back(std::move(loop));
  };
  // Open pieces first, from their ends: from the one where the surface lies to the left of the walk, and from
  // the other only where its triangles are oriented against each other.
  for (int side = 0; side < 2; ++side)
    for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e)
      if (is_border(e) && !done[at(e)] && turned(e, side).edge < 0) walk(e, side);
  for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e)
    if (is_border(e) && !done[at(e)]) walk(e, 0);
  return loops;
}

std::vector<int> triangle_components(const MeshEdges& edges) {
  DisjointSets sets(static_cast<int>(edges.of_triangle.rows()));
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    const int begin = edges.offsets[static_cast<size_t>(e)];
    for (int s = begin + 1; s < edges.offsets[static_cast<size_t>(e) + 1]; ++s)
      sets.unite(edges.sides[at(begin)] / 3, edges.sides[at(s)] / 3);
  }
  return sets.labels();
}

std::optional<Eigen::Index> MeshTopology::genus() const {
  if (!is_manifold() || !is_oriented()) return std::nullopt;
  return (2 * n_components - n_boundary_loops - euler_characteristic) / 2;
}

MeshTopology mesh_topology(const Triangles& triangles, Eigen::Index n_vertices) {
  const MeshEdges edges = mesh_edges(triangles, n_vertices);
  MeshTopology topology;
  topology.n_triangles = triangles.rows();
  topology.n_edges = edges.n_edges();
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    if (triangles(f, 0) == triangles(f, 1) || triangles(f, 1) == triangles(f, 2) ||
        triangles(f, 2) == triangles(f, 0))
      topology.collapsed_triangles.push_back(static_cast<int>(f));
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    const int n = edges.n_triangles(e);
    if (n == 1) ++topology.n_boundary_edges;
    if (n > 2) topology.non_manifold_edges.push_back(static_cast<int>(e));
    if (n == 2) {
      const int begin = edges.offsets[static_cast<size_t>(e)];
      const int s = edges.sides[at(begin)], t = edges.sides[at(begin) + 1];
      if (triangles(s / 3, s % 3) == triangles(t / 3, t % 3))
        topology.inconsistent_edges.push_back(static_cast<int>(e));
    }
  }
  // Fans: corners of a vertex that share an edge of at most two triangles belong together.
  const Corners corners = corners_of_vertices(triangles, n_vertices);
  DisjointSets fans(static_cast<int>(corners.corners.size()));
  const auto corner_at = [&](int triangle, int vertex) {
    for (int k = 0; k < 3; ++k)
      if (triangles(triangle, k) == vertex) return 3 * triangle + k;
    return -1;
  };
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    const int begin = edges.offsets[static_cast<size_t>(e)], end = edges.offsets[static_cast<size_t>(e) + 1];
    for (int s = begin + 1; s < end; ++s)
      for (int k = 0; k < 2; ++k) {
        const int vertex = edges.vertices(e, k);
        fans.unite(corner_at(edges.sides[at(begin)] / 3, vertex), corner_at(edges.sides[at(s)] / 3, vertex));
      }
  }
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    const int begin = corners.offsets[static_cast<size_t>(v)],
              end = corners.offsets[static_cast<size_t>(v) + 1];
    if (begin == end) {
      ++topology.n_unused_vertices;
      continue;
    }
    for (int c = begin + 1; c < end; ++c)
      if (!fans.joined(corners.corners[at(c)], corners.corners[at(begin)])) {
        topology.non_manifold_vertices.push_back(static_cast<int>(v));
        break;
      }
  }
  topology.n_vertices = n_vertices - topology.n_unused_vertices;
  topology.euler_characteristic = topology.n_vertices - topology.n_edges + topology.n_triangles;
  const std::vector<int> components = triangle_components(edges);
  for (const int c : components) topology.n_components = std::max(topology.n_components, c + 1);
  topology.n_boundary_loops = static_cast<int>(boundary_loops(triangles, edges).size());

  const auto edge_name = [&](int e) {
    return concat("vertices ", edges.vertices(e, 0), " and ", edges.vertices(e, 1));
  };
  if (!topology.collapsed_triangles.empty())
    topology.problems.push_back(
        concat(topology.collapsed_triangles.size(), " triangles name a vertex twice, the first is triangle ",
               topology.collapsed_triangles[0], "; batten repair IN -o OUT leaves them out"));
  if (!topology.non_manifold_edges.empty())
    topology.problems.push_back(
        concat(topology.non_manifold_edges.size(), " edges have more than two triangles, the first between ",
               edge_name(topology.non_manifold_edges[0]), "; batten repair IN -o OUT separates the sheets"));
  if (!topology.non_manifold_vertices.empty())
    topology.problems.push_back(concat(topology.non_manifold_vertices.size(),
                                       " vertices join several fans of triangles, the first is vertex ",
                                       topology.non_manifold_vertices[0],
                                       "; batten repair IN -o OUT gives each fan its own"));
  if (!topology.inconsistent_edges.empty())
    topology.problems.push_back(concat("the triangles on both sides of ", topology.inconsistent_edges.size(),
                                       " edges are oriented against each other, the first between ",
                                       edge_name(topology.inconsistent_edges[0]),
                                       "; batten repair IN -o OUT orients them"));
  return topology;
}

}  // namespace batten
