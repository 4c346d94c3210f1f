#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/modelling/patch_outlines_detail.hpp"
#include "batten/modelling/quad_layout_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector2d;

constexpr double kRing = 0.5;  ///< radius of the inner outline of a piece with a ring, in a disc of radius 1
constexpr std::size_t kSamplesPerQuad =
    40;                                ///< patches with fewer vertices are sampled in their triangles, too
constexpr double kLeastWeight = 1e-3;  ///< of an edge of the map: angles beyond 90° must not pull outwards

/// A quad in the plane into which a piece is laid out: four straight sides, or a ring's, between an arc of
/// the unit circle and a chord of the inner outline.
struct PlaneQuad {
  std::array<Vector2d, 4> corners;  ///< straight sides
  bool is_ring = false;
  double first = 0, last = 0;              ///< angles of its arc
  double outer_first = 0, outer_last = 0;  ///< angles of the whole arc of which it is a half, or its own

  /// Parameters of a point, outside [0, 1] where it lies outside.
  Vector2d parameters(const Vector2d& point) const { return is_ring ? in_ring(point) : in_straight(point); }

  static double smallest(const Vector2d& uv) { return std::min({uv.x(), 1 - uv.x(), uv.y(), 1 - uv.y()}); }

 private:
  Vector2d in_straight(const Vector2d& point) const {
    Vector2d uv(0.5, 0.5);
    for (int step = 0; step < 30; ++step) {
      const double u = uv.x(), v = uv.y();
      const Vector2d at = (1 - u) * (1 - v) * corners[0] + u * (1 - v) * corners[1] + u * v * corners[2] +
                          (1 - u) * v * corners[3];
      Eigen::Matrix2d J;
      J.col(0) = (1 - v) * (corners[1] - corners[0]) + v * (corners[2] - corners[3]);
      J.col(1) = (1 - u) * (corners[3] - corners[0]) + u * (corners[2] - corners[1]);
      if (std::abs(J.determinant()) < 1e-12) return {-1, -1};
      const Vector2d change = J.inverse() * (point - at);
      uv += change.norm() > 2 ? Vector2d(change * (2 / change.norm())) : change;
      if (change.norm() < 1e-12) return uv;
    }
    return {-1, -1};  // points that no parameters reach lie outside
  }

  Vector2d in_ring(const Vector2d& point) const {
    const double radius = point.norm(), middle = (outer_first + outer_last) / 2;
    double angle = std::atan2(point.y(), point.x());
    while (angle < middle - kPi) angle += 2 * kPi;
    while (angle > middle + kPi) angle -= 2 * kPi;
    const double half = (outer_last - outer_first) / 2;
    if (std::abs(angle - middle) > std::min(half + 0.5, 0.49 * kPi)) return {-1, -1};
    const double inner = kRing * std::cos(half) / std::cos(angle - middle);
    const double v = (1 - radius) / (1 - inner);
    const auto along_chord = [&](double a) { return std::tan(a - middle); };
    const double by_angle = (angle - first) / (last - first);
    const double by_chord =
        (along_chord(angle) - along_chord(first)) / (along_chord(last) - along_chord(first));
    return {(1 - v) * by_angle + v * by_chord, v};
  }
};

/// A quad of one piece. A side on the outline names its segment and which part: 0 and 1 its halves, 2 the
/// whole.
struct PieceQuad {
  std::array<int, 4> corners{};
  std::array<std::pair<int, int>, 4> outline{{{-1, 0}, {-1, 0}, {-1, 0}, {-1, 0}}};
  PlaneQuad plane;
};

Vector2d on_circle(double angle, double radius = 1) {
  return radius * Vector2d(std::cos(angle), std::sin(angle));
}

class QuadLayoutBuilder {
 public:
  QuadLayoutBuilder(const Points& X, const Triangles& T, PatchOutlines outlines)
      : X_(X), T_(T), outlines_(std::move(outlines)), is_split_(outlines_.segments.size(), 0) {}

