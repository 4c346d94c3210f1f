#include "batten/mesh/mending.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/sheets_detail.hpp"
#include "batten/mesh/welding.hpp"

namespace batten {

namespace {

/// A vertex lies in an edge when it is no further from it than this share of the edge's length, and of the
/// length of the border edge at the vertex that runs along it.
constexpr double kOffEdge = 1e-3, kOffOwnEdge = 0.05;
/// Sine of the largest angle between two edges that run along each other.
constexpr double kAlong = 0.02;
/// What one round leaves, such as a hole of a triangle that is closed by the next, is little.
constexpr int kMostRounds = 8;

void check(const TriangleMesh& mesh) {
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    if (!mesh.positions.row(v).allFinite())
      throw InvalidInput(concat("vertex ", v, " has a coordinate that is not finite; give it a place"));
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      if (mesh.triangles(f, k) < 0 || mesh.triangles(f, k) >= mesh.n_vertices())
        throw InvalidInput(concat("triangle ", f, " names vertex ", mesh.triangles(f, k), ", but there are ",
                                  mesh.n_vertices(), "; mend the file, for its vertex cannot be guessed"));
}

/// Keeps the triangles that are not marked. @return how many were left out.
Eigen::Index leave_out(const std::vector<char>& marked, Triangles& triangles) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    if (marked[static_cast<size_t>(f)] == 0) triangles.row(kept++) = triangles.row(f).eval();
  const Eigen::Index n = triangles.rows() - kept;
  triangles.conservativeResize(kept, 3);
  return n;
}

Eigen::Index remove_repeated(Triangles& triangles) {
  std::vector<char> marked(static_cast<size_t>(triangles.rows()), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const int a = triangles(f, 0), b = triangles(f, 1), c = triangles(f, 2);
    marked[static_cast<size_t>(f)] = a == b || b == c || c == a;
  }
  return leave_out(marked, triangles);
}

Eigen::Index remove_degenerate(const Points& positions, Triangles& triangles) {
  std::vector<char> marked(static_cast<size_t>(triangles.rows()), 0);
  for (const int f : degenerate_triangles(positions, triangles)) marked[at(f)] = 1;
  return leave_out(marked, triangles);
}

/// Two flat squares over the same four corners, cut along different diagonals, are equal but for their
/// triangles. The later one is cut as the first, so that its triangles are found to be doubled.
void align_diagonals(const Points& positions, const std::vector<int>& place, Triangles& triangles) {
  Triangles at_places = triangles.unaryExpr([&](int v) { return place[at(v)]; });
  const MeshEdges edges = mesh_edges(at_places, positions.rows());
  struct Square {
    std::array<int, 4> places;  // increasing
    int f, k, g, l;             // side k of triangle f and side l of triangle g are its diagonal
    std::pair<int, int> diagonal;
  };
  std::vector<Square> squares;
  const auto at_place = [&](int v) { return Eigen::Vector3d(positions.row(v)); };
  for (int e = 0; e < static_cast<int>(edges.n_edges()); ++e) {
    if (edges.n_triangles(e) != 2) continue;
    const int s = edges.sides[at(edges.offsets[at(e)])], t = edges.sides[at(edges.offsets[at(e)]) + 1];
    const int a = edges.vertices(e, 0), b = edges.vertices(e, 1), c = at_places(s / 3, (s % 3 + 2) % 3),
              d = at_places(t / 3, (t % 3 + 2) % 3);
    if (c == d || orient3d(at_place(a), at_place(b), at_place(c), at_place(d)) != 0) continue;
    Square square{{a, b, c, d}, s / 3, s % 3, t / 3, t % 3, {a, b}};
    std::sort(square.places.begin(), square.places.end());
    squares.push_back(square);
  }
  std::stable_sort(squares.begin(), squares.end(),
                   [](const Square& a, const Square& b) { return a.places < b.places; });
  std::vector<char> done(static_cast<size_t>(triangles.rows()), 0);
  for (size_t i = 1; i < squares.size(); ++i) {
    const Square &one = squares[i - 1], &other = squares[i];
    if (one.places != other.places || one.diagonal == other.diagonal) continue;
    const auto [f, k, g, l] = std::tie(other.f, other.k, other.g, other.l);
    if (done[at(one.f)] != 0 || done[at(one.g)] != 0 || done[at(f)] != 0 || done[at(g)] != 0) continue;
    if (triangles(f, k) != triangles(g, (l + 1) % 3) || triangles(f, (k + 1) % 3) != triangles(g, l))
      continue;
    for (const int triangle : {one.f, one.g, f, g}) done[at(triangle)] = 1;
    const int a = triangles(f, k), b = triangles(f, (k + 1) % 3), c = triangles(f, (k + 2) % 3),
              d = triangles(g, (l + 2) % 3);
    triangles.row(f) << a, d, c;
    triangles.row(g) << d, b, c;
  }
}

/// Triangles over the same three places.
struct EqualTriangles {
  std::array<int, 3> places;        // increasing
  std::vector<int> same, opposite;  // as they go around, compared with the first
};

/// Leaves out triangles that lie on equal ones.
Eigen::Index remove_doubled(const Points& positions, Triangles& triangles) {
  const auto m = static_cast<int>(triangles.rows());
  const std::vector<int> place = places_of_vertices(positions);
  align_diagonals(positions, place, triangles);
  struct Entry {
    std::array<int, 3> places;
    int triangle;
    bool odd;
  };
  std::vector<Entry> entries(at(m));
  for (int f = 0; f < m; ++f) {
    std::array<int, 3> p{place[at(triangles(f, 0))], place[at(triangles(f, 1))], place[at(triangles(f, 2))]};
    const bool odd = (p[0] > p[1]) != ((p[1] > p[2]) != (p[0] > p[2]));
    std::sort(p.begin(), p.end());
    entries[at(f)] = {p, f, odd};
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.places != b.places ? a.places < b.places : a.triangle < b.triangle;
  });
  std::vector<char> marked(at(m), 0);
  std::vector<EqualTriangles> walls;  // as many to either side
  for (size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    EqualTriangles equal{entries[begin].places, {}, {}};
    for (end = begin; end < entries.size() && entries[end].places == equal.places; ++end)
      (entries[end].odd == entries[begin].odd ? equal.same : equal.opposite).push_back(entries[end].triangle);
    if (end - begin == 1) continue;
    const int kept = equal.opposite.size() > equal.same.size() ? equal.opposite[0] : equal.same[0];
    for (size_t k = begin; k < end; ++k)
      if (entries[k].triangle != kept) marked[at(entries[k].triangle)] = 1;
    if (equal.same.size() == equal.opposite.size()) walls.push_back(std::move(equal));
  }
  if (!walls.empty()) {
    // A wall goes altogether where at least two other triangles close each edge of its border.
    std::map<std::pair<int, int>, std::vector<int>> walls_at;
    for (size_t w = 0; w < walls.size(); ++w)
      for (size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(walls[w].places[k], walls[w].places[(k + 1) % 3]);
        walls_at[{low, high}].push_back(static_cast<int>(w));
      }
    std::map<std::pair<int, int>, int> others;
    std::vector<char> in_wall(at(m), 0);
    for (const EqualTriangles& wall : walls) {
      for (const int f : wall.same) in_wall[at(f)] = 1;
      for (const int f : wall.opposite) in_wall[at(f)] = 1;
    }
    for (int f = 0; f < m; ++f) {
      if (in_wall[at(f)] != 0 || marked[at(f)] != 0) continue;
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] =
            std::minmax(place[at(triangles(f, k))], place[at(triangles(f, (k + 1) % 3))]);
        if (walls_at.count({low, high}) > 0) ++others[{low, high}];
      }
    }
    DisjointSets sets(static_cast<int>(walls.size()));
    for (const auto& [edge, at_edge] : walls_at)
      for (const int w : at_edge) sets.unite(at_edge[0], w);
    std::vector<char> stays(walls.size(), 0), has_border(walls.size(), 0);
    for (const auto& [edge, at_edge] : walls_at) {
      if (at_edge.size() > 1) continue;
      const size_t wall = at(sets.root(at_edge[0]));
      has_border[wall] = 1;
      if (others[edge] < 2) stays[wall] = 1;
    }
    for (size_t w = 0; w < walls.size(); ++w) {
      const size_t root = at(sets.root(static_cast<int>(w)));
      if (stays[root] != 0 || has_border[root] == 0) continue;
      for (const int f : walls[w].same) marked[at(f)] = 1;
    }
  }
  return leave_out(marked, triangles);
}

