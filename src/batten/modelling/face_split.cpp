// Generalised Catmull–Clark split of H 6.4, done in a plane: centroids of faces in space lie anywhere when a
// face is far from convex.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/modelling/face_parts_detail.hpp"
#include "batten/modelling/face_split_detail.hpp"
#include "batten/modelling/face_splitter_detail.hpp"
#include "batten/modelling/plane_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A projection that shortens a piece of the boundary to less than this is no picture of the face.
constexpr double kLeastLength = 0.6;

/// The corners of a closed polygon are its rows.
bool is_simple(const PlanePoints& polygon) {
  const Index n = polygon.rows();
  const auto p = [&](Index i) -> Vector2d { return polygon.row(i % n); };
  for (Index i = 0; i < n; ++i) {
    const Vector2d low = p(i).cwiseMin(p(i + 1)), high = p(i).cwiseMax(p(i + 1));
    for (Index j = i + 1; j < n; ++j) {
      if (((p(j).cwiseMin(p(j + 1)) - high).array() > 0).any() ||
          ((low - p(j).cwiseMax(p(j + 1))).array() > 0).any())
        continue;
      const bool next = j == i + 1, last = i == 0 && j == n - 1;
      if (next || last) {  // neighbours may only not turn back
        const Vector2d shared = next ? p(j) : p(i), one = next ? p(i) : p(i + 1),
                       two = next ? p(j + 1) : p(j);
        if (orient2d(one, shared, two) == 0 && (one - shared).dot(two - shared) >= 0) return false;
        continue;
      }
      const int a = orient2d(p(i), p(i + 1), p(j)), b = orient2d(p(i), p(i + 1), p(j + 1));
      const int c = orient2d(p(j), p(j + 1), p(i)), d = orient2d(p(j), p(j + 1), p(i + 1));
      if (a * b <= 0 && c * d <= 0) return false;
    }
  }
  return true;
}

double area_of(const PlanePoints& polygon) {
  double twice = 0;
  for (Index i = 0, n = polygon.rows(); i < n; ++i)
    twice += cross_in_plane(polygon.row(i), polygon.row((i + 1) % n));
  return twice / 2;
}

/// A polygon with its corners on a circle and straight sides as long as the curved ones of a loop, sampled as
/// they are; empty where there is none (two sides, or one longer than the others together) or where it is
/// too flat at a corner.
PlanePoints cyclic_polygon(const Points& loop, int n_sides) {
  const Index n = loop.rows(), m = n / n_sides;
  Eigen::VectorXd arcs = Eigen::VectorXd::Zero(n + 1), lengths(n_sides);
  for (Index i = 0; i < n; ++i) arcs(i + 1) = arcs(i) + (loop.row((i + 1) % n) - loop.row(i)).norm();
  for (Index k = 0; k < n_sides; ++k) lengths(k) = arcs((k + 1) * m) - arcs(k * m);
  const double longest = lengths.maxCoeff();
  if (n_sides < 3 || longest > 0.45 * arcs(n)) return {};
  // The sides subtend 2 asin(length / diameter); together a whole turn, if the centre lies inside.
  const auto turn = [&](double diameter) { return 2 * (lengths.array() / diameter).min(1.0).asin().sum(); };
  double low = longest, high = arcs(n);
  if (turn(low) < 2 * kPi) return {};
  for (int k = 0; k < 100; ++k) {
    const double middle = (low + high) / 2;
    (turn(middle) > 2 * kPi ? low : high) = middle;
  }
  PlanePoints polygon(n, 2);
  double angle = 0;
  for (Index k = 0; k < n_sides; ++k) {
    const double next = angle + 2 * std::asin(std::min(lengths(k) / high, 1.0));
    const Eigen::RowVector2d from = high / 2 * Eigen::RowVector2d(std::cos(angle), std::sin(angle)),
                             to = high / 2 * Eigen::RowVector2d(std::cos(next), std::sin(next));
    for (Index i = 0; i < m; ++i) {
      const double t = (arcs(k * m + i) - arcs(k * m)) / lengths(k);
      polygon.row(k * m + i) = (1 - t) * from + t * to;
    }
    angle = next;
  }
  return polygon;
}

/// Lengths of the four sides of a quadrilateral with these corners.
std::array<double, 4> lengths_between(const std::vector<Points>& sides, const std::vector<size_t>& corners) {
  std::array<double, 4> lengths{};
  for (size_t c = 0; c < 4; ++c)
    for (const size_t k : sides_between(corners, sides.size(), c)) lengths[c] += polyline_length(sides[k]);
  return lengths;
}