  QuadLayout build(const Progress& progress) {
    spread_splits();
    for (std::size_t p = 0; p < outlines_.pieces.size(); ++p) {
      progress.report("layout", static_cast<double>(p) / static_cast<double>(outlines_.pieces.size()));
      add_piece(static_cast<int>(p));
    }
    layout_.n_corners = static_cast<int>(corner_of_.size());
    layout_.points.resize(X_.rows() + static_cast<Eigen::Index>(inner_points_.size()), 3);
    layout_.n_vertices = X_.rows();
    layout_.points.topRows(X_.rows()) = X_;
    for (std::size_t i = 0; i < inner_points_.size(); ++i)
      layout_.points.row(X_.rows() + static_cast<Eigen::Index>(i)) = inner_points_[i];
    return std::move(layout_);
  }

 private:
  /// A piece that is divided around its middle halves its sides, and four-sided ones pass that on across.
  void spread_splits() {
    for (const OutlinePiece& piece : outlines_.pieces)
      if (piece.sides.size() != 4)
        for (const OutlineSide& side : piece.sides) is_split_[at(side.segment)] = 1;
    for (bool changed = true; changed;) {
      changed = false;
      for (const OutlinePiece& piece : outlines_.pieces) {
        if (piece.sides.size() != 4) continue;
        for (int k = 0; k < 2; ++k) {
          char &a = is_split_[at(piece.sides[at(k)].segment)],
               &b = is_split_[at(piece.sides[at(k + 2)].segment)];
          changed = changed || a != b;
          a = b = std::max(a, b);
        }
      }
    }
  }

  int corner(int kind, int which, int place = 0) {
    return corner_of_.try_emplace({kind, which, place}, static_cast<int>(corner_of_.size())).first->second;
  }
  int node(int vertex) { return corner(0, vertex); }
  int middle_of(int segment) { return corner(1, segment); }
  int inner(int piece, int place) { return corner(2, piece, place); }

  struct Side {
    int segment, first, last;  ///< corners
    bool forward;
    std::pair<int, int> part(int half) const {
      return {segment, half == 2 ? 2 : (forward ? half : 1 - half)};
    }
  };

  void add_piece(int p) {
    const OutlinePiece& piece = outlines_.pieces[at(p)];
    const int n = static_cast<int>(piece.sides.size());
    const bool ring =
        std::any_of(piece.is_flat.begin(), piece.is_flat.end(), [](char flat) { return flat != 0; }) || n < 3;
    std::vector<Side> sides;
    for (const OutlineSide& side : piece.sides) {
      const std::vector<int>& vertices = outlines_.segments[at(side.segment)].vertices;
      const int from = side.forward ? vertices.front() : vertices.back(),
                to = side.forward ? vertices.back() : vertices.front();
      sides.push_back({side.segment, node(from), node(to), side.forward});
    }
    // Angles of the nodes in the disc, and the corners of the straight outline within.
    std::vector<double> angles(at(n) + 1);
    for (int k = 0; k <= n; ++k) angles[at(k)] = 2 * kPi * k / n - 0.75 * kPi;
    std::vector<Vector2d> places;
    std::vector<int> corners;
    for (int k = 0; k < n; ++k) {
      places.push_back(on_circle(angles[at(k)], ring ? kRing : 1));
      corners.push_back(ring ? inner(p, 1 + k) : sides[at(k)].first);
    }
    std::vector<PieceQuad> quads;
    if (ring) add_ring(p, sides, angles, quads);
    if (n == 4)
      add_grid(p, sides, places, corners, ring, quads);
    else
      add_star(p, sides, places, corners, ring, quads);

    std::vector<int> points;
    std::vector<Vector2d> plane = lay_out(piece, angles, ring, points);
    add_inner_points(piece, kSamplesPerQuad * quads.size(), points, plane);
    const int first = static_cast<int>(layout_.quads.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      int best = 0;
      double inside = -1e9;
      Vector2d uv(0, 0);
      for (std::size_t q = 0; q < quads.size(); ++q) {
        const Vector2d found = quads[q].plane.parameters(plane[i]);
        if (PlaneQuad::smallest(found) <= inside) continue;
        inside = PlaneQuad::smallest(found);
        best = static_cast<int>(q);
        uv = found;
      }
      layout_.samples.push_back(
          {points[i], first + best, std::clamp(uv.x(), 0.0, 1.0), std::clamp(uv.y(), 0.0, 1.0)});
    }
    for (const PieceQuad& quad : quads) add_quad(p, quad);
  }