/// Vertices found in one side of a triangle, by their place along it.
using OnSide = std::vector<std::pair<double, int>>;

/// A triangle with further corners in its sides, cut from the opposite corner, side by side.
void divide(std::array<int, 3> corners, std::array<OnSide, 3> on_side,
            std::vector<std::array<int, 3>>& result) {
  for (size_t k = 0; k < 3; ++k) {
    if (on_side[k].empty()) continue;
    const size_t middle = on_side[k].size() / 2;
    const int vertex = on_side[k][middle].second, opposite = corners[(k + 2) % 3];
    const OnSide first(on_side[k].begin(), on_side[k].begin() + static_cast<std::ptrdiff_t>(middle)),
        second(on_side[k].begin() + static_cast<std::ptrdiff_t>(middle) + 1, on_side[k].end());
    divide({corners[k], vertex, opposite}, {first, {}, on_side[(k + 2) % 3]}, result);
    divide({vertex, corners[(k + 1) % 3], opposite}, {second, on_side[(k + 1) % 3], {}}, result);
    return;
  }
  result.push_back(corners);
}

/// Makes vertices in the middle of border edges corners of their triangles. @return how many.
Eigen::Index insert_junctions(const Points& positions, Triangles& triangles, double tolerance) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  std::vector<int> borders;                                                         // sides
  std::vector<std::vector<int>> neighbours(static_cast<size_t>(positions.rows()));  // along borders
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    if (edges.n_triangles(e) != 1) continue;
    borders.push_back(edges.sides[at(edges.offsets[static_cast<size_t>(e)])]);
    const int a = edges.vertices(e, 0), b = edges.vertices(e, 1);
    neighbours[at(a)].push_back(b);
    neighbours[at(b)].push_back(a);
  }
  if (borders.empty()) return 0;
  const auto corner = [&](int side, int k) { return triangles(side / 3, (side % 3 + k) % 3); };
  std::vector<Box> boxes;
  boxes.reserve(borders.size());
  for (const int side : borders) {
    const Eigen::Vector3d a = positions.row(corner(side, 0)), b = positions.row(corner(side, 1));
    const double reach = std::max(tolerance, kOffEdge * (b - a).norm());
    boxes.push_back({a.cwiseMin(b).array() - reach, a.cwiseMax(b).array() + reach});
  }
  const BoxTree tree(boxes);
  std::vector<std::array<OnSide, 3>> on_sides(static_cast<size_t>(triangles.rows()));
  Eigen::Index n = 0;
  for (int v = 0; v < static_cast<int>(positions.rows()); ++v) {
    if (neighbours[at(v)].empty()) continue;
    const Eigen::Vector3d p = positions.row(v);
    tree.query({p, p}, [&](int border) {
      const int side = borders[at(border)];
      if (corner(side, 0) == v || corner(side, 1) == v || corner(side, 2) == v) return true;
      const Eigen::Vector3d a = positions.row(corner(side, 0)),
                            along = positions.row(corner(side, 1)).transpose() - a;
      const double length = along.norm(), place = (p - a).dot(along) / (length * length);
      const double off = (p - a - place * along).norm();
      const double end = std::min(place, 1 - place) * length;
      if (!(off <= std::max(tolerance, kOffEdge * length) && end > std::max(tolerance, off))) return true;
      const auto runs_along = [&](int w) {
        const Eigen::Vector3d own = positions.row(w).transpose() - p;
        return off <= std::max(tolerance, kOffOwnEdge * own.norm()) &&
               own.cross(along).norm() <= kAlong * own.norm() * length;
      };
      if (std::none_of(neighbours[at(v)].begin(), neighbours[at(v)].end(), runs_along)) return true;
      on_sides[at(side / 3)][at(side % 3)].emplace_back(place, v);
      ++n;
      return true;
    });
  }
  if (n == 0) return 0;
  std::vector<std::array<int, 3>> result;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    auto& on_side = on_sides[static_cast<size_t>(f)];
    for (OnSide& found : on_side) std::sort(found.begin(), found.end());
    divide({triangles(f, 0), triangles(f, 1), triangles(f, 2)}, on_side, result);
  }
  triangles = Eigen::Map<const Triangles>(result[0].data(), static_cast<Eigen::Index>(result.size()), 3);
  return n;
}

