#include "batten/mesh/essential_loops.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// What all roots share.
struct Surface {
  MeshEdges edges;
  std::vector<double> length;                 // of every edge
  std::vector<std::vector<int>> edges_of;     // of every vertex
  std::vector<std::pair<int, int>> cells_of;  // of every edge: its triangles, or a triangle and a border
  int n_cells = 0;

  Surface(const Points& positions, const Triangles& triangles)
      : edges(mesh_edges(triangles, positions.rows())),
        length(at(edges.n_edges())),
        edges_of(at(positions.rows())),
        cells_of(at(edges.n_edges())) {
    DisjointSets borders(static_cast<int>(positions.rows()));
    for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
      if (edges.n_triangles(e) == 1) borders.unite(edges.vertices(e, 0), edges.vertices(e, 1));
    const auto n_triangles = static_cast<int>(triangles.rows());
    n_cells = n_triangles + static_cast<int>(positions.rows());  // a border is named by a vertex
    for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
      const int u = edges.vertices(e, 0), v = edges.vertices(e, 1);
      length[at(e)] = (positions.row(u) - positions.row(v)).norm();
      edges_of[at(u)].push_back(static_cast<int>(e));
      edges_of[at(v)].push_back(static_cast<int>(e));
      const int* const sides = &edges.sides[at(edges.offsets[at(e)])];
      cells_of[at(e)] = {sides[0] / 3,
                         edges.n_triangles(e) > 1 ? sides[1] / 3 : n_triangles + borders.root(u)};
    }
  }
  int other_end(int edge, int vertex) const {
    return edges.vertices(edge, 0) == vertex ? edges.vertices(edge, 1) : edges.vertices(edge, 0);
  }
};

/// The shortest ways from a root.
struct Ways {
  std::vector<double> distance;
  std::vector<int> edge;  // back towards the root; −1 there and where none leads

  Ways(const Surface& surface, int root)
      : distance(surface.edges_of.size(), kFar), edge(surface.edges_of.size(), -1) {
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance[at(root)] = 0;
    queue.emplace(0, root);
    while (!queue.empty()) {
      const auto [d, v] = queue.top();
      queue.pop();
      if (d > distance[at(v)]) continue;
      for (const int e : surface.edges_of[at(v)]) {
        const int w = surface.other_end(e, v);
        const double through = d + surface.length[at(e)];
        if (through < distance[at(w)]) {
          distance[at(w)] = through;
          edge[at(w)] = e;
          queue.emplace(through, w);
        }
      }
    }
  }

  std::vector<int> from(const Surface& surface, int vertex) const {
    std::vector<int> way{vertex};
    while (edge[at(way.back())] >= 0) way.push_back(surface.other_end(edge[at(way.back())], way.back()));
    return way;
  }
};

/// The loop that an edge closes with the ways to its ends, less what both have in common.
EssentialLoop loop_of(const Surface& surface, const Ways& ways, int edge) {
  std::vector<int> there = ways.from(surface, surface.edges.vertices(edge, 0));
  std::vector<int> back = ways.from(surface, surface.edges.vertices(edge, 1));
  while (there.size() > 1 && back.size() > 1 && there[there.size() - 2] == back[back.size() - 2]) {
    there.pop_back();
    back.pop_back();
  }
  EssentialLoop loop;
  loop.length = ways.distance[at(there.front())] + ways.distance[at(back.front())] -
                2 * ways.distance[at(there.back())] + surface.length[at(edge)];
  loop.vertices = std::move(there);
  loop.vertices.insert(loop.vertices.end(), back.rbegin() + 1, back.rend());
  return loop;
}

/// The loops of one root: an edge that neither the tree has nor a tree of cells across the other edges
/// crosses. That one takes the edges farthest from the root first, so that the short loops remain.
void add_loops(const Surface& surface, int root, std::vector<EssentialLoop>& loops) {
  const Ways ways(surface, root);
  std::vector<std::pair<double, int>> others;  // minus the length of the way around, and the edge
  for (int e = 0; e < static_cast<int>(surface.length.size()); ++e) {
    const int u = surface.edges.vertices(e, 0), v = surface.edges.vertices(e, 1);
    if (ways.distance[at(u)] == kFar || ways.edge[at(u)] == e || ways.edge[at(v)] == e) continue;
    others.emplace_back(-(ways.distance[at(u)] + ways.distance[at(v)] + surface.length[at(e)]), e);
  }
  std::sort(others.begin(), others.end());
  DisjointSets cells(surface.n_cells);
  for (const auto& [order, e] : others) {
    const auto [first, second] = surface.cells_of[at(e)];
    if (cells.root(first) == cells.root(second))
      loops.push_back(loop_of(surface, ways, e));
    else
      cells.unite(first, second);
  }
}

/// Vertices of triangles, each as far from those before it as can be.
std::vector<int> spread_roots(const Points& positions, const Triangles& triangles, int count) {
  std::vector<int> roots;
  Eigen::VectorXd squared = Eigen::VectorXd::Constant(positions.rows(), -1);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (const int v : triangles.row(f)) squared[v] = kFar;
  while (static_cast<int>(roots.size()) < count) {
    Eigen::Index next = 0;
    if (!(squared.maxCoeff(&next) > 0)) break;
    roots.push_back(static_cast<int>(next));
    squared = squared.cwiseMin((positions.rowwise() - positions.row(next)).rowwise().squaredNorm());
  }
  return roots;
}

}  // namespace

std::vector<EssentialLoop> essential_loops(const Points& positions, const Triangles& triangles, int n_roots) {
  std::vector<EssentialLoop> loops;
  if (triangles.rows() == 0) return loops;
  const Surface surface(positions, triangles);
  for (const int root : spread_roots(positions, triangles, n_roots)) add_loops(surface, root, loops);
  std::stable_sort(loops.begin(), loops.end(),
                   [](const EssentialLoop& a, const EssentialLoop& b) { return a.length < b.length; });
  return loops;
}

}  // namespace batten