  /// Quads between the outline and the inner one. u runs along the outline, v inwards.
  void add_ring(int p, const std::vector<Side>& sides, const std::vector<double>& angles,
                std::vector<PieceQuad>& quads) {
    const int n = static_cast<int>(sides.size());
    for (int k = 0; k < n; ++k) {
      const Side& side = sides[at(k)];
      const bool split = is_split_[at(side.segment)] != 0;
      const int outer[3] = {side.first, split ? middle_of(side.segment) : -1, side.last};
      const int within[3] = {inner(p, 1 + k), split ? inner_middle(p, k, n) : -1, inner(p, 1 + (k + 1) % n)};
      for (int half = 0; half < (split ? 2 : 1); ++half) {
        const int from = split ? half : 0, to = split ? half + 1 : 2;
        PieceQuad quad;
        quad.corners = {outer[from], outer[to], within[to], within[from]};
        quad.outline[0] = side.part(split ? half : 2);
        quad.plane.is_ring = true;
        quad.plane.outer_first = angles[at(k)];
        quad.plane.outer_last = angles[at(k + 1)];
        const double middle = (angles[at(k)] + angles[at(k + 1)]) / 2;
        quad.plane.first = split && half == 1 ? middle : angles[at(k)];
        quad.plane.last = split && half == 0 ? middle : angles[at(k + 1)];
        quads.push_back(quad);
      }
    }
  }

  int inner_middle(int p, int k, int n) { return inner(p, 1 + n + k); }

  /// Four-sided: one quad, or halves and quarters of it.
  void add_grid(int p, const std::vector<Side>& sides, const std::vector<Vector2d>& places,
                const std::vector<int>& corners, bool ring, std::vector<PieceQuad>& quads) {
    const int nu = is_split_[at(sides[0].segment)] ? 2 : 1, nv = is_split_[at(sides[1].segment)] ? 2 : 1;
    const auto middle = [&](int k) { return ring ? inner_middle(p, k, 4) : middle_of(sides[at(k)].segment); };
    // Corners of the grid by twice their place.
    const auto corner_at = [&](int i, int j) {
      if (i % 2 == 0 && j % 2 == 0) return corners[at(j == 0 ? i / 2 : 3 - i / 2)];
      if (i == 1 && j == 1) return inner(p, 0);
      return middle(j == 0 ? 0 : i == 2 ? 1 : j == 2 ? 2 : 3);
    };
    const auto place_at = [&](int i, int j) {
      const double u = i / 2.0, v = j / 2.0;
      return Vector2d((1 - u) * (1 - v) * places[0] + u * (1 - v) * places[1] + u * v * places[2] +
                      (1 - u) * v * places[3]);
    };
    for (int b = 0; b < nv; ++b)
      for (int a = 0; a < nu; ++a) {
        const int i0 = 2 * a / nu, i1 = 2 * (a + 1) / nu, j0 = 2 * b / nv, j1 = 2 * (b + 1) / nv;
        PieceQuad quad;
        quad.corners = {corner_at(i0, j0), corner_at(i1, j0), corner_at(i1, j1), corner_at(i0, j1)};
        quad.plane.corners = {place_at(i0, j0), place_at(i1, j0), place_at(i1, j1), place_at(i0, j1)};
        if (!ring) {
          if (j0 == 0) quad.outline[0] = sides[0].part(nu == 1 ? 2 : a);
          if (i1 == 2) quad.outline[1] = sides[1].part(nv == 1 ? 2 : b);
          if (j1 == 2) quad.outline[2] = sides[2].part(nu == 1 ? 2 : 1 - a);
          if (i0 == 0) quad.outline[3] = sides[3].part(nv == 1 ? 2 : 1 - b);
        }
        quads.push_back(quad);
      }
  }