/// Vertices in use, in their order, with what belongs to them.
TriangleMesh used_part(const TriangleMesh& source, const Points& positions, const Triangles& triangles,
                       const detail::Origins& origins) {
  std::vector<int> number(static_cast<size_t>(positions.rows()), -1);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) number[at(triangles(f, k))] = 0;
  int n = 0;
  for (int& place : number)
    if (place == 0) place = n++;
  TriangleMesh mesh;
  mesh.positions.resize(n, 3);
  mesh.normals.resize(source.normals.rows() > 0 ? n : 0, 3);
  for (const auto& [name, values] : source.vertex_values) mesh.vertex_values[name].resize(n);
  for (size_t v = 0; v < number.size(); ++v) {
    const Eigen::Index to = number[v];
    if (to < 0) continue;
    const auto [one, other] = origins[v];
    mesh.positions.row(to) = positions.row(static_cast<Eigen::Index>(v));
    if (mesh.normals.rows() > 0)
      mesh.normals.row(to) =
          one == other ? source.normals.row(one).eval()
                       : (source.normals.row(one) + source.normals.row(other)).stableNormalized().eval();
    for (const auto& [name, values] : source.vertex_values)
      mesh.vertex_values[name](to) = one == other ? values(one) : (values(one) + values(other)) / 2;
  }
  mesh.triangles = triangles.unaryExpr([&](int v) { return number[at(v)]; });
  return mesh;
}

}  // namespace

