#include "batten/mesh/self_intersections.hpp"

#include <algorithm>
#include <array>

#include "batten/core/parallel.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/mesh/welding.hpp"

namespace batten {

namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

bool triangles_meet(const Corners& s, const Corners& t) {
  const auto apart = [](const Corners& plane, const Corners& other) {
    const int a = orient3d(plane[0], plane[1], plane[2], other[0]);
    return a != 0 && a == orient3d(plane[0], plane[1], plane[2], other[1]) &&
           a == orient3d(plane[0], plane[1], plane[2], other[2]);
  };
  if (apart(s, t) || apart(t, s)) return false;
  for (size_t k = 0; k < 3; ++k)
    if (segment_meets_triangle(s[k], s[(k + 1) % 3], t[0], t[1], t[2]) ||
        segment_meets_triangle(t[k], t[(k + 1) % 3], s[0], s[1], s[2]))
      return true;
  return false;
}

/// Triangles v w a and v w b lie in one plane on the same side of v w.
bool folded_back(const Eigen::Vector3d& v, const Eigen::Vector3d& w, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b) {
  if (orient3d(v, w, a, b) != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const auto flat = [axis](const Eigen::Vector3d& p) {
      return Eigen::Vector2d(p((axis + 1) % 3), p((axis + 2) % 3));
    };
    const int side = orient2d(flat(v), flat(w), flat(a));
    if (side != 0) return side == orient2d(flat(v), flat(w), flat(b));
  }
  return false;
}

}  // namespace

std::vector<std::pair<int, int>> self_intersections(const Points& positions, const Triangles& triangles,
                                                    size_t most, const Progress& progress) {
  const std::vector<int> place = places_of_vertices(positions);
  const auto corners_of = [&](int f) {
    return Corners{positions.row(triangles(f, 0)), positions.row(triangles(f, 1)),
                   positions.row(triangles(f, 2))};
  };
  const auto n = static_cast<size_t>(triangles.rows());
  std::vector<Box> boxes(n);
  std::vector<char> has_area(n);
  for (size_t f = 0; f < n; ++f) {
    const Corners c = corners_of(static_cast<int>(f));
    boxes[f] = {c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])};
    has_area[f] = !are_collinear(c[0], c[1], c[2]);
  }
  progress.report("self-intersections", 0);
  const BoxTree tree(boxes);
  const auto meet = [&](int f, int g) {
    // Corners of f, then of g, that both have in common come first.
    std::array<int, 3> i{0, 1, 2}, j{0, 1, 2};
    size_t shared = 0;
    for (size_t a = 0; a < 3; ++a)
      for (size_t b = shared; b < 3; ++b)
        if (a >= shared && place[static_cast<size_t>(triangles(f, i[a]))] ==
                               place[static_cast<size_t>(triangles(g, j[b]))]) {
          std::swap(i[shared], i[a]);
          std::swap(j[shared], j[b]);
          ++shared;
          break;
        }
    const auto s = [&](size_t k) { return Eigen::Vector3d(positions.row(triangles(f, i[k]))); };
    const auto t = [&](size_t k) { return Eigen::Vector3d(positions.row(triangles(g, j[k]))); };
    switch (shared) {
      case 0:
        return triangles_meet(corners_of(f), corners_of(g));
      case 1:
        // Whatever they share beyond the vertex ends on the side opposite to it of one of both.
        return segment_meets_triangle(s(1), s(2), t(0), t(1), t(2)) ||
               segment_meets_triangle(t(1), t(2), s(0), s(1), s(2));
      case 2:
        return folded_back(s(0), s(1), s(2), t(2));
      default:
        return true;
    }
  };
  constexpr Eigen::Index kGrain = 2048;
  std::vector<std::vector<std::pair<int, int>>> found(n / kGrain + 1);
  const auto search = [&](Eigen::Index begin, Eigen::Index end) {
    auto& pairs = found[static_cast<size_t>(begin / kGrain)];
    for (auto f = static_cast<int>(begin); f < end && pairs.size() < most; ++f) {
      if (!has_area[static_cast<size_t>(f)]) continue;
      const size_t before = pairs.size();
      tree.query(boxes[static_cast<size_t>(f)], [&](int g) {
        if (g > f && has_area[static_cast<size_t>(g)] && meet(f, g)) pairs.emplace_back(f, g);
        return true;
      });
      std::sort(pairs.begin() + static_cast<std::ptrdiff_t>(before), pairs.end());
    }
  };
  parallel_for(static_cast<Eigen::Index>(n), kGrain, search, progress.part("self-intersections", 0.1, 1));
  std::vector<std::pair<int, int>> all;
  for (const auto& pairs : found) all.insert(all.end(), pairs.begin(), pairs.end());
  if (all.size() > most) all.resize(most);
  return all;
}

}  // namespace batten
