#include "batten/operators/intrinsic.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

EdgeLengths edge_lengths(const Points& positions, const Triangles& triangles) {
  EdgeLengths lengths(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      lengths(f, k) =
          (positions.row(triangles(f, (k + 1) % 3)) - positions.row(triangles(f, (k + 2) % 3))).norm();
  return lengths;
}

double triangle_area(double a, double b, double c) {
  if (a < b) std::swap(a, b);
  if (a < c) std::swap(a, c);
  if (b < c) std::swap(b, c);
  const double product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
  return product > 0 ? 0.25 * std::sqrt(product) : 0.0;
}

std::vector<int> opposite_half_edges(const Triangles& triangles) {
  // Half-edges bucketed by their smaller vertex: linear, and no hashing.
  const Eigen::Index m = triangles.rows();
  const int n = m == 0 ? 0 : triangles.maxCoeff() + 1;
  std::vector<int> first(static_cast<std::size_t>(n) + 1, 0);
  const auto ends = [&](int h) {
    const int f = h / 3, k = h % 3;
    return std::pair<int, int>(triangles(f, (k + 1) % 3), triangles(f, (k + 2) % 3));
  };
  const auto n_half_edges = static_cast<int>(3 * m);
  for (int h = 0; h < n_half_edges; ++h) {
    const auto [a, b] = ends(h);
    ++first[std::min(a, b) + 1];
  }
  for (int v = 0; v < n; ++v) first[v + 1] += first[v];
  std::vector<int> bucket(n_half_edges), fill(first.begin(), first.end() - 1);
  for (int h = 0; h < n_half_edges; ++h) {
    const auto [a, b] = ends(h);
    bucket[fill[std::min(a, b)]++] = h;
  }
  std::vector<int> opposite(n_half_edges, -1);
  for (int v = 0; v < n; ++v)
    for (int i = first[v]; i < first[v + 1]; ++i)
      for (int j = i + 1; j < first[v + 1]; ++j) {
        const auto [a, b] = ends(bucket[i]);
        const auto [c, d] = ends(bucket[j]);
        if (std::max(a, b) != std::max(c, d)) continue;
        if (a == c || opposite[bucket[i]] >= 0 || opposite[bucket[j]] >= 0)
          throw InvalidInput(concat("the triangles ", bucket[i] / 3, " and ", bucket[j] / 3,
                                    " share the edge ", a, "-", b,
                                    " with a third one or in the same direction; batten repair IN -o OUT "
                                    "separates and orients them"));
        opposite[bucket[i]] = bucket[j];
        opposite[bucket[j]] = bucket[i];
      }
  return opposite;
}

namespace {

/// Cotangent of the angle opposite side a.
double cotangent(double a, double b, double c) {
  const double area = triangle_area(a, b, c);
  return area > 0 ? (b * b + c * c - a * a) / (4 * area) : 0;
}

}  // namespace

IntrinsicTriangulation intrinsic_delaunay(const Triangles& triangles, const EdgeLengths& lengths,
                                          const std::vector<char>& fixed) {
  IntrinsicTriangulation result{triangles, lengths, 0};
  Triangles& T = result.triangles;
  EdgeLengths& l = result.lengths;
  std::vector<int> twin = opposite_half_edges(T);
  std::vector<char> frozen = fixed;
  frozen.resize(twin.size(), 0);
  std::vector<int> stack;
  std::vector<char> queued(twin.size(), 0);
  for (int h = 0; h < static_cast<int>(twin.size()); ++h)
    if (h < twin[h]) {
      stack.push_back(h);
      queued[h] = 1;
    }
  const auto next = [](int h) { return h % 3 == 2 ? h - 2 : h + 1; };
  const auto previous = [](int h) { return h % 3 == 0 ? h + 2 : h - 1; };
  const auto apex = [&](int h) { return T(h / 3, h % 3); };
  const auto length = [&](int h) { return l(h / 3, h % 3); };
  std::reverse(stack.begin(), stack.end());
  // Each flip lowers the Dirichlet energy of every function, so the loop ends; the bound guards rounding.
  const long most = 50L * static_cast<long>(twin.size()) + 1000;
  while (!stack.empty() && result.flips < most) {
    int h = stack.back();
    stack.pop_back();
    queued[h] = 0;
    const int g = twin[h];
    if (g < 0 || frozen[h] || frozen[g]) continue;
    // h is opposite apex p in triangle (p, a, b); g opposite q in (q, b, a).
    const double e = length(h), pb = length(next(h)), pa = length(previous(h));
    const double qa = length(next(g)), qb = length(previous(g));
    // next(h) is the edge opposite a, which joins b and p; previous(h) joins p and a.
    if (cotangent(e, pa, pb) + cotangent(e, qa, qb) > -1e-9) continue;
    const int p = apex(h), q = apex(g), a = T(h / 3, (h % 3 + 1) % 3), b = T(h / 3, (h % 3 + 2) % 3);
    if (p == q) continue;
    // The new diagonal by laying both triangles out in the plane with a at the origin and b on the x axis.
    const double px = (pa * pa + e * e - pb * pb) / (2 * e), py = 2 * triangle_area(e, pa, pb) / e;
    const double qx = (qa * qa + e * e - qb * qb) / (2 * e), qy = -2 * triangle_area(e, qa, qb) / e;
    const double diagonal = std::hypot(px - qx, py - qy);
    // Both new triangles (p, a, q) and (q, b, p) must have area on their proper side.
    const double side_a = px * qy - py * qx, side_b = (qx - e) * py - qy * (px - e);
    if (!(side_a < 0) || !(side_b < 0)) continue;
    const int pa_twin = twin[previous(h)], pb_twin = twin[next(h)];
    const int qa_twin = twin[next(g)], qb_twin = twin[previous(g)];
    const char pa_fixed = frozen[previous(h)], pb_fixed = frozen[next(h)];
    const char qa_fixed = frozen[next(g)], qb_fixed = frozen[previous(g)];
    // A double edge p-q would make the triangulation a multigraph, whose triangles cannot name their edges.
    bool joined = false;
    for (const int start : {previous(h), next(h)}) {
      int edge = start;  // turns around p, away from triangle h
      while (!joined && twin[edge] >= 0) {
        const int across = twin[edge];
        if (across / 3 == h / 3) break;
        joined = apex(across) == q;
        int corner = 0;
        while (T(across / 3, corner) != p) ++corner;
        edge = across - across % 3 + (3 - corner - across % 3);
        if (edge / 3 == h / 3) break;
      }
    }
    if (joined) continue;
    const int f0 = h / 3, f1 = g / 3;
    // f0 becomes (p, a, q), f1 becomes (q, b, p).
    T.row(f0) << p, a, q;
    T.row(f1) << q, b, p;
    l.row(f0) << qa, diagonal, pa;
    l.row(f1) << pb, diagonal, qb;
    const auto link = [&](int half_edge, int other, char is_fixed) {
      twin[half_edge] = other;
      frozen[half_edge] = is_fixed;
      if (other >= 0) twin[other] = half_edge;
      if (other >= 0) {
        const int representative = std::min(half_edge, other);
        if (!queued[representative]) {
          queued[representative] = 1;
          stack.push_back(representative);
        }
      }
    };
    link(3 * f0 + 0, qa_twin, qa_fixed);
    link(3 * f0 + 2, pa_twin, pa_fixed);
    link(3 * f1 + 0, pb_twin, pb_fixed);
    link(3 * f1 + 2, qb_twin, qb_fixed);
    twin[3 * f0 + 1] = 3 * f1 + 1;
    twin[3 * f1 + 1] = 3 * f0 + 1;
    frozen[3 * f0 + 1] = frozen[3 * f1 + 1] = 0;
    ++result.flips;
  }
  return result;
}

}  // namespace batten