std::optional<std::string> MendingOptions::problem() const {
  if (tolerance && !(*tolerance >= 0 && std::isfinite(*tolerance)))
    return concat("tolerance must be at least 0, got ", *tolerance);
  return std::nullopt;
}

MendedMesh mended_mesh(const TriangleMesh& mesh, const MendingOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  check(mesh);
  MendedMesh result;
  MendingReport& report = result.report;
  Points positions = mesh.positions;
  Triangles triangles = mesh.triangles;
  {
    std::vector<char> used(static_cast<size_t>(positions.rows()), 0);
    for (Eigen::Index f = 0; f < triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) used[at(triangles(f, k))] = 1;
    report.unused = std::count(used.begin(), used.end(), 0);
  }
  for (int round = 0; round < kMostRounds; ++round) {
    progress.report("mend", 0.5 * round / kMostRounds);
    Eigen::Index changes = 0;
    const auto count = [&changes](Eigen::Index& kind, Eigen::Index n) {
      kind += n;
      changes += n;
    };
    count(report.repeated, remove_repeated(triangles));
    count(report.degenerate, remove_degenerate(positions, triangles));
    count(report.doubled, remove_doubled(positions, triangles));
    double tolerance = 0;
    if (options.weld) {
      const VertexWelding welding = options.tolerance ? weld_borders(positions, triangles, *options.tolerance)
                                                      : weld_borders(positions, triangles);
      tolerance = welding.tolerance;
      count(report.welded, welding.n_welded);
      if (welding.n_welded > 0) {
        report.tolerance = std::max(report.tolerance, tolerance);
        const Eigen::Index before = triangles.rows();
        triangles = welded_triangles(triangles, welding);
        count(report.degenerate, before - triangles.rows());
      }
    }
    progress.report("mend", 0.5 * (round + 0.5) / kMostRounds);
    count(report.junctions, options.weld ? insert_junctions(positions, triangles, tolerance) : 0);
    if (changes == 0) break;
  }
  detail::Origins origins(static_cast<size_t>(positions.rows()));
  for (size_t v = 0; v < origins.size(); ++v) origins[v] = {static_cast<int>(v), static_cast<int>(v)};
  detail::cut_into_sheets(positions, triangles, origins, options.orient, report, progress);
  if (!report.changed()) {
    result.mesh = mesh;
    return result;
  }
  result.mesh = used_part(mesh, positions, triangles, origins);
  return result;
}

}  // namespace batten
