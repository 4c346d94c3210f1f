#include "batten/mesh/quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/units.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

namespace {

using Row = Eigen::RowVector3d;

constexpr double kSliverAngle = radians(20.0);

struct Corner {
  Row a, b, c;
};

Corner corners(const Points& positions, const Triangles& triangles, Eigen::Index f) {
  return {positions.row(triangles(f, 0)), positions.row(triangles(f, 1)), positions.row(triangles(f, 2))};
}

}  // namespace

MeshQuality mesh_quality(const Points& positions, const Triangles& triangles) {
  MeshQuality quality;
  if (triangles.rows() == 0) return quality;
  quality.min_angle = quality.min_edge = std::numeric_limits<double>::infinity();
  double sum_edges = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const auto [a, b, c] = corners(positions, triangles, f);
    const Row sides[3] = {b - a, c - b, a - c};
    const double lengths[3] = {sides[0].norm(), sides[1].norm(), sides[2].norm()};
    double smallest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Row &u = sides[k], v = -sides[(k + 2) % 3];
      const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
      smallest = std::min(smallest, angle);
      quality.max_angle = std::max(quality.max_angle, angle);
      quality.min_edge = std::min(quality.min_edge, lengths[k]);
      quality.max_edge = std::max(quality.max_edge, lengths[k]);
      sum_edges += lengths[k];
    }
    quality.min_angle = std::min(quality.min_angle, smallest);
    quality.mean_min_angle += smallest;
    if (smallest < kSliverAngle) quality.slivers += 1;
    // R/(2r) = a b c (a + b + c) / (16 A²), A from the cross product of two sides.
    const double twice_area = sides[0].cross(sides[1]).norm();
    const double aspect = twice_area > 0 ? (lengths[0] / twice_area) * (lengths[1] / twice_area) *
                                               lengths[2] * (lengths[0] + lengths[1] + lengths[2]) / 4
                                         : std::numeric_limits<double>::infinity();
    quality.mean_aspect += aspect;
    if (quality.worst_triangle < 0 || aspect > quality.max_aspect) {
      quality.max_aspect = aspect;
      quality.worst_triangle = static_cast<int>(f);
    }
  }
  const auto n = static_cast<double>(triangles.rows());
  quality.mean_min_angle /= n;
  quality.slivers /= n;
  quality.mean_aspect /= n;
  quality.mean_edge = sum_edges / (3 * n);
  return quality;
}

double regular_share(const Triangles& triangles, Eigen::Index n_vertices) {
  const MeshEdges edges = mesh_edges(triangles, n_vertices);
  std::vector<int> valence(n_vertices, 0);
  std::vector<char> inside(n_vertices, 1);
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    for (int k = 0; k < 2; ++k) {
      const int v = edges.vertices(e, k);
      ++valence[v];
      if (edges.n_triangles(e) != 2) inside[v] = 0;
    }
  double regular = 0, all = 0;
  for (Eigen::Index v = 0; v < n_vertices; ++v) {
    if (valence[v] == 0 || inside[v] == 0) continue;
    all += 1;
    regular += valence[v] == 6 ? 1 : 0;
  }
  return all > 0 ? regular / all : 0;
}

std::vector<int> degenerate_triangles(const Points& positions, const Triangles& triangles, double tolerance) {
  std::vector<int> found;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const auto [a, b, c] = corners(positions, triangles, f);
    const Row u = b - a, v = c - a, w = c - b;
    const double longest = std::sqrt(std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm()}));
    // height · longest = twice the area; a side of length zero also makes the area zero
    if (!(longest > 0) || u.cross(v).norm() <= tolerance * longest * longest)
      found.push_back(static_cast<int>(f));
  }
  return found;
}

std::vector<int> folded_triangles(const Points& positions, const Triangles& triangles,
                                  const Points& vertex_normals) {
  std::vector<int> found;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const auto [a, b, c] = corners(positions, triangles, f);
    const Row normal = (b - a).cross(c - a);
    const Row given = vertex_normals.row(triangles(f, 0)) + vertex_normals.row(triangles(f, 1)) +
                      vertex_normals.row(triangles(f, 2));
    if (normal.squaredNorm() > 0 && normal.dot(given) <= 0) found.push_back(static_cast<int>(f));
  }
  return found;
}

std::vector<std::pair<int, int>> folded_edges(const Points& positions, const Triangles& triangles,
                                              double max_angle) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  const Points normals = face_normals(positions, triangles);
  std::vector<std::pair<int, int>> found;
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    if (edges.n_triangles(e) != 2) continue;
    const int begin = edges.offsets[static_cast<size_t>(e)];
    const int s = edges.sides[static_cast<size_t>(begin)], t = edges.sides[static_cast<size_t>(begin) + 1];
    const Row n = normals.row(s / 3), m = normals.row(t / 3);
    if (n.squaredNorm() == 0 || m.squaredNorm() == 0) continue;
    // Both sides run along the edge in opposite senses where the orientation is consistent.
    const double sense = triangles(s / 3, s % 3) == triangles(t / 3, t % 3) ? -1 : 1;
    if (std::atan2(n.cross(m).norm(), sense * n.dot(m)) > max_angle)
      found.emplace_back(std::min(s / 3, t / 3), std::max(s / 3, t / 3));
  }
  return found;
}

}  // namespace batten
