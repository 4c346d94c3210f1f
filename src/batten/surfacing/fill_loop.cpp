#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/surfacing/fill_loop_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

/// Corners of the polygon beyond which the dynamic programme (cubic time) runs on every k-th one only.
constexpr std::size_t kMostCorners = 420;
/// How much a triangle turned by 180° from the normals of its corners counts more than one along them. Large:
/// a tube must not be closed by two caps, whose area may be smaller.
constexpr double kTurnPenalty = 20;

/// One closed polygon: all loops joined by bridges that are walked forth and back.
struct Polygon {
  std::vector<int> corner;                ///< local vertex per corner; vertices on bridges come twice
  std::vector<Vector3d> points, normals;  ///< per local vertex
  int n_network = 0;
  std::vector<int> network_vertices;
};

Polygon joined_loops(const Points& positions, const Points& normals, const NetworkCycle& cycle, double edge) {
  Polygon polygon;
  std::map<int, int> local;
  std::vector<std::vector<int>> loops;
  for (const NetworkCycle::Loop& loop : cycle.loops) {
    loops.emplace_back();
    for (const int v : loop.vertices) {
      const auto [place, is_new] = local.emplace(v, static_cast<int>(polygon.points.size()));
      if (is_new) {
        polygon.points.push_back(positions.row(v));
        polygon.normals.push_back(normals.row(v));
        polygon.network_vertices.push_back(v);
      }
      loops.back().push_back(place->second);
    }
  }
  polygon.n_network = static_cast<int>(polygon.points.size());
  polygon.corner = loops.front();
  std::vector<char> used(loops.size(), 0);
  used[0] = 1;
  for (std::size_t round = 1; round < loops.size(); ++round) {
    // The shortest bridge from what is joined to a loop that is not. A margin decides ties by order, so that
    // rounding does not.
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t at = 0, which = 0, there = 0;
    for (std::size_t l = 0; l < loops.size(); ++l) {
      if (used[l]) continue;
      for (std::size_t i = 0; i < polygon.corner.size(); ++i)
        for (std::size_t j = 0; j < loops[l].size(); ++j) {
          const double d = (polygon.points[polygon.corner[i]] - polygon.points[loops[l][j]]).norm();
          if (d < nearest * (1 - 1e-7)) {
            nearest = d;
            at = i;
            which = l;
            there = j;
          }
        }
    }
    used[which] = 1;
    const int from = polygon.corner[at], to = loops[which][there];
    const int pieces = std::max(1, static_cast<int>(std::lround(nearest / edge)));
    std::vector<int> bridge;
    for (int k = 1; k < pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      bridge.push_back(static_cast<int>(polygon.points.size()));
      polygon.points.push_back((1 - t) * polygon.points[from] + t * polygon.points[to]);
      const Vector3d normal = (1 - t) * polygon.normals[from] + t * polygon.normals[to];
      polygon.normals.push_back(normal.norm() > 1e-9 ? Vector3d(normal.normalized()) : polygon.normals[from]);
    }
    std::vector<int> walk(polygon.corner.begin(),
                          polygon.corner.begin() + static_cast<std::ptrdiff_t>(at) + 1);
    walk.insert(walk.end(), bridge.begin(), bridge.end());
    for (std::size_t k = 0; k <= loops[which].size(); ++k)
      walk.push_back(loops[which][(there + k) % loops[which].size()]);
    walk.insert(walk.end(), bridge.rbegin(), bridge.rend());
    walk.insert(walk.end(), polygon.corner.begin() + static_cast<std::ptrdiff_t>(at), polygon.corner.end());
    polygon.corner = std::move(walk);
  }
  return polygon;
}

/// Triangles (corner places i < j < k) of the least cost over the chosen corners of a polygon.
std::vector<std::array<int, 3>> least_triangulation(const Polygon& polygon, const std::vector<int>& chosen) {
  const int n = static_cast<int>(chosen.size());
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto vertex = [&](int i) { return polygon.corner[chosen[i]]; };
  const auto cost = [&](int i, int j, int k) {
    const int a = vertex(i), b = vertex(j), c = vertex(k);
    if (a == b || b == c || c == a) return kInfinite;
    const Vector3d area =
        (polygon.points[b] - polygon.points[a]).cross(polygon.points[c] - polygon.points[a]);
    const Vector3d normal = polygon.normals[a] + polygon.normals[b] + polygon.normals[c];
    const double size = area.norm(), scale = size * normal.norm();
    const double cosine = scale > 0 ? area.dot(normal) / scale : 0;
    return size * (1 + kTurnPenalty * (1 - cosine));
  };
  std::vector<double> best(static_cast<std::size_t>(n) * n, 0);
  std::vector<int> apex(static_cast<std::size_t>(n) * n, -1);
  const auto at = [n](int i, int j) { return static_cast<std::size_t>(i) * n + j; };
  for (int span = 2; span < n; ++span)
    for (int i = 0; i + span < n; ++i) {
      const int k = i + span;
      double least = kInfinite;
      int choice = -1;
      // A chord between the two copies of one vertex would be a loop.
      if (vertex(i) != vertex(k))
        for (int j = i + 1; j < k; ++j) {
          const double parts = best[at(i, j)] + best[at(j, k)];
          if (!(parts < least)) continue;
          const double sum = parts + cost(i, j, k);
          if (sum < least) {
            least = sum;
            choice = j;
          }
        }
      best[at(i, k)] = least;
      apex[at(i, k)] = choice;
    }
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::pair<int, int>> stack = {{0, n - 1}};
  while (!stack.empty()) {
    const auto [i, k] = stack.back();
    stack.pop_back();
    if (k - i < 2) continue;
    const int j = apex[at(i, k)];
    if (j < 0) return {};
    triangles.push_back({i, j, k});
    stack.emplace_back(i, j);
    stack.emplace_back(j, k);
  }
  return triangles;
}

