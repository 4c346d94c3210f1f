// Generalised Catmull–Clark split of H 6.4, done in a plane: centroids of faces in space lie anywhere when a
// face is far from convex.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/modelling/face_parts_detail.hpp"
#include "batten/modelling/face_split_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Corners that turn in by less than this are left alone: hands do not draw straight angles.
constexpr double kReflexFrom = 1.15 * kPi;
/// What is left of a concave corner may be cut again while it is wider than this: three right angles make it
/// regular.
constexpr double kWideFrom = 0.8 * kPi;

/// A projection that shortens a piece of the boundary to less than this is no picture of the face.
constexpr double kLeastLength = 0.6;

/// A vertex so near to the wanted direction of a cut will do.
constexpr double kNearCut = 0.14 * kPi;
constexpr double kWhole = std::numeric_limits<double>::infinity();

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

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
  for (Index i = 0, n = polygon.rows(); i < n; ++i) twice += cross(polygon.row(i), polygon.row((i + 1) % n));
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

/// A face while it is divided.
class Splitter {
 public:
  /// @param m segments of each side.
  /// @param reach over how many of them angles at corners are taken: a side that turns in beside a corner
  /// makes it concave, although it goes on smoothly there.
  Splitter(int n_sides, int m, PlanePoints boundary, int reach = 1)
      : n_sides_(n_sides), m_(m), reach_(reach), boundary_(std::move(boundary)) {}

  /// @param widest angle that a concave corner may keep; infinite: the face stays whole.
  FaceSplit run(double widest) {
    begin();
    widest_ = widest;
    divide_piece(whole_face());
    return result();
  }

  /// Into how many parts the sides should be divided so that cuts from concave corners find a vertex where
  /// the sides there, drawn on, would end: three right angles are then left. Nothing is asked for where a cut
  /// to a vertex that is there does.
  std::vector<int> parts_at_concave_corners() {
    begin();
    const std::vector<Chain> whole = whole_face();
    const size_t n = whole.size();
    std::vector<std::vector<double>> feet(n);  // per side: along it, 0 to 1
    for (size_t c = 0; c < n; ++c) {
      if (!concave_[c] || n < 4) continue;
      const Vector2d here = p(whole[c][0]), next = p(whole[c][1]) - here;
      const double angle = angle_at(whole, c);
      const auto turned = [&](double by) -> Vector2d { return Eigen::Rotation2Dd(by) * next.normalized(); };
      std::vector<double> cuts;  // that are there, as angles from the next side
      for (size_t k = 0; k < n; ++k)
        if (k != c && (k + 1) % n != c && (c + 1) % n != k && is_inside(whole, c, k))
          cuts.push_back(angle_between(next, p(whole[k][0]) - here));
      const auto has = [&](double low, double high) {
        return std::any_of(cuts.begin(), cuts.end(), [&](double cut) { return cut > low && cut < high; });
      };
      if (has(angle - kWideFrom, kWideFrom)) continue;
      for (const double wanted : {angle - kPi, kPi}) {
        if (has(wanted - kNearCut, wanted + kNearCut)) continue;
        if (const auto [side, along] = first_hit(here, turned(wanted)); side >= 0)
          feet[at(side)].push_back(along);
      }
    }
    std::vector<int> parts(n, 1);
    for (size_t k = 0; k < n; ++k)
      if (!feet[k].empty()) parts[k] = parts_through(feet[k]);
    return parts;
  }

  /// A quadrilateral as rows and columns of quads. @param corners its corners, numbers of sides; as many
  /// sides lie between the first two as between the last.
  FaceSplit run_grid(const std::vector<size_t>& corners) {
    begin();
    fill_grid(corners);
    FaceSplit split = result();
    split.is_grid = true;
    return split;
  }

  bool is_valid() const { return !folded(0); }

  /// How near the triangles come to equilateral ones: the mean of their quality by area, 0 to 1.
  double shape() const {
    double sum = 0, area = 0;
    for (const std::array<int, 4>& quad : quads_)
      for (const std::array<int, 3>& t : cut_along_corners(quad)) {
        const Vector2d a = p(t[1]) - p(t[0]), b = p(t[2]) - p(t[1]), c = p(t[0]) - p(t[2]);
        const double own = cross(a, b) / 2;
        sum += own * 4 * std::sqrt(3.0) * own / (a.squaredNorm() + b.squaredNorm() + c.squaredNorm());
        area += own;
      }
    return sum / area;
  }

