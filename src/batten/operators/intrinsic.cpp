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

/// Flips edges of a triangulation in the metric of its lengths. A half-edge 3f + k is the edge opposite
/// corner k of triangle f.
class EdgeFlipper {
 public:
  /// @param fixed as in intrinsic_delaunay().
  EdgeFlipper(const Triangles& triangles, const EdgeLengths& lengths, const std::vector<char>& fixed)
      : result_{triangles, lengths, 0},
        twin_(opposite_half_edges(triangles)),
        frozen_(fixed),
        queued_(twin_.size(), 0) {
    frozen_.resize(twin_.size(), 0);
  }

  IntrinsicTriangulation make_delaunay() {
    for (int h = 0; h < static_cast<int>(twin_.size()); ++h)
      if (h < twin_[h]) queue(h);
    std::reverse(stack_.begin(), stack_.end());
    // Each flip lowers the Dirichlet energy of every function, so the loop ends; the bound guards rounding.
    const long most = 50L * static_cast<long>(twin_.size()) + 1000;
    while (!stack_.empty() && result_.flips < most) {
      const int h = stack_.back();
      stack_.pop_back();
      queued_[h] = 0;
      const int g = twin_[h];
      if (g < 0 || frozen_[h] || frozen_[g]) continue;
      const double diagonal = flipped_length(h, g);
      // A double edge would make the triangulation a multigraph, whose triangles cannot name their edges.
      if (diagonal >= 0 && !are_joined(h, apex(g))) flip(h, g, diagonal);
    }
    return std::move(result_);
  }

 private:
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int apex(int h) const { return result_.triangles(h / 3, h % 3); }
  double length(int h) const { return result_.lengths(h / 3, h % 3); }

  void queue(int h) {
    if (queued_[h]) return;
    queued_[h] = 1;
    stack_.push_back(h);
  }

  /// The length of the edge that replaces the half-edges h and g, which are one edge; −1 where it stays: it
  /// is Delaunay, or the triangles make no convex quadrilateral of four vertices.
  double flipped_length(int h, int g) const {
    // h is opposite apex p in triangle (p, a, b); g opposite q in (q, b, a).
    const double e = length(h), pb = length(next(h)), pa = length(previous(h));
    const double qa = length(next(g)), qb = length(previous(g));
    // next(h) is the edge opposite a, which joins b and p; previous(h) joins p and a.
    if (cotangent(e, pa, pb) + cotangent(e, qa, qb) > -1e-9 || apex(h) == apex(g)) return -1;
    // The new diagonal by laying both triangles out in the plane with a at the origin and b on the x axis.
    const double px = (pa * pa + e * e - pb * pb) / (2 * e), py = 2 * triangle_area(e, pa, pb) / e;
    const double qx = (qa * qa + e * e - qb * qb) / (2 * e), qy = -2 * triangle_area(e, qa, qb) / e;
    // Both new triangles (p, a, q) and (q, b, p) must have area on their proper side.
    const double side_a = px * qy - py * qx, side_b = (qx - e) * py - qy * (px - e);
    return side_a < 0 && side_b < 0 ? std::hypot(px - qx, py - qy) : -1;
  }

  /// Whether an edge joins the apex of h to vertex q. Turns around the apex both ways, away from its
  /// triangle.
  bool are_joined(int h, int q) const {
    const int p = apex(h);
    for (const int start : {previous(h), next(h)}) {
      int edge = start;
      while (twin_[edge] >= 0) {
        const int across = twin_[edge];
        if (across / 3 == h / 3) break;
        if (apex(across) == q) return true;
        int corner = 0;
        while (result_.triangles(across / 3, corner) != p) ++corner;
        edge = across - across % 3 + (3 - corner - across % 3);
        if (edge / 3 == h / 3) break;
      }
    }
    return false;
  }

  void flip(int h, int g, double diagonal) {
    const int p = apex(h), q = apex(g), a = apex(next(h)), b = apex(previous(h));
    const double pb = length(next(h)), pa = length(previous(h));
    const double qa = length(next(g)), qb = length(previous(g));
    const int pa_twin = twin_[previous(h)], pb_twin = twin_[next(h)];
    const int qa_twin = twin_[next(g)], qb_twin = twin_[previous(g)];
    const char pa_fixed = frozen_[previous(h)], pb_fixed = frozen_[next(h)];
    const char qa_fixed = frozen_[next(g)], qb_fixed = frozen_[previous(g)];
    const int f0 = h / 3, f1 = g / 3;
    // f0 becomes (p, a, q), f1 becomes (q, b, p).
    result_.triangles.row(f0) << p, a, q;
    result_.triangles.row(f1) << q, b, p;
    result_.lengths.row(f0) << qa, diagonal, pa;
    result_.lengths.row(f1) << pb, diagonal, qb;
    link(3 * f0 + 0, qa_twin, qa_fixed);
    link(3 * f0 + 2, pa_twin, pa_fixed);
    link(3 * f1 + 0, pb_twin, pb_fixed);
    link(3 * f1 + 2, qb_twin, qb_fixed);
    twin_[3 * f0 + 1] = 3 * f1 + 1;
    twin_[3 * f1 + 1] = 3 * f0 + 1;
    frozen_[3 * f0 + 1] = frozen_[3 * f1 + 1] = 0;
    ++result_.flips;
  }

  /// Makes a half-edge that has moved and the one on its other side know each other, and looks at both again.
  void link(int half_edge, int other, char is_fixed) {
    twin_[half_edge] = other;
    frozen_[half_edge] = is_fixed;
    if (other < 0) return;
    twin_[other] = half_edge;
    queue(std::min(half_edge, other));
  }

  IntrinsicTriangulation result_;
  std::vector<int> twin_;     // per half-edge that on its other side, or −1
  std::vector<char> frozen_;  // per half-edge: not to be flipped
  std::vector<int> stack_;    // half-edges to look at
  std::vector<char> queued_;  // per half-edge: is on the stack
};

}  // namespace

IntrinsicTriangulation intrinsic_delaunay(const Triangles& triangles, const EdgeLengths& lengths,
                                          const std::vector<char>& fixed) {
  return EdgeFlipper(triangles, lengths, fixed).make_delaunay();
}

}  // namespace batten