/// The boundary of a face with four corners on that of a plane quadrilateral, by arc length between them.
PlanePoints boundary_over(const std::vector<Points>& sides, const std::vector<size_t>& corners,
                          const std::array<Vector2d, 4>& at_corner) {
  const size_t n = sides.size();
  const Index m = sides[0].rows() - 1;
  const std::array<double, 4> lengths = lengths_between(sides, corners);
  PlanePoints boundary(static_cast<Index>(n) * m, 2);
  for (size_t c = 0; c < 4; ++c) {
    double arc = 0;
    for (const size_t k : sides_between(corners, n, c))
      for (Index j = 0; j < m; ++j) {
        const double t = arc / lengths[c];
        boundary.row(static_cast<Index>(k) * m + j) = (1 - t) * at_corner[c] + t * at_corner[(c + 1) % 4];
        arc += (sides[k].row(j + 1) - sides[k].row(j)).norm();
      }
  }
  return boundary;
}

/// The corners, on a circle, of the quadrilateral with sides of these lengths; of the rectangle with their
/// means where one is nearly as long as the others together.
std::array<Vector2d, 4> quadrilateral(const std::array<double, 4>& lengths) {
  const double a = lengths[0], b = lengths[1], c = lengths[2], d = lengths[3];
  const double longest = *std::max_element(lengths.begin(), lengths.end());
  if (longest > 0.48 * (a + b + c + d)) {
    const double width = (a + c) / 2, height = (b + d) / 2;
    return {Vector2d(0, 0), Vector2d(width, 0), Vector2d(width, height), Vector2d(0, height)};
  }
  // Ptolemy's diagonals; the first corner is the origin, the second lies on the axis.
  const double p2 = (a * c + b * d) * (a * d + b * c) / (a * b + c * d),
               q2 = (a * c + b * d) * (a * b + c * d) / (a * d + b * c);
  const auto apex = [&](double from_first, double from_second) {  // squared distances
    const double x = (from_first - from_second + a * a) / (2 * a);
    return Vector2d(x, std::sqrt(std::max(from_first - x * x, 0.0)));
  };
  return {Vector2d(0, 0), Vector2d(a, 0), apex(p2, b * b), apex(d * d, q2)};
}

/// The face is a quadrilateral with several sides between corners, as many on either side.
bool has_grid(const std::vector<size_t>& corners, size_t n_sides) {
  return corners.size() == 4 && n_sides > 4 && corners[1] - corners[0] == corners[3] - corners[2] &&
         2 * (corners[2] - corners[0]) == n_sides;
}

/// The boundary of a face, each side without its end.
Points loop_of(const std::vector<Points>& sides) {
  const Index m = sides[0].rows() - 1, n = static_cast<Index>(sides.size());
  Points loop(n * m, 3);
  for (Index k = 0; k < n; ++k) loop.middleRows(k * m, m) = sides[static_cast<size_t>(k)].topRows(m);
  return loop;
}

/// The loop in its best plane; empty where it overlaps itself there or turns away from it.
PlanePoints projection_of(const Points& loop) {
  const Index n = loop.rows();
  const Vector3d middle = loop.colwise().mean();
  Vector3d normal = Vector3d::Zero();
  double perimeter = 0;
  for (Index i = 0; i < n; ++i) {
    const Vector3d a = loop.row(i).transpose() - middle, b = loop.row((i + 1) % n).transpose() - middle;
    normal += a.cross(b);
    perimeter += (b - a).norm();
  }
  if (!(normal.norm() > 1e-3 * perimeter * perimeter)) return {};
  const Vector3d z = normal.normalized(), x = z.unitOrthogonal(), y = z.cross(x);
  PlanePoints projected(n, 2);
  for (Index i = 0; i < n; ++i) {
    const Vector3d offset = loop.row(i).transpose() - middle;
    projected.row(i) << offset.dot(x), offset.dot(y);
  }
  double least = 1;
  for (Index i = 0; i < n; ++i)
    least = std::min(least, (projected.row((i + 1) % n) - projected.row(i)).norm() /
                                (loop.row((i + 1) % n) - loop.row(i)).norm());
  if (!(least > kLeastLength) || !is_simple(projected) || !(area_of(projected) > 0)) return {};
  return projected;
}