  /// Divided around the middle: quad k has corner k, the halves of the sides there, and the middle.
  void add_star(int p, const std::vector<Side>& sides, const std::vector<Vector2d>& places,
                const std::vector<int>& corners, bool ring, std::vector<PieceQuad>& quads) {
    const int n = static_cast<int>(sides.size());
    const auto middle = [&](int k) { return ring ? inner_middle(p, k, n) : middle_of(sides[at(k)].segment); };
    const auto half_way = [&](int k) { return Vector2d((places[at(k)] + places[at((k + 1) % n)]) / 2); };
    for (int k = 0; k < n; ++k) {
      const int before = (k + n - 1) % n;
      PieceQuad quad;
      quad.corners = {corners[at(k)], middle(k), inner(p, 0), middle(before)};
      quad.plane.corners = {places[at(k)], half_way(k), Vector2d(0, 0), half_way(before)};
      if (!ring) {
        quad.outline[0] = sides[at(k)].part(0);
        quad.outline[3] = sides[at(before)].part(1);
      }
      quads.push_back(quad);
    }
  }

  /// The piece in the unit disc (with a ring) or the regular polygon, its outline by lengths, inside a
  /// harmonic map with positive weights [tutte1963]: one to one, because the outline is convex. @param
  /// vertices those of the piece.
  std::vector<Vector2d> lay_out(const OutlinePiece& piece, const std::vector<double>& angles, bool ring,
                                std::vector<int>& vertices) {
    std::map<int, int> number;
    for (const int f : piece.triangles)
      for (int k = 0; k < 3; ++k)
        if (number.try_emplace(T_(f, k), static_cast<int>(vertices.size())).second)
          vertices.push_back(T_(f, k));
    std::vector<Vector2d> plane(vertices.size(), Vector2d::Zero());
    std::vector<int> unknown(vertices.size(), 0);
    for (std::size_t s = 0; s < piece.sides.size(); ++s) {
      std::vector<int> side = outlines_.segments[at(piece.sides[s].segment)].vertices;
      if (!piece.sides[s].forward) std::reverse(side.begin(), side.end());
      std::vector<double> along{0};
      for (std::size_t i = 1; i < side.size(); ++i)
        along.push_back(along.back() + (X_.row(side[i]) - X_.row(side[i - 1])).norm());
      for (std::size_t i = 0; i < side.size(); ++i) {
        const double t = along.back() > 0 ? along[i] / along.back()
                                          : static_cast<double>(i) / static_cast<double>(side.size() - 1);
        const int v = number.at(side[i]);
        plane[at(v)] = ring ? on_circle((1 - t) * angles[s] + t * angles[s + 1])
                            : Vector2d((1 - t) * on_circle(angles[s]) + t * on_circle(angles[s + 1]));
        unknown[at(v)] = -1;
      }
    }
    int n_unknown = 0;
    for (int& u : unknown)
      if (u >= 0) u = n_unknown++;
    if (n_unknown == 0) return plane;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n_unknown, 2);
    const auto couple = [&](int a, int b, double weight) {
      if (unknown[at(a)] < 0) return;
      entries.emplace_back(unknown[at(a)], unknown[at(a)], weight);
      if (unknown[at(b)] >= 0)
        entries.emplace_back(unknown[at(a)], unknown[at(b)], -weight);
      else
        right.row(unknown[at(a)]) += weight * plane[at(b)].transpose();
    };
    for (const int f : piece.triangles)
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d apex = X_.row(T_(f, (k + 2) % 3)).transpose();
        const Eigen::Vector3d u = X_.row(T_(f, k)).transpose() - apex,
                              w = X_.row(T_(f, (k + 1) % 3)).transpose() - apex;
        const double cotangent = u.dot(w) / std::max(u.cross(w).norm(), 1e-300);
        const double weight = std::clamp(cotangent, kLeastWeight, 1 / kLeastWeight);
        const int a = number.at(T_(f, k)), b = number.at(T_(f, (k + 1) % 3));
        couple(a, b, weight);
        couple(b, a, weight);
      }
    SparseMatrix A(n_unknown, n_unknown);
    A.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky factor("map of a patch");
    factor.factorize(A);
    const Eigen::MatrixXd solution = factor.solve(right);
    for (std::size_t i = 0; i < plane.size(); ++i)
      if (unknown[i] >= 0) plane[i] = solution.row(unknown[i]).transpose();
    return plane;
  }

  /// Points of a regular grid in every triangle, until there are as many as wanted.
  void add_inner_points(const OutlinePiece& piece, std::size_t wanted, std::vector<int>& points,
                        std::vector<Vector2d>& plane) {
    if (points.size() >= wanted) return;
    std::map<int, std::size_t> place;
    for (std::size_t i = 0; i < points.size(); ++i) place[points[i]] = i;
    const double per_triangle = static_cast<double>(wanted) / static_cast<double>(piece.triangles.size());
    const int n = std::min(20, 2 + static_cast<int>(std::sqrt(2 * per_triangle)));
    for (const int f : piece.triangles)
      for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
          const int k = n - i - j;
          if (i == n || j == n || k == n) continue;
          const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n,
                       c = static_cast<double>(k) / n;
          inner_points_.push_back(a * X_.row(T_(f, 0)) + b * X_.row(T_(f, 1)) + c * X_.row(T_(f, 2)));
          points.push_back(static_cast<int>(X_.rows()) + static_cast<int>(inner_points_.size()) - 1);
          plane.push_back(a * plane[place.at(T_(f, 0))] + b * plane[place.at(T_(f, 1))] +
                          c * plane[place.at(T_(f, 2))]);
        }
  }

  void add_quad(int p, const PieceQuad& quad) {
    const int q = static_cast<int>(layout_.quads.size());
    LayoutQuad result;
    result.corners = quad.corners;
    result.patch = outlines_.pieces[at(p)].patch;
    for (int k = 0; k < 4; ++k) {
      const int from = quad.corners[at(k)], to = quad.corners[at((k + 1) % 4)];
      const auto [segment, part] = quad.outline[at(k)];
      const auto key = segment >= 0 ? std::make_tuple(-1, segment, part)
                                    : std::make_tuple(p, std::min(from, to), std::max(from, to));
      const auto [found, is_new] = edge_of_.try_emplace(key, static_cast<int>(layout_.edges.size()));
      if (is_new) {
        LayoutEdge edge;
        edge.corners = {from, to};
        edge.is_sharp = segment >= 0 && outlines_.segments[at(segment)].is_sharp;
        layout_.edges.push_back(edge);
      }
      LayoutEdge& edge = layout_.edges[at(found->second)];
      const int place = edge.quads[0] < 0 ? 0 : 1;
      edge.quads[at(place)] = q;
      edge.sides[at(place)] = k;
      result.edges[at(k)] = found->second;
    }
    layout_.quads.push_back(result);
  }

  const Points& X_;
  const Triangles& T_;
  PatchOutlines outlines_;
  std::vector<char> is_split_;                          ///< per segment
  std::map<std::tuple<int, int, int>, int> corner_of_;  ///< kind, which, place
  std::map<std::tuple<int, int, int>, int> edge_of_;
  std::vector<Eigen::RowVector3d> inner_points_;
  QuadLayout layout_;
};

}  // namespace

QuadLayout quad_layout(const Points& positions, const Triangles& triangles,
                       const std::vector<int>& patch_of_triangle, double crease_angle,
                       const Progress& progress) {
  return QuadLayoutBuilder(positions, triangles,
                           patch_outlines(positions, triangles, patch_of_triangle, crease_angle))
      .build(progress);
}

}  // namespace batten::detail