 private:
  /// The vertices of one side of a piece, from corner to corner.
  using Chain = std::vector<int>;

  void begin() {
    positions_.clear();
    for (Index i = 0; i < boundary_.rows(); ++i) positions_.push_back(boundary_.row(i));
    quads_.clear();
    cuts_.clear();
    n_pieces_ = 0;
  }

  std::vector<Chain> whole_face() {
    std::vector<Chain> whole;
    for (int k = 0; k < n_sides_; ++k) {
      Chain chain;
      for (int i = 0; i <= m_; ++i) chain.push_back((k * m_ + i) % static_cast<int>(boundary_.rows()));
      whole.push_back(std::move(chain));
    }
    concave_.assign(whole.size(), 0);
    for (size_t k = 0; k < whole.size(); ++k) concave_[k] = angle_at(whole, k) > kReflexFrom;
    return whole;
  }

  /// Where a ray from a corner first meets the boundary again: the side and how far along it, or −1.
  std::pair<int, double> first_hit(const Vector2d& from, const Vector2d& direction) const {
    std::pair<int, double> hit(-1, 0);
    double nearest = std::numeric_limits<double>::infinity();
    const Index n = boundary_.rows();
    for (Index i = 0; i < n; ++i) {
      const Vector2d a = boundary_.row(i), b = boundary_.row((i + 1) % n);
      const double det = cross(direction, b - a);
      if (std::abs(det) <= 1e-12 * (b - a).norm()) continue;
      const double distance = cross(a - from, b - a) / det, share = cross(a - from, direction) / det;
      if (share < 0 || share > 1 || distance < 1e-6 * (b - a).norm() || distance >= nearest) continue;
      nearest = distance;
      hit = {static_cast<int>(i) / m_, (static_cast<double>(i % m_) + share) / m_};
    }
    return hit;
  }

  /// The fewest equal parts, up to four, that have an end near every foot.
  static int parts_through(std::vector<double> feet) {
    std::sort(feet.begin(), feet.end());
    feet.erase(std::unique(feet.begin(), feet.end(), [](double a, double b) { return b - a < 0.1; }),
               feet.end());
    const int fewest = std::min(static_cast<int>(feet.size()) + 1, 4);
    int best = fewest;
    double least = 1;
    for (int parts = fewest; parts <= 4; ++parts) {
      double worst = 0;
      for (const double foot : feet)
        worst =
            std::max(worst, std::abs(foot - std::clamp(std::round(foot * parts), 1.0, parts - 1.0) / parts));
      if (worst < 0.6 * least) least = worst, best = parts;
    }
    return best;
  }

  FaceSplit result() const {
    FaceSplit split;
    split.domain.resize(static_cast<Index>(positions_.size()), 2);
    for (size_t v = 0; v < positions_.size(); ++v)
      split.domain.row(static_cast<Index>(v)) = positions_[v].transpose();
    split.n_boundary = static_cast<int>(boundary_.rows());
    split.quads = quads_;
    split.n_pieces = n_pieces_;
    split.cuts = cuts_;
    return split;
  }

  int add(const Vector2d& position) {
    positions_.push_back(position);
    return static_cast<int>(positions_.size()) - 1;
  }

  const Vector2d& p(int v) const { return positions_[at(v)]; }

  /// A vertex is a concave corner of the face.
  bool is_concave(int v) const { return v < n_sides_ * m_ && v % m_ == 0 && concave_[at(v / m_)]; }

  /// The inner angle at corner k of a piece, 0 to 2π.
  double angle_at(const std::vector<Chain>& piece, size_t k) const {
    const Chain& next = piece[k];
    const Chain& last = piece[(k + piece.size() - 1) % piece.size()];
    const auto reach = static_cast<size_t>(reach_);
    return angle_between(p(next[reach]) - p(next[0]), p(last[last.size() - 1 - reach]) - p(next[0]));
  }

  /// From a counter-clockwise to b, 0 to 2π.
  static double angle_between(const Vector2d& a, const Vector2d& b) {
    const double angle = std::atan2(cross(a, b), a.dot(b));
    return angle < 0 ? angle + 2 * kPi : angle;
  }