/// The triangulation of the whole polygon: that of the chosen corners, with fans over the ones left out.
std::vector<std::array<int, 3>> coarse_triangles(const Polygon& polygon) {
  const std::size_t n = polygon.corner.size();
  const std::size_t stride = (n + kMostCorners - 1) / kMostCorners;
  std::vector<int> chosen;
  for (std::size_t i = 0; i < n; ++i)
    if (i % stride == 0) chosen.push_back(static_cast<int>(i));
  std::vector<std::array<int, 3>> result;
  for (const auto& [a, b, c] : least_triangulation(polygon, chosen)) {
    // The outline of the triangle with the corners left out along its sides; at most one side of a triangle
    // of a large polygon lies on the outline, a fan from the opposite corner covers it.
    const int corner[3] = {a, b, c};
    std::vector<std::vector<int>> side(3);
    for (int k = 0; k < 3; ++k) {
      const int from = chosen[corner[k]], to = chosen[corner[(k + 1) % 3]];
      side[k].push_back(from);
      const bool neighbours = corner[(k + 1) % 3] == corner[k] + 1 ||
                              (corner[k] == static_cast<int>(chosen.size()) - 1 && corner[(k + 1) % 3] == 0);
      if (neighbours)
        for (std::size_t i = static_cast<std::size_t>(from) + 1; i % n != static_cast<std::size_t>(to); ++i)
          side[k].push_back(static_cast<int>(i % n));
    }
    // Fan over every side in turn: start at the corner opposite the first side that has further vertices.
    int apex = 2;
    for (int k = 0; k < 3; ++k)
      if (side[k].size() > 1) {
        apex = (k + 2) % 3;
        break;
      }
    std::vector<int> outline;
    for (int k = 0; k < 3; ++k)
      outline.insert(outline.end(), side[(apex + k) % 3].begin(), side[(apex + k) % 3].end());
    for (std::size_t i = 1; i + 1 < outline.size(); ++i)
      result.push_back({outline[0], outline[i], outline[i + 1]});
  }
  return result;
}

/// A mesh known by its edge lengths alone.
struct Intrinsic {
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<double, 3>> lengths;  ///< opposite the corners
  int n_vertices = 0;

  void flip_to_delaunay() {
    Triangles T(static_cast<Eigen::Index>(triangles.size()), 3);
    EdgeLengths L(T.rows(), 3);
    for (std::size_t f = 0; f < triangles.size(); ++f)
      for (int k = 0; k < 3; ++k) {
        T(static_cast<Eigen::Index>(f), k) = triangles[f][k];
        L(static_cast<Eigen::Index>(f), k) = lengths[f][k];
      }
    const IntrinsicTriangulation flipped = intrinsic_delaunay(T, L);
    for (std::size_t f = 0; f < triangles.size(); ++f)
      for (int k = 0; k < 3; ++k) {
        triangles[f][k] = flipped.triangles(static_cast<Eigen::Index>(f), k);
        lengths[f][k] = flipped.lengths(static_cast<Eigen::Index>(f), k);
      }
  }
};

/// Corners of a triangle laid out in the plane.
std::array<Eigen::Vector2d, 3> laid_out(const std::array<double, 3>& l) {
  const double x = (l[1] * l[1] + l[2] * l[2] - l[0] * l[0]) / (2 * l[2]);
  const double area = triangle_area(l[0], l[1], l[2]);
  return {Eigen::Vector2d(0, 0), Eigen::Vector2d(l[2], 0), Eigen::Vector2d(x, 2 * area / l[2])};
}

