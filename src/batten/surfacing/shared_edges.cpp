#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "batten/surfacing/patch_detail.hpp"

namespace batten::detail {

namespace {

/// Puts a vertex into the middle of the edge opposite corner k of triangle f, and of the triangle beyond it.
void split_edge(PatchMesh& mesh, Eigen::Index f, int k) {
  const int a = mesh.triangles(f, (k + 1) % 3), b = mesh.triangles(f, (k + 2) % 3);
  const int middle = static_cast<int>(mesh.network_vertices.size()) + mesh.n_inner++;
  const Eigen::Index count = mesh.triangles.rows();
  std::vector<std::array<Eigen::Index, 2>> sides;  // triangle, corner opposite the edge
  for (Eigen::Index g = 0; g < count; ++g)
    for (int c = 0; c < 3; ++c) {
      const int p = mesh.triangles(g, (c + 1) % 3), q = mesh.triangles(g, (c + 2) % 3);
      if ((p == a && q == b) || (p == b && q == a)) sides.push_back({g, c});
    }
  const auto more = static_cast<Eigen::Index>(sides.size());
  mesh.triangles.conservativeResize(count + more, 3);
  mesh.lengths.conservativeResize(count + more, 3);
  for (Eigen::Index s = 0; s < more; ++s) {
    const auto [g, corner] = sides[static_cast<std::size_t>(s)];
    const Eigen::Index i = (corner + 1) % 3, j = (corner + 2) % 3;
    const Eigen::RowVector3i whole = mesh.triangles.row(g);
    const Eigen::RowVector3d l = mesh.lengths.row(g);
    const double half = 0.5 * l(corner);
    const double median =
        0.5 * std::sqrt(std::max(0.0, 2 * l(i) * l(i) + 2 * l(j) * l(j) - l(corner) * l(corner)));
    // (corner, i, middle) stays in its row, (corner, middle, j) is new; side j joins corner and i.
    mesh.triangles.row(g) << whole(corner), whole(i), middle;
    mesh.lengths.row(g) << half, median, l(j);
    mesh.triangles.row(count + s) << whole(corner), middle, whole(j);
    mesh.lengths.row(count + s) << half, l(i), median;
  }
}

}  // namespace

void split_shared_inner_edges(std::vector<PatchMesh>& patches, const std::vector<NetworkCycle>& cycles,
                              const std::vector<int>& place) {
  const auto ordered = [&](int a, int b) {
    if (!place.empty()) {
      a = place[static_cast<std::size_t>(a)];
      b = place[static_cast<std::size_t>(b)];
    }
    return std::pair(std::min(a, b), std::max(a, b));
  };
  std::set<std::pair<int, int>> taken;  // network edges, and inner edges of the patches before
  for (const NetworkCycle& cycle : cycles)
    for (const NetworkCycle::Loop& loop : cycle.loops)
      for (std::size_t i = 0; i < loop.vertices.size(); ++i)
        taken.insert(ordered(loop.vertices[i], loop.vertices[(i + 1) % loop.vertices.size()]));
  for (std::size_t p = 0; p < patches.size(); ++p) {
    PatchMesh& mesh = patches[p];
    const auto n_network = static_cast<int>(mesh.network_vertices.size());
    std::set<std::pair<int, int>> inner;  // by network vertices
    std::set<std::pair<int, int>> seen;
    for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles(f, (k + 1) % 3), b = mesh.triangles(f, (k + 2) % 3);
        if (a >= n_network || b >= n_network) continue;
        const auto edge = ordered(mesh.network_vertices[static_cast<std::size_t>(a)],
                                  mesh.network_vertices[static_cast<std::size_t>(b)]);
        if (!seen.insert(edge).second) inner.insert(edge);  // two triangles: not on the border of the patch
      }
    for (const std::pair<int, int>& edge : inner) {
      if (taken.insert(edge).second) continue;
      // Splitting moves corners about: look the edge up again.
      for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
        for (int k = 0; k < 3; ++k) {
          const int a = mesh.triangles(f, (k + 1) % 3), b = mesh.triangles(f, (k + 2) % 3);
          if (a < n_network && b < n_network &&
              ordered(mesh.network_vertices[static_cast<std::size_t>(a)],
                      mesh.network_vertices[static_cast<std::size_t>(b)]) == edge) {
            split_edge(mesh, f, k);
            f = mesh.triangles.rows();
            break;
          }
        }
    }
  }
}

JoinedPatches join_patches(const std::vector<PatchMesh>& patches, Eigen::Index n_network) {
  JoinedPatches joined;
  joined.n_vertices = n_network;
  Eigen::Index m = 0;
  for (const PatchMesh& patch : patches) {
    joined.n_vertices += patch.n_inner;
    m += patch.triangles.rows();
  }
  joined.triangles.resize(m, 3);
  joined.lengths.resize(m, 3);
  Eigen::Index row = 0;
  auto next = static_cast<int>(n_network);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const PatchMesh& patch = patches[p];
    const auto n_outline = static_cast<int>(patch.network_vertices.size());
    for (Eigen::Index f = 0; f < patch.triangles.rows(); ++f, ++row) {
      for (int k = 0; k < 3; ++k) {
        const int v = patch.triangles(f, k);
        joined.triangles(row, k) =
            v < n_outline ? patch.network_vertices[static_cast<std::size_t>(v)] : next + v - n_outline;
      }
      joined.lengths.row(row) = patch.lengths.row(f);
      joined.patch_of_triangle.push_back(static_cast<int>(p));
    }
    next += patch.n_inner;
  }
  return joined;
}

}  // namespace batten::detail