  /// The straight line between two corners runs inside the piece.
  bool is_inside(const std::vector<Chain>& piece, size_t a, size_t b) const {
    const Vector2d from = p(piece[a][0]), to = p(piece[b][0]);
    const Chain& last = piece[(a + piece.size() - 1) % piece.size()];
    const double start = angle_between(p(piece[a][1]) - from, to - from),
                 whole = angle_between(p(piece[a][1]) - from, p(last[last.size() - 2]) - from);
    if (!(start > 0.1) || !(start < whole - 0.1)) return false;
    for (const Chain& chain : piece)
      for (size_t i = 0; i + 1 < chain.size(); ++i) {
        const int v = chain[i], w = chain[i + 1];
        if (v == piece[a][0] || v == piece[b][0] || w == piece[a][0] || w == piece[b][0]) continue;
        // On the line itself lie sides that end where it begins: they only meet it if they overlap it.
        const int side_v = orient2d(from, to, p(v)), side_w = orient2d(from, to, p(w));
        if (side_v == 0 && side_w == 0) {
          const auto along = [&](int end) { return (p(end) - from).dot(to - from); };
          if (std::max(along(v), along(w)) > 0 && std::min(along(v), along(w)) < (to - from).squaredNorm())
            return false;
        } else if (side_v * side_w <= 0 && orient2d(p(v), p(w), from) * orient2d(p(v), p(w), to) <= 0) {
          return false;
        }
      }
    return true;
  }

  /// Cuts a piece at its most concave corner, again and again, where a straight line within it helps.
  void divide_piece(std::vector<Chain> piece) {
    const size_t n = piece.size();
    double worst = 0;
    size_t reflex = n;
    for (size_t k = 0; std::isfinite(widest_) && n > 3 && k < n; ++k) {
      const double angle = angle_at(piece, k), from = is_concave(piece[k][0]) ? widest_ : kReflexFrom;
      if (angle > std::max(from, worst) + 1e-6) worst = angle, reflex = k;
    }
    size_t to = n;
    double best = std::numeric_limits<double>::infinity();
    for (size_t k = 0; reflex < n && k < n; ++k) {
      if (k == reflex || (k + 1) % n == reflex || (reflex + 1) % n == k) continue;
      if (!is_inside(piece, reflex, k)) continue;
      // The line should halve the concave corner, leave no concave corners at its other end, and be short.
      const Vector2d line = p(piece[k][0]) - p(piece[reflex][0]);
      const double first = angle_between(p(piece[reflex][1]) - p(piece[reflex][0]), line),
                   rest = worst - first;
      const double other = angle_at(piece, k), before = angle_between(p(piece[k][1]) - p(piece[k][0]), -line),
                   after = other - before;
      const auto excess = [](double angle) { return std::max(0.0, angle - 1.02 * kPi); };
      const auto lack = [](double angle) { return std::max(0.0, kPi / 4 - angle); };
      double concave = 0;
      for (const double angle : {first, rest, before, after}) concave += excess(angle) + 0.5 * lack(angle);
      const double cost = line.norm() * (1 + 4 * concave);
      if (cost < best * (1 - 1e-6)) best = cost, to = k;
    }
    if (to == n) {
      fill_piece(piece);
      return;
    }
    Chain line{piece[reflex][0]};
    for (int i = 1; i < m_; ++i) {
      const double t = static_cast<double>(i) / m_;
      line.push_back(add((1 - t) * p(piece[reflex][0]) + t * p(piece[to][0])));
    }
    line.push_back(piece[to][0]);
    const bool both_concave = is_concave(piece[to][0]);
    Chain back(line.rbegin(), line.rend());
    cuts_.push_back({line[0], line[1]});
    if (both_concave) cuts_.push_back({back[0], back[1]});
    std::vector<Chain> first{line}, second{back};
    for (size_t k = to; k != reflex; k = (k + 1) % n) first.push_back(piece[k]);
    for (size_t k = reflex; k != to; k = (k + 1) % n) second.push_back(piece[k]);
    divide_piece(std::move(first));
    divide_piece(std::move(second));
  }

