#include "batten/mesh/welding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

/// Share of its shortest edge by which a vertex may be moved unasked: below a half, no edge can close.
constexpr double kReach = 0.2;
/// Tolerances that are tried unasked, in diameters: from the rounding of double to that of coordinates with
/// four digits.
constexpr double kSmallestTolerance = 1e-12, kFirstTolerance = 1e-9, kLargestTolerance = 1e-4;
constexpr int kDecades = 6;  // from the first to the largest, both included
/// A larger tolerance is taken where it closes at least this share of what can be closed.
constexpr double kWorthwhile = 0.02;
/// Triangles with a smaller angle between them lie on each other: their edges are two borders, no seam.
constexpr double kFoldCosine = 0.985;  // 10 degrees

std::vector<char> border_vertices(const MeshEdges& edges, Eigen::Index n) {
  std::vector<char> on_border(static_cast<size_t>(n), 0);
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    if (edges.n_triangles(e) == 1 && edges.vertices(e, 0) != edges.vertices(e, 1))
      for (int k = 0; k < 2; ++k) on_border[at(edges.vertices(e, k))] = 1;
  return on_border;
}

/// Per vertex the furthest that it may be moved.
std::vector<double> reaches(const Points& positions, const MeshEdges& edges) {
  std::vector<double> reach(static_cast<size_t>(positions.rows()), std::numeric_limits<double>::infinity());
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    const int a = edges.vertices(e, 0), b = edges.vertices(e, 1);
    const double length = (positions.row(a) - positions.row(b)).norm();
    if (length == 0) continue;
    for (const int v : {a, b}) reach[at(v)] = std::min(reach[at(v)], kReach * length);
  }
  return reach;
}

/// Vertices that stand for themselves, found by place. Cells are twice as wide as the tolerance, so that the
/// eight around the nearest corner hold everything within it. Cells that fall into one bucket are only looked
/// at in vain.
class Grid {
 public:
  Grid(const Points& positions, double tolerance, size_t n)
      : positions_(positions),
        width_(std::max(2 * tolerance, std::numeric_limits<double>::min())),
        next_(static_cast<size_t>(positions.rows()), -1) {
    size_t size = 16;
    while (size < 2 * n) size *= 2;
    first_.assign(size, -1);
    if (positions.rows() > 0) low_ = positions.colwise().minCoeff();
  }

  void insert(int vertex) {
    int& first = first_[bucket(cell_of(vertex, 0))];
    next_[at(vertex)] = first;
    first = vertex;
  }

  template <typename Visit>
  void visit_around(int vertex, Visit visit) const {
    // The cell of the vertex moved back by half a cell, and its upper neighbours.
    const Cell cell = cell_of(vertex, 0.5);
    for (int corner = 0; corner < 8; ++corner) {
      Cell c = cell;
      for (size_t k = 0; k < 3; ++k) c[k] += corner >> k & 1;
      for (int v = first_[bucket(c)]; v >= 0; v = next_[at(v)]) visit(v);
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  Cell cell_of(int vertex, double back) const {
    Cell cell{};
    for (int k = 0; k < 3; ++k)
      cell[static_cast<size_t>(k)] =
          static_cast<std::int64_t>(std::floor((positions_(vertex, k) - low_(k)) / width_ - back));
    return cell;
  }
  size_t bucket(const Cell& cell) const {
    std::uint64_t hash = 0x9E3779B97F4A7C15ull;
    for (const std::int64_t value : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(value)) * 0xD6E8FEB86659FD93ull;
      hash ^= hash >> 32;
    }
    return static_cast<size_t>(hash) & (first_.size() - 1);
  }

  const Points& positions_;
  double width_;
  Eigen::RowVector3d low_ = Eigen::RowVector3d::Zero();
  std::vector<int> first_;  // per bucket
  std::vector<int> next_;   // per vertex: the one before it in its bucket, or −1
};

/// Welds the chosen vertices. @param reach per vertex, or empty for no limit but the tolerance.
VertexWelding weld(const Points& positions, const std::vector<int>& place, const std::vector<char>& chosen,
                   double tolerance, const std::vector<double>& reach) {
  VertexWelding welding;
  welding.tolerance = tolerance;
  const auto n = static_cast<int>(positions.rows());
  welding.vertex_of.resize(static_cast<size_t>(n));
  std::iota(welding.vertex_of.begin(), welding.vertex_of.end(), 0);
  // Vertices at one place first: what is left is small, and a tolerance of 0 needs no grid.
  std::vector<int> first_at(static_cast<size_t>(n), -1);
  std::vector<int> left;
  for (int v = 0; v < n; ++v) {
    if (chosen[at(v)] == 0) continue;
    int& first = first_at[at(place[at(v)])];
    if (first >= 0) {
      welding.vertex_of[at(v)] = first;
      ++welding.n_welded;
    } else {
      first = v;
      left.push_back(v);
    }
  }
  if (!(tolerance > 0)) return welding;
  Grid grid(positions, tolerance, left.size());
  for (const int v : left) {
    int nearest = -1;
    double least = tolerance;
    if (!reach.empty()) least = std::min(least, reach[at(v)]);
    grid.visit_around(v, [&](int u) {
      const double distance = (positions.row(u) - positions.row(v)).norm();
      if (distance > least || (!reach.empty() && distance > reach[at(u)])) return;
      if (distance < least || nearest < 0 || u < nearest) nearest = u;
      least = distance;
    });
    if (nearest < 0) {
      grid.insert(v);
      continue;
    }
    welding.vertex_of[at(v)] = nearest;
    ++welding.n_welded;
  }
  for (int& v : welding.vertex_of) v = welding.vertex_of[at(v)];  // those at one place follow their first
  return welding;
}

/// Edges that stay open after welding, or whose two triangles would lie on each other.
Eigen::Index open_edges(const Points& positions, const Triangles& triangles, const VertexWelding& welding) {
  const Triangles welded = welded_triangles(triangles, welding);
  const MeshEdges edges = mesh_edges(welded, positions.rows());
  Eigen::Index open = 0;
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    if (edges.n_triangles(e) == 1) ++open;
    if (edges.n_triangles(e) != 2) continue;
    const Eigen::RowVector3d a = positions.row(edges.vertices(e, 0)),
                             along = (positions.row(edges.vertices(e, 1)) - a).stableNormalized();
    Eigen::RowVector3d away[2];
    for (int s = 0; s < 2; ++s) {
      const int side = edges.sides[at(edges.offsets[static_cast<size_t>(e)] + s)];
      const Eigen::RowVector3d d = positions.row(welded(side / 3, (side % 3 + 2) % 3)) - a;
      away[s] = (d - d.dot(along) * along).stableNormalized();
    }
    if (away[0].dot(away[1]) > kFoldCosine) open += 2;
  }
  return open;
}

}  // namespace