/// Puts vertices into triangles above the area or far from equilateral until there are none, flipping to
/// Delaunay after every round ([liepa2003], in the metric of the coarse triangles instead of in space).
void refine(Intrinsic& mesh, double edge) {
  const double max_area = 0.5 * edge * edge;
  for (int round = 0; round < 40; ++round) {
    mesh.flip_to_delaunay();
    Triangles T(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
      for (int k = 0; k < 3; ++k) T(static_cast<Eigen::Index>(f), k) = mesh.triangles[f][k];
    const std::vector<int> opposite = opposite_half_edges(T);
    std::vector<char> touched(mesh.triangles.size(), 0);
    bool inserted = false;
    const std::size_t count = mesh.triangles.size();
    for (std::size_t f = 0; f < count; ++f) {
      if (touched[f]) continue;
      const std::array<double, 3> l = mesh.lengths[f];
      const double area = triangle_area(l[0], l[1], l[2]);
      const int longest = static_cast<int>(std::max_element(l.begin(), l.end()) - l.begin());
      const double shortest = *std::min_element(l.begin(), l.end());
      const double circumradius = area > 0 ? l[0] * l[1] * l[2] / (4 * area) : 0;
      const bool large = area > max_area;
      const bool thin = l[longest] > 1.5 * edge && circumradius > 1.46 * shortest;
      if (!large && !thin) continue;
      const int other = opposite[3 * f + static_cast<std::size_t>(longest)];
      const double squares[3] = {l[0] * l[0], l[1] * l[1], l[2] * l[2]};
      const bool obtuse = 2 * squares[longest] > squares[0] + squares[1] + squares[2];
      if ((obtuse || thin) && other >= 0) {
        // Halve the longest edge, in both of its triangles.
        const auto g = static_cast<std::size_t>(other / 3);
        if (touched[g]) continue;
        const int v = mesh.n_vertices++;
        const auto halve = [&](std::size_t t, int k) {
          const std::array<int, 3> corners = mesh.triangles[t];
          const std::array<double, 3> sides = mesh.lengths[t];
          const int i = (k + 1) % 3, j = (k + 2) % 3;
          const double e = sides[k];
          // Length of the median from corner k.
          const double median =
              0.5 * std::sqrt(std::max(0.0, 2 * sides[i] * sides[i] + 2 * sides[j] * sides[j] - e * e));
          // (k, i, v) keeps the number, (k, v, j) is new; the side opposite i joins j and k.
          mesh.triangles[t] = {corners[k], corners[i], v};
          mesh.lengths[t] = {e / 2, median, sides[j]};
          mesh.triangles.push_back({corners[k], v, corners[j]});
          mesh.lengths.push_back({e / 2, sides[i], median});
        };
        halve(f, longest);
        halve(g, other % 3);
        touched[f] = touched[g] = 1;
        inserted = true;
        continue;
      }
      if (!large) continue;
      const auto p = laid_out(l);
      const Eigen::Vector2d centroid = (p[0] + p[1] + p[2]) / 3;
      const int v = mesh.n_vertices++;
      const std::array<int, 3> corners = mesh.triangles[f];
      double spoke[3];
      for (int k = 0; k < 3; ++k) spoke[k] = (p[k] - centroid).norm();
      for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const std::array<int, 3> triangle = {v, corners[i], corners[j]};
        const std::array<double, 3> sides = {l[k], spoke[j], spoke[i]};
        if (k == 0) {
          mesh.triangles[f] = triangle;
          mesh.lengths[f] = sides;
        } else {
          mesh.triangles.push_back(triangle);
          mesh.lengths.push_back(sides);
        }
      }
      touched[f] = 1;
      inserted = true;
    }
    if (!inserted) return;
  }
  mesh.flip_to_delaunay();
}

}  // namespace

bool fill_loops(const Points& positions, const Points& normals, const NetworkCycle& cycle, double edge,
                PatchMesh& mesh, std::string& problem) {
  const Polygon polygon = joined_loops(positions, normals, cycle, edge);
  Intrinsic intrinsic;
  intrinsic.n_vertices = static_cast<int>(polygon.points.size());
  for (const std::array<int, 3>& t : coarse_triangles(polygon)) {
    std::array<int, 3> corners{};
    for (int k = 0; k < 3; ++k) corners[k] = polygon.corner[t[k]];
    std::array<double, 3> lengths{};
    for (int k = 0; k < 3; ++k)
      lengths[k] = (polygon.points[corners[(k + 1) % 3]] - polygon.points[corners[(k + 2) % 3]]).norm();
    intrinsic.triangles.push_back(corners);
    intrinsic.lengths.push_back(lengths);
  }
  if (intrinsic.triangles.empty()) {
    problem = "no triangulation of its outline was found";
    return false;
  }
  try {
    refine(intrinsic, edge);
  } catch (const InvalidInput&) {
    problem = "its outline passes some place more than twice";
    return false;
  }
  mesh.network_vertices = polygon.network_vertices;
  mesh.n_inner = intrinsic.n_vertices - polygon.n_network;
  const auto m = static_cast<Eigen::Index>(intrinsic.triangles.size());
  mesh.triangles.resize(m, 3);
  mesh.lengths.resize(m, 3);
  for (Eigen::Index f = 0; f < m; ++f)
    for (int k = 0; k < 3; ++k) {
      mesh.triangles(f, k) = intrinsic.triangles[static_cast<std::size_t>(f)][k];
      mesh.lengths(f, k) = intrinsic.lengths[static_cast<std::size_t>(f)][k];
    }
  return true;
}

}  // namespace batten::detail