  /// The split of Catmull–Clark: n grids around the centroid, their inner vertices bilinearly blended from
  /// their sides (H 6.1.2).
  void fill_piece(const std::vector<Chain>& piece) {
    const size_t n = piece.size();
    const int half = m_ / 2, first_inner = static_cast<int>(positions_.size());
    const size_t first_quad = quads_.size();
    Vector2d sum = Vector2d::Zero();
    double length = 0;
    for (const Chain& chain : piece)
      for (size_t i = 0; i + 1 < chain.size(); ++i) {
        const double step = (p(chain[i + 1]) - p(chain[i])).norm();
        sum += step * (p(chain[i]) + p(chain[i + 1])) / 2;
        length += step;
      }
    const int centre = add(sum / length);
    std::vector<Chain> spokes(n);  // from the middle of each side to the centroid
    for (size_t k = 0; k < n; ++k) {
      const int middle = piece[k][at(half)];
      spokes[k].push_back(middle);
      for (int i = 1; i < half; ++i) {
        const double t = static_cast<double>(i) / half;
        spokes[k].push_back(add((1 - t) * p(middle) + t * p(centre)));
      }
      spokes[k].push_back(centre);
    }
    for (size_t k = 0; k < n; ++k) {  // the quad at the start of side k
      const size_t before = (k + n - 1) % n;
      Eigen::MatrixXi grid(half + 1, half + 1);  // i along side k, j along the side before, backwards
      for (int i = 0; i <= half; ++i) {
        grid(i, 0) = piece[k][at(i)];
        grid(0, i) = piece[before][piece[before].size() - 1 - at(i)];
        grid(half, i) = spokes[k][at(i)];
        grid(i, half) = spokes[before][at(i)];
      }
      const auto q = [&](int i, int j) -> const Vector2d& { return p(grid(i, j)); };
      for (int j = 1; j < half; ++j)
        for (int i = 1; i < half; ++i) {
          const double u = static_cast<double>(i) / half, v = static_cast<double>(j) / half;
          const Vector2d position = (1 - v) * q(i, 0) + v * q(i, half) + (1 - u) * q(0, j) + u * q(half, j) -
                                    (1 - u) * (1 - v) * q(0, 0) - u * (1 - v) * q(half, 0) -
                                    (1 - u) * v * q(0, half) - u * v * q(half, half);
          grid(i, j) = add(position);
        }
      for (int j = 0; j < half; ++j)
        for (int i = 0; i < half; ++i)
          quads_.push_back({grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)});
    }
    ++n_pieces_;
    if (folded(first_quad)) relax(first_quad, first_inner);
  }

  void fill_grid(const std::vector<size_t>& corners) {
    const int n = static_cast<int>(boundary_.rows()), first_inner = n;
    const auto vertex = [&](size_t corner) { return static_cast<int>(corners[corner]) * m_; };
    const int columns = vertex(1) - vertex(0), rows = vertex(2) - vertex(1);
    Eigen::MatrixXi grid(columns + 1, rows + 1);
    for (int i = 0; i <= columns; ++i) {
      grid(i, 0) = vertex(0) + i;
      grid(i, rows) = vertex(3) - i;
    }
    for (int j = 0; j <= rows; ++j) {
      grid(columns, j) = vertex(1) + j;
      grid(0, j) = (vertex(3) + rows - j) % n;
    }
    const auto q = [&](int i, int j) -> const Vector2d& { return p(grid(i, j)); };
    for (int j = 1; j < rows; ++j)
      for (int i = 1; i < columns; ++i) {
        const double u = static_cast<double>(i) / columns, v = static_cast<double>(j) / rows;
        grid(i, j) = add((1 - v) * q(i, 0) + v * q(i, rows) + (1 - u) * q(0, j) + u * q(columns, j) -
                         (1 - u) * (1 - v) * q(0, 0) - u * (1 - v) * q(columns, 0) -
                         (1 - u) * v * q(0, rows) - u * v * q(columns, rows));
      }
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        std::array<int, 4> quad{grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)};
        const bool right = i % m_ >= m_ / 2, upper = j % m_ >= m_ / 2;
        std::rotate(quad.begin(), quad.begin() + (right ? (upper ? 2 : 1) : (upper ? 3 : 0)), quad.end());
        quads_.push_back(quad);
      }
    n_pieces_ = 1;
    if (folded(0)) relax(0, first_inner);
  }

  bool folded(size_t from) const {
    for (size_t q = from; q < quads_.size(); ++q)
      for (const std::array<int, 3>& t : cut_along_corners(quads_[q]))
        if (orient2d(p(t[0]), p(t[1]), p(t[2])) <= 0) return true;
    return false;
  }

  /// Puts every inner vertex of a piece into the mean of its neighbours [tutte1963].
  void relax(size_t first_quad, int first_inner) {
    const int n = static_cast<int>(positions_.size()) - first_inner;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 2);
    for (size_t q = first_quad; q < quads_.size(); ++q)
      for (const std::array<int, 3>& t : cut_along_corners(quads_[q]))
        for (int k = 0; k < 3; ++k) {
          const int v = t[static_cast<size_t>(k)], w = t[static_cast<size_t>((k + 1) % 3)];
          for (const auto& [a, b] : {std::pair(v, w), std::pair(w, v)}) {
            if (a < first_inner) continue;
            entries.emplace_back(a - first_inner, a - first_inner, 1.0);
            if (b < first_inner)
              right.row(a - first_inner) += p(b).transpose();
            else
              entries.emplace_back(a - first_inner, b - first_inner, -1.0);
          }
        }
    SparseMatrix A(n, n);
    A.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky solver("layout of a face", CholeskyBackend::Eigen);
    solver.factorize(A);
    const Eigen::MatrixXd solved = solver.solve(right);
    for (int v = 0; v < n; ++v) positions_[at(first_inner + v)] = solved.row(v);
  }

  int n_sides_, m_, reach_, n_pieces_ = 0;
  PlanePoints boundary_;
  std::vector<Vector2d> positions_;
  std::vector<std::array<int, 4>> quads_;
  std::vector<std::array<int, 2>> cuts_;
  std::vector<char> concave_;  // per corner of the face
  double widest_ = kReflexFrom;
};

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
    Splitter splitter(n_sides, 1 << splits, projected);
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
        Splitter splitter(n_sides, 1 << splits, polygon, std::max(reach, 1));
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
    Splitter splitter(n_sides, 1 << splits,
                      boundary_over(sides, corners, quadrilateral(lengths_between(sides, corners))));
    FaceSplit split = is_grid ? splitter.run_grid(corners) : splitter.run(kWhole);
    if (splitter.is_valid()) return split;
  }
  if (const PlanePoints polygon = cyclic_polygon(loop, n_sides); polygon.rows() > 0) {
    Splitter splitter(n_sides, 1 << splits, polygon);
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
  Splitter splitter(n_sides, 1 << splits, disc);
  return splitter.run(kWhole);
}

}  // namespace