std::vector<int> places_of_vertices(const Points& positions) {
  const auto n = static_cast<size_t>(positions.rows());
  std::vector<int> order(n), number(n);
  std::iota(order.begin(), order.end(), 0);
  const auto compare = [&](int i, int j) {
    for (int k = 0; k < 3; ++k)
      if (positions(i, k) != positions(j, k)) return positions(i, k) < positions(j, k) ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const int c = compare(i, j);
    return c != 0 ? c < 0 : i < j;
  });
  for (size_t k = 0; k < n; ++k)
    number[at(order[k])] =
        k > 0 && compare(order[k - 1], order[k]) == 0 ? number[at(order[k - 1])] : order[k];
  return number;
}

VertexWelding weld_borders(const Points& positions, const Triangles& triangles, double tolerance) {
  if (!(tolerance >= 0)) throw InvalidInput(concat("the weld tolerance must be at least 0, got ", tolerance));
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  return weld(positions, places_of_vertices(positions), border_vertices(edges, positions.rows()), tolerance,
              {});
}

VertexWelding weld_borders(const Points& positions, const Triangles& triangles) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  const std::vector<char> chosen = border_vertices(edges, positions.rows());
  const std::vector<int> place = places_of_vertices(positions);
  const std::vector<double> reach = reaches(positions, edges);
  const double diameter = bounding_box_diagonal(positions);
  const auto welded_within = [&](double relative) {
    return weld(positions, place, chosen, relative * diameter, reach);
  };
  VertexWelding best = welded_within(kSmallestTolerance);
  VertexWelding most = welded_within(kLargestTolerance);
  if (most.n_welded == best.n_welded) return best;
  const Eigen::Index open = open_edges(positions, triangles, best),
                     least = open_edges(positions, triangles, most);
  if (least >= open) return best;
  // By bisection: a larger tolerance never closes less that matters here.
  const double enough = static_cast<double>(least) + kWorthwhile * static_cast<double>(open - least);
  int too_small = 0, decades = kDecades;  // above kFirstTolerance / 10, where the last is kLargestTolerance
  while (decades - too_small > 1) {
    const int middle = (too_small + decades) / 2;
    VertexWelding next = welded_within(kFirstTolerance * std::pow(10, middle - 1));
    if (static_cast<double>(open_edges(positions, triangles, next)) <= enough) {
      most = std::move(next);
      decades = middle;
    } else {
      too_small = middle;
    }
  }
  return most;
}

bool is_triangle_soup(const Triangles& triangles, const VertexWelding& welding) {
  const auto n = static_cast<Eigen::Index>(welding.vertex_of.size());
  const auto n_open = [n](const Triangles& of) {
    const MeshEdges edges = mesh_edges(of, n);
    Eigen::Index open = 0;
    for (Eigen::Index e = 0; e < edges.n_edges(); ++e) open += edges.n_triangles(e) == 1;
    return open;
  };
  const Eigen::Index before = n_open(triangles);
  return 2 * before > 3 * triangles.rows() && 2 * n_open(welded_triangles(triangles, welding)) < before;
}

Triangles welded_triangles(const Triangles& triangles, const VertexWelding& welding) {
  Triangles welded(triangles.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const auto corner = [&](int k) { return welding.vertex_of[at(triangles(f, k))]; };
    const int a = corner(0), b = corner(1), c = corner(2);
    if (a == b || b == c || c == a) continue;
    welded.row(count++) << a, b, c;
  }
  welded.conservativeResize(count, 3);
  return welded;
}

TriangleMesh without_vertices(const TriangleMesh& mesh, const std::vector<char>& gone) {
  std::vector<int> kept, number;
  for (size_t v = 0; v < gone.size(); ++v) {
    number.push_back(static_cast<int>(kept.size()));
    if (gone[v] == 0) kept.push_back(static_cast<int>(v));
  }
  TriangleMesh result;
  result.positions = mesh.positions(kept, Eigen::all);
  if (mesh.normals.rows() > 0) result.normals = mesh.normals(kept, Eigen::all);
  for (const auto& [name, values] : mesh.vertex_values) result.vertex_values[name] = values(kept);
  result.triangles = mesh.triangles.unaryExpr([&](int v) { return number[at(v)]; });
  return result;
}

}  // namespace batten