/// A polygon in space unrolled: triangulated with the least area [barequet1995], its triangles laid out one
/// beside the other, which needs no strain as there are no vertices inside. @param rows of the loop.
PlanePoints unrolled(const Points& loop, const std::vector<Index>& rows) {
  const int n = static_cast<int>(rows.size());
  const auto point = [&](int i) -> Vector3d { return loop.row(rows[at(i)]); };
  std::vector<double> least(static_cast<size_t>(n) * static_cast<size_t>(n), 0);
  std::vector<int> apex(least.size(), -1);
  const auto entry = [n](int i, int k) { return static_cast<size_t>(i) * static_cast<size_t>(n) + at(k); };
  for (int span = 2; span < n; ++span)
    for (int i = 0; i + span < n; ++i) {
      const int k = i + span;
      double best = kWhole;
      const Vector3d chord = point(k) - point(i);
      for (int j = i + 1; j < k; ++j) {
        const double cost = least[entry(i, j)] + least[entry(j, k)] + chord.cross(point(j) - point(i)).norm();
        if (!(cost < best)) continue;
        best = cost;
        apex[entry(i, k)] = j;
      }
      least[entry(i, k)] = best;
    }
  PlanePoints corners(n, 2);
  corners.row(0).setZero();
  corners.row(n - 1) << (point(n - 1) - point(0)).norm(), 0;
  std::vector<std::pair<int, int>> stack{{0, n - 1}};
  while (!stack.empty()) {
    const auto [i, k] = stack.back();
    stack.pop_back();
    if (k - i < 2) continue;
    const int j = apex[entry(i, k)];
    if (j < 0) return {};
    const double a = (point(j) - point(i)).norm(), b = (point(j) - point(k)).norm(),
                 c = (point(k) - point(i)).norm();
    if (!(c > 0)) return {};
    const double along = (a * a - b * b + c * c) / (2 * c),
                 aside = std::sqrt(std::max(a * a - along * along, 0.0));
    const Eigen::RowVector2d u = (corners.row(k) - corners.row(i)) / c;
    // What lies between i and k is to the right of the chord from i to k: the loop runs counter-clockwise.
    corners.row(j) = corners.row(i) + along * u + aside * Eigen::RowVector2d(u.y(), -u.x());
    stack.emplace_back(i, j);
    stack.emplace_back(j, k);
  }
  PlanePoints polygon(loop.rows(), 2);
  for (int i = 0; i < n; ++i) {
    const Index from = rows[at(i)], to = i + 1 < n ? rows[at(i + 1)] : loop.rows();
    for (Index row = from; row < to; ++row) {
      const double t = static_cast<double>(row - from) / static_cast<double>(to - from);
      polygon.row(row) = (1 - t) * corners.row(i) + t * corners.row((i + 1) % n);
    }
  }
  return polygon;
}

/// The loop of a face that is narrow somewhere, unrolled; empty where it has no need of that: a convex
/// polygon with sides of the same lengths keeps places apart that lie beside each other at most kMostApart
/// times.
PlanePoints unrolled_where_narrow(const std::vector<Points>& sides, const Points& loop) {
  constexpr Index kMostRows = 128;
  constexpr double kMostApart = 3;
  const std::vector<size_t> corners = corners_of_quadrilateral(sides);
  const int n_sides = static_cast<int>(sides.size());
  const PlanePoints convex =
      corners.empty() ? cyclic_polygon(loop, n_sides)
                      : boundary_over(sides, corners, quadrilateral(lengths_between(sides, corners)));
  Index stride = 1;
  while (loop.rows() / stride > kMostRows && (loop.rows() / n_sides) % (2 * stride) == 0) stride *= 2;
  if (loop.rows() / stride > 2 * kMostRows) return {};
  std::vector<Index> rows;
  for (Index row = 0; row < loop.rows(); row += stride) rows.push_back(row);
  const auto n = rows.size();
  bool is_narrow = false;
  for (size_t i = 0; i < n && !is_narrow && convex.rows() > 0; ++i)
    for (size_t j = i + 2; j < n && !is_narrow; ++j)
      is_narrow = (convex.row(rows[i]) - convex.row(rows[j])).norm() >
                  kMostApart * (loop.row(rows[i]) - loop.row(rows[j])).norm();
  if (!is_narrow) return {};
  PlanePoints polygon = unrolled(loop, rows);
  if (polygon.rows() == 0 || !polygon.allFinite() || !is_simple(polygon) || !(area_of(polygon) > 0))
    return {};
  return polygon;
}

