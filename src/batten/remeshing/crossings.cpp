#include "batten/remeshing/crossings.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/dynamic_box_tree.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostPairs = 10000;
constexpr int kMostCuts = 6;

/// A surface that is asked for its nearest point that faces a given way: near a thin wall that is one of the
/// right side.
class FacingSurface {
 public:
  FacingSurface(const Points& X, const Triangles& T) : X_(X), T_(T) {
    std::vector<std::pair<int, Box>> boxes;
    boxes.reserve(static_cast<std::size_t>(T.rows()));
    for (int f = 0; f < static_cast<int>(T.rows()); ++f) {
      const Vector3d a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
      boxes.push_back({f, {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}});
    }
    tree_.assign(boxes);
  }

  /// The point nearest to p of the triangles whose normal has a positive product with `normal`; p without
  /// any.
  Vector3d nearest(const Vector3d& p, const Vector3d& normal) const {
    double least = std::numeric_limits<double>::infinity();
    Vector3d best = p;
    tree_.visit_nearest(
        [&](const Box& box) { return ((box.low - p).cwiseMax(p - box.high).cwiseMax(0.0)).squaredNorm(); },
        [&](int f) {
          const Vector3d a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
          if ((b - a).cross(c - a).dot(normal) > 0) {
            const ClosestPoint at = closest_point_on_triangle(p, a, b, c);
            if (at.squared_distance < least) {
              least = at.squared_distance;
              best = at.point;
            }
          }
          return least;
        });
    return best;
  }

 private:
  Vector3d corner(int f, int k) const { return X_.row(T_(f, k)); }

  const Points& X_;
  const Triangles& T_;
  DynamicBoxTree tree_;
};

/// The faces that cross others, and how many pairs there are.
struct Crossings {
  std::vector<int> faces;
  std::size_t pairs = 0;
};

/// Looks for crossings near the places where there were some at first: nothing else moves.
class Search {
 public:
  Crossings everywhere(const HalfedgeMesh& mesh, const Progress& progress) {
    std::vector<int> faces;
    for (int f = 0; f < mesh.face_capacity(); ++f)
      if (mesh.has_face(f)) faces.push_back(f);
    const Crossings found = among(mesh, faces, progress);
    for (const int f : found.faces) {
      Box box = box_of(mesh, f);
      const double reach = (box.high - box.low).norm();
      box.low.array() -= reach;
      box.high.array() += reach;
      places_.push_back(box);
    }
    return found;
  }
  Crossings again(const HalfedgeMesh& mesh) const {
    const BoxTree tree(places_);
    std::vector<int> faces;
    for (int f = 0; f < mesh.face_capacity(); ++f) {
      if (!mesh.has_face(f)) continue;
      tree.query(box_of(mesh, f), [&](int) {
        faces.push_back(f);
        return false;
      });
    }
    return among(mesh, faces, {});
  }

 private:
  static Box box_of(const HalfedgeMesh& mesh, int f) {
    const Vector3d &a = mesh.position(mesh.from(3 * f)), &b = mesh.position(mesh.from(3 * f + 1)),
                   &c = mesh.position(mesh.from(3 * f + 2));
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }
  static Crossings among(const HalfedgeMesh& mesh, const std::vector<int>& faces, const Progress& progress) {
    Points positions(3 * static_cast<Eigen::Index>(faces.size()), 3);
    Triangles triangles(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const auto corner = 3 * static_cast<int>(i) + k;  // equal places count as one vertex
        positions.row(corner) = mesh.position(mesh.from(3 * faces[i] + k));
        triangles(static_cast<Eigen::Index>(i), k) = corner;
      }
    const auto pairs = self_intersections(positions, triangles, kMostPairs, progress);
    Crossings result;
    result.pairs = pairs.size();
    for (const auto& [f, g] : pairs) {
      result.faces.push_back(faces[f]);
      result.faces.push_back(faces[g]);
    }
    std::sort(result.faces.begin(), result.faces.end());
    result.faces.erase(std::unique(result.faces.begin(), result.faces.end()), result.faces.end());
    return result;
  }

  std::vector<Box> places_;
};

/// Free vertices of the faces and, `rings` times, their neighbours; increasing.
std::vector<int> free_vertices(const RemeshState& state, const std::vector<int>& faces, int rings) {
  std::vector<int> vertices;
  for (const int f : faces)
    for (int k = 0; k < 3; ++k) vertices.push_back(state.mesh.from(3 * f + k));
  for (int ring = 0; ring < rings; ++ring) {
    const std::size_t n = vertices.size();
    for (std::size_t i = 0; i < n; ++i)
      state.mesh.for_each_neighbour(vertices[i], [&](int u) { vertices.push_back(u); });
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  vertices.erase(std::remove_if(vertices.begin(), vertices.end(), [&](int v) { return !state.is_free(v); }),
                 vertices.end());
  return vertices;
}

/// Sum of the area normals around v.
Vector3d normal_at(const HalfedgeMesh& mesh, int v) {
  Vector3d sum = Vector3d::Zero();
  mesh.for_each_outgoing(v, [&](int h) { sum += mesh.area_normal(HalfedgeMesh::face(h)); });
  return sum;
}

void put_on_surface(RemeshState& state, const FacingSurface& surface, const std::vector<int>& vertices) {
  for (const int v : vertices)
    state.mesh.set_position(v, surface.nearest(state.mesh.position(v), normal_at(state.mesh, v)));
}

void even_out(RemeshState& state, const FacingSurface& surface, const std::vector<int>& vertices) {
  for (int step = 0; step < 3; ++step)
    for (const int v : vertices) {
      Vector3d sum = Vector3d::Zero();
      int n = 0;
      state.mesh.for_each_neighbour(v, [&](int u) {
        sum += state.mesh.position(u);
        ++n;
      });
      state.mesh.set_position(v, surface.nearest(sum / n, normal_at(state.mesh, v)));
    }
}

}  // namespace

std::size_t mend_crossings(RemeshState& state, const Points& reference_positions,
                           const Triangles& reference_triangles, std::size_t allowed,
                           const Progress& progress) {
  progress.report("crossings", 0);
  Search search;
  Crossings found = search.everywhere(state.mesh, progress.part("crossings", 0, 0.9));
  if (found.pairs <= allowed) return found.pairs;
  const FacingSurface surface(reference_positions, reference_triangles);
  RemeshState best = state;
  std::size_t fewest = found.pairs;
  for (int cuts = 0; fewest > allowed; ++cuts) {
    // Moves, as long as one of them helps.
    for (int kind = 0; kind < 4 && found.pairs > allowed;) {
      RemeshState before = state;
      const std::vector<int> vertices = free_vertices(state, found.faces, kind / 2);
      if (kind % 2 == 0)
        put_on_surface(state, surface, vertices);
      else
        even_out(state, surface, vertices);
      progress.report("crossings", 0.9);
      const Crossings now = search.again(state.mesh);
      if (now.pairs < found.pairs) {
        found = now;
        kind = 0;
      } else {
        state = std::move(before);
        ++kind;
      }
    }
    if (found.pairs < fewest) {
      fewest = found.pairs;
      best = state;
    }
    if (fewest <= allowed || cuts == kMostCuts) break;
    std::vector<int> added = state.split_longest_edges(found.faces);
    added.erase(std::remove_if(added.begin(), added.end(), [&](int v) { return !state.is_free(v); }),
                added.end());
    put_on_surface(state, surface, added);
    found = search.again(state.mesh);
    if (found.pairs < fewest) {
      fewest = found.pairs;
      best = state;
    }
  }
  state = std::move(best);
  return fewest;
}

}  // namespace batten