std::vector<int> parts_at_concave_corners(const std::vector<Points>& sides) {
  std::vector<int> parts(sides.size(), 1);
  if (const PlanePoints projected = projection_of(loop_of(sides)); projected.rows() > 0)
    parts = Splitter(static_cast<int>(sides.size()), static_cast<int>(sides[0].rows()) - 1, projected)
                .parts_at_concave_corners();
  else if (const PlanePoints polygon = unrolled_where_narrow(sides, loop_of(sides)); polygon.rows() > 0)
    parts = Splitter(static_cast<int>(sides.size()), static_cast<int>(sides[0].rows()) - 1, polygon,
                     static_cast<int>(sides[0].rows() - 1) / 2)
                .parts_at_concave_corners();
  return parts;
}

FaceSplit split_face_into_quads(const std::vector<Points>& sides, int splits) {
  FaceSplit split = lay_out(sides, splits);
  if (split.n_pieces != 1 || split.is_unrolled) return split;
  const std::vector<size_t> corners = corners_of_quadrilateral(sides);
  if (corners.empty()) return split;
  Splitter splitter(
      static_cast<int>(sides.size()), 1 << splits,
      boundary_over(sides, corners, {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)}));
  split.square = (split.is_grid ? splitter.run_grid(corners) : splitter.run(kWhole)).domain;
  if (!splitter.is_valid()) split.square.resize(0, 2);
  return split;
}

}  // namespace batten::detail