FaceSplit lay_out(const std::vector<Points>& sides, int splits) {
  const int n_sides = static_cast<int>(sides.size());
  const Points loop = loop_of(sides);
  const std::vector<size_t> corners = corners_of_quadrilateral(sides);
  const bool is_grid = has_grid(corners, sides.size());
  if (const PlanePoints projected = projection_of(loop); projected.rows() > 0) {
    FaceSplitter splitter(n_sides, 1 << splits, projected);
    if (is_grid) {
      FaceSplit split = splitter.run_grid(corners);
      split.is_projection = true;
      if (splitter.is_valid()) return split;
    }
    FaceSplit best;
    double best_shape = 0;
    for (const double widest : {kReflexFrom, kWideFrom}) {
      FaceSplit split = splitter.run(widest);
      if (!splitter.is_valid() || !(splitter.shape() > 1.01 * best_shape)) continue;
      best_shape = splitter.shape();
      best = std::move(split);
      if (best.n_pieces == 1) break;
    }
    best.is_projection = true;
    if (best_shape > 0) return best;
  }
  if (const PlanePoints polygon = unrolled_where_narrow(sides, loop); polygon.rows() > 0) {
    FaceSplit best;
    double best_shape = 0;
    for (const int reach : {1 << splits >> 1, 1})
      for (const double widest : {kReflexFrom, kWideFrom}) {
        FaceSplitter splitter(n_sides, 1 << splits, polygon, std::max(reach, 1));
        FaceSplit split = splitter.run(widest);
        if (!splitter.is_valid() || !(splitter.shape() > 1.01 * best_shape)) continue;
        best_shape = splitter.shape();
        best = std::move(split);
      }
    best.is_unrolled = best.is_projection = true;
    if (best_shape > 0) return best;
  }
  // A convex polygon with sides of the same lengths: half a cylinder unrolls to its rectangle.
  if (!corners.empty()) {
    FaceSplitter splitter(n_sides, 1 << splits,
                          boundary_over(sides, corners, quadrilateral(lengths_between(sides, corners))));
    FaceSplit split = is_grid ? splitter.run_grid(corners) : splitter.run(kWhole);
    if (splitter.is_valid()) return split;
  }
  if (const PlanePoints polygon = cyclic_polygon(loop, n_sides); polygon.rows() > 0) {
    FaceSplitter splitter(n_sides, 1 << splits, polygon);
    FaceSplit split = splitter.run(kWhole);
    if (splitter.is_valid()) return split;
  }
  // A disc with the boundary by arc length: whatever the face, the split is a valid one there.
  PlanePoints disc(loop.rows(), 2);
  double arc = 0, perimeter = 0;
  for (Index i = 0, n = loop.rows(); i < n; ++i) perimeter += (loop.row((i + 1) % n) - loop.row(i)).norm();
  for (Index i = 0, n = loop.rows(); i < n; ++i) {
    const double turn = 2 * kPi * (arc + 1e-3 * perimeter * static_cast<double>(i) / static_cast<double>(n)) /
                        (1.001 * perimeter);
    disc.row(i) << perimeter / (2 * kPi) * std::cos(turn), perimeter / (2 * kPi) * std::sin(turn);
    arc += (loop.row((i + 1) % n) - loop.row(i)).norm();
  }
  FaceSplitter splitter(n_sides, 1 << splits, disc);
  return splitter.run(kWhole);
}

}  // namespace

std::vector<int> parts_at_concave_corners(const std::vector<Points>& sides) {
  std::vector<int> parts(sides.size(), 1);
  if (const PlanePoints projected = projection_of(loop_of(sides)); projected.rows() > 0)
    parts = FaceSplitter(static_cast<int>(sides.size()), static_cast<int>(sides[0].rows()) - 1, projected)
                .parts_at_concave_corners();
  else if (const PlanePoints polygon = unrolled_where_narrow(sides, loop_of(sides)); polygon.rows() > 0)
    parts = FaceSplitter(static_cast<int>(sides.size()), static_cast<int>(sides[0].rows()) - 1, polygon,
                         static_cast<int>(sides[0].rows() - 1) / 2)
                .parts_at_concave_corners();
  return parts;
}

FaceSplit split_face_into_quads(const std::vector<Points>& sides, int splits) {
  FaceSplit split = lay_out(sides, splits);
  if (split.n_pieces != 1 || split.is_unrolled) return split;
  const std::vector<size_t> corners = corners_of_quadrilateral(sides);
  if (corners.empty()) return split;
  FaceSplitter splitter(
      static_cast<int>(sides.size()), 1 << splits,
      boundary_over(sides, corners, {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)}));
  split.square = (split.is_grid ? splitter.run_grid(corners) : splitter.run(kWhole)).domain;
  if (!splitter.is_valid()) split.square.resize(0, 2);
  return split;
}

}  // namespace batten::detail
