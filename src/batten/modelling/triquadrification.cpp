// Based on H 6.1; the search over all divisions is that of minimum-weight triangulation [klincsek1980] with
// quads as further parts.
#include "batten/modelling/triquadrification.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/coons.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSamples = 8;          ///< per side, for the outline
constexpr int kMostSides = 40;       ///< for dynamic programming: a tenth of a second
constexpr double kReflex = 10;       ///< degrees above 180 at which a corner counts as reflex
constexpr double kTurnedOver = 120;  ///< degrees between a part and its face
constexpr double kMostBent = 65;     ///< degrees between a corner and its face: 55 in an octant of a sphere
constexpr double kBarelyShown =
    0.7;                             ///< of its length: a piece of the outline of half a tube, flaring or not
constexpr double kLeastSine = 0.02;  ///< of the angle at which a diagonal leaves the border
constexpr int kPointsOfDiagonal = 32;  ///< segments of its polyline

bool is_less(const SplitCost& a, const SplitCost& b) {
  return a.flaws != b.flaws ? a.flaws < b.flaws : a.angle() < b.angle() - 1e-9;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool properly_crosses(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
  const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
  return ((c_side > 0) != (d_side > 0)) && ((a_side > 0) != (b_side > 0)) && c_side != 0 && d_side != 0 &&
         a_side != 0 && b_side != 0;
}

double distance_from_segment(const Vector2d& q, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0 ? std::clamp((q - a).dot(along) / squared, 0.0, 1.0) : 0;
  return (a + t * along - q).norm();
}

/// A face as the searches see it.
class Face {
 public:
  explicit Face(const std::vector<SharedPolyline>& sides) : n_(static_cast<int>(sides.size())) {
    const Vector3d area = doubled_area(sides);
    normal_ = area.stableNormalized();
    origin_ = sides.front()->front();
    if (normal_.squaredNorm() > 0) {
      first_ = normal_.unitOrthogonal();
      second_ = normal_.cross(first_);
    } else {
      first_ = Vector3d::UnitX();
      second_ = Vector3d::UnitY();
    }
    double least_shown = 1;  // of a piece of the outline, in the plane
    for (int k = 0; k < n_; ++k) {
      const Polyline& side = *sides[at(k)];
      corners_.push_back(side.front());
      // Directions over a quarter of the length: bent faces run into their mean normal at the very end.
      out_.push_back((side.at(side.length() / 4) - side.front()).stableNormalized());
      back_.push_back((side.at(side.length() * 3 / 4) - side.back()).stableNormalized());
      const Points samples = side.sampled(kSamples);
      Vector3d swept = Vector3d::Zero();
      for (int i = 0; i < kSamples; ++i) {
        const Vector3d step = samples.row(i + 1) - samples.row(i);
        if (step.norm() > 0)
          least_shown = std::min(least_shown, (step - step.dot(normal_) * normal_).norm() / step.norm());
        const Vector3d p = samples.row(i).transpose() - origin_;
        swept += p.cross(Vector3d(samples.row(i + 1).transpose() - origin_));
        outline_.push_back(flat(samples.row(i)));
        heights_.push_back(p.dot(normal_));
      }
      swept_.push_back(swept);
    }
    is_simple_ = normal_.squaredNorm() > 0 && !is_bent();
    const size_t m = outline_.size();
    for (size_t i = 0; i < m && is_simple_; ++i)
      for (size_t j = i + 1; j < m && is_simple_; ++j)
        is_simple_ =
            !properly_crosses(outline_[i], outline_[(i + 1) % m], outline_[j], outline_[(j + 1) % m]);
    leaves_.assign(at(n_) * at(n_), -1);
    if (n_ <= 3) return;
    const FacePatch quad = associate_quad(sides);
    if (n_ > 4 && quad.has_four_corners && least_shown < kBarelyShown) is_simple_ = false;
    if (!is_simple_) follow_patch(quad);
  }

  int n() const { return n_; }
  const Vector3d& corner(int k) const { return corners_[at(k)]; }
  /// Whether the face is taken to lie over a plane: its outline, seen along the normal, does not cross
  /// itself, it is not bent as far as half a tube, and it is not a bent face of four corners, between which
  /// its patch is known better. Then inside and outside are known.
  bool is_simple() const { return is_simple_; }
  /// Whether the outline, seen along the normal, is not convex. @pre is_simple().
  bool has_reflex_corner() const {
    for (int k = 0; k < n_; ++k)
      if (interior_angle(out_[at(k)], back_[at((k + n_ - 1) % n_)], normal_) > kPi + kReflex * kPi / 180)
        return true;
    return false;
  }
  Vector2d flat(const Vector3d& p) const { return {(p - origin_).dot(first_), (p - origin_).dot(second_)}; }

  /// Flaws of the diagonal between two corners; sides have none.
  int flaws_of_diagonal(int i, int j) const {
    if ((i + 1) % n_ == j || (j + 1) % n_ == i) return 0;
    if (!is_simple_) return diagonals_[entry(i, j)].along_border ? 3 : 0;
    int& known = leaves_[at(std::min(i, j)) * at(n_) + at(std::max(i, j))];
    if (known < 0) {
      const Vector2d a = flat(corner(i)), b = flat(corner(j));
      known = 0;
      for (int s = 0; s <= kSamples && known == 0; ++s) {
        const double t = (s + 0.5) / (kSamples + 1);
        const Vector2d q = (1 - t) * a + t * b;
        if (!contains(q) || clearance(q) < kLeastSine * std::min(t, 1 - t) * (b - a).norm()) known = 3;
      }
      if (known == 0 && crosses_outline(a, b)) known = 3;
    }
    return known;
  }

  /// Whether a curve seen along the normal leaves the face between its ends. @pre is_simple().
  bool leaves(const Points& curve) const {
    for (Index k = 0; k + 1 < curve.rows(); ++k) {
      if (k > 0 && !contains(flat(curve.row(k)))) return true;
      // Its ends lie on the outline: the first and last segments are let off.
      if (k > 0 && k + 2 < curve.rows() && crosses_outline(flat(curve.row(k)), flat(curve.row(k + 1))))
        return true;
    }
    return false;
  }

  /// What one part costs, without its diagonals.
  SplitCost cost_of_part(const int* part, int size) const {
    SplitCost cost;
    Vector3d area = Vector3d::Zero();
    double perimeter = 0;
    for (int k = 0; k < size; ++k) {
      const int i = part[k], j = part[(k + 1) % size];
      const Vector3d chord = corner(j) - corner(i);
      perimeter += chord.norm();
      area += is_side(i, j)        ? swept_[at(i)]
              : diagonals_.empty() ? Vector3d((corner(i) - origin_).cross(corner(j) - origin_))
                                   : diagonals_[entry(i, j)].swept;
    }
    const Vector3d normal = area.stableNormalized();
    cost.planarity = std::atan2(normal.cross(normal_).norm(), normal.dot(normal_));
    if (cost.planarity > kTurnedOver * kPi / 180 || area.norm() < 1e-6 * perimeter * perimeter)
      cost.flaws += 2;
    const double regular = kPi * (size - 2) / size;
    for (int k = 0; k < size; ++k) {
      const int here = part[k], next = part[(k + 1) % size], last = part[(k + size - 1) % size];
      const Vector3d to_next = is_side(here, next) ? out_[at(here)] : leaving(here, next);
      const Vector3d to_last = is_side(last, here) ? back_[at(last)] : leaving(here, last);
      const double curved = interior_angle(to_next, to_last, normal);
      const double straight = interior_angle(direction(here, next), direction(here, last), normal);
      // Only where both say so: sides that bulge out make corners of chords reflex, and faces that bend by
      // more than a right angle make ends of their sides look so.
      if (std::min(curved, straight) > kPi + kReflex * kPi / 180) ++cost.flaws;
      cost.shape += std::abs(curved - regular) / size;
    }
    return cost;
  }

  /// Heights over the plane of the face at points of it, from those of the outline.
  Points lifted(const Vector2d& from, const Vector2d& to, int n_segments) const;

 private:
  /// A diagonal over the Coons patch of a face that is not taken to lie over a plane, from one corner to the
  /// other.
  struct Over {
    Vector3d swept, leaving;
    bool along_border = false;
  };

  size_t entry(int i, int j) const { return at(i) * at(n_) + at(j); }

  /// Takes diagonals as lines of the Coons patch of the associated quad: straight ones would cut through the
  /// face.
  void follow_patch(const FacePatch& quad) {
    diagonals_.resize(at(n_) * at(n_));
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) {
        if (i == j) continue;
        Over& over = diagonals_[entry(i, j)];
        over.along_border = quad.on_one_side(i, j);
        const Points line = quad.patch.along(quad.parameters[at(i)], quad.parameters[at(j)], kSamples);
        over.swept.setZero();
        for (int k = 0; k < kSamples; ++k)
          over.swept += (line.row(k).transpose() - origin_).cross(line.row(k + 1).transpose() - origin_);
        over.leaving = (line.row(kSamples / 4) - line.row(0)).transpose().stableNormalized();
      }
  }

  Vector3d leaving(int from, int to) const {
    return diagonals_.empty() ? direction(from, to) : diagonals_[entry(from, to)].leaving;
  }

  bool is_bent() const {
    for (int k = 0; k < n_; ++k) {
      const Vector3d cross = out_[at(k)].cross(back_[at((k + n_ - 1) % n_)]);
      // Straight corners have no plane of their own; reflex ones have the other sign.
      if (cross.norm() > 0.17 &&
          std::abs(cross.dot(normal_)) < std::cos(kMostBent * kPi / 180) * cross.norm())
        return true;
    }
    return false;
  }

  bool is_side(int i, int j) const { return (i + 1) % n_ == j; }
  Vector3d direction(int from, int to) const { return (corner(to) - corner(from)).stableNormalized(); }

  static double interior_angle(const Vector3d& next, const Vector3d& last, const Vector3d& normal) {
    const double angle = std::atan2(next.cross(last).dot(normal), next.dot(last));
    // In the plane of the part; what sticks out of it changes little for parts that are nearly plane.
    return angle < -1e-9 ? angle + 2 * kPi : angle;
  }

  bool contains(const Vector2d& q) const {  // by the number of crossings with a ray
    bool inside = false;
    for (size_t i = 0, m = outline_.size(); i < m; ++i) {
      const Vector2d &a = outline_[i], &b = outline_[(i + 1) % m];
      if ((a.y() > q.y()) != (b.y() > q.y()) &&
          q.x() < a.x() + (q.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        inside = !inside;
    }
    return inside;
  }

  double clearance(const Vector2d& q) const {
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0, m = outline_.size(); i < m; ++i)
      least = std::min(least, distance_from_segment(q, outline_[i], outline_[(i + 1) % m]));
    return least;
  }

  bool crosses_outline(const Vector2d& a, const Vector2d& b) const {
    // Ends that are corners touch the outline there; a thousandth is left off on either side.
    const Vector2d p = a + 1e-3 * (b - a), q = b + 1e-3 * (a - b);
    for (size_t i = 0, m = outline_.size(); i < m; ++i)
      if (properly_crosses(p, q, outline_[i], outline_[(i + 1) % m])) return true;
    return false;
  }

  int n_;
  Vector3d normal_, origin_, first_, second_;
  std::vector<Vector3d> corners_, out_, back_, swept_;
  std::vector<Vector2d> outline_;
  std::vector<double> heights_;
  bool is_simple_ = false;
  mutable std::vector<int> leaves_;
  std::vector<Over> diagonals_;  ///< per pair of corners; empty for faces over a plane
};

Points Face::lifted(const Vector2d& from, const Vector2d& to, int n_segments) const {
  // A quadric over the plane, fitted to the outline; the faintest pull keeps what the outline does not
  // determine (a circle does not tell 1 from x² + y²) at zero.
  const double size = std::max((outline_.front() - outline_[outline_.size() / 2]).norm(), 1e-300);
  const auto terms = [&](const Vector2d& q) {
    const double x = q.x() / size, y = q.y() / size;
    Eigen::Matrix<double, 6, 1> row;
    row << 1, x, y, x * x, x * y, y * y;
    return row;
  };
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
  for (size_t i = 0; i < outline_.size(); ++i) {
    const auto row = terms(outline_[i]);
    A += row * row.transpose();
    b += row * heights_[i];
  }
  const double pull = 1e-6 * static_cast<double>(outline_.size());
  A.diagonal().array() += Eigen::Array<double, 6, 1>(1e-9, 1e-9, 1e-9, 1, 1, 1) * pull;
  const Eigen::Matrix<double, 6, 1> quadric = A.ldlt().solve(b);
  std::vector<double> rest(outline_.size());
  for (size_t i = 0; i < outline_.size(); ++i) rest[i] = heights_[i] - terms(outline_[i]).dot(quadric);
  // Mean value interpolation of the rest ([hormann2006], without their special cases: the ends
  // are corners and set exactly below).
  const auto interpolated = [&](const Vector2d& q) {
    double sum = 0, total = 0;
    const size_t m = outline_.size();
    const auto half_tangent = [&](const Vector2d& a, const Vector2d& c) {
      const double r = a.norm() * c.norm();
      const double denominator = r + a.dot(c), numerator = cross(a, c);
      return std::abs(denominator) > 1e-14 * r ? numerator / denominator : 0.0;
    };
    for (size_t i = 0; i < m; ++i) {
      const Vector2d before = outline_[(i + m - 1) % m] - q, here = outline_[i] - q,
                     after = outline_[(i + 1) % m] - q;
      const double r = here.norm();
      if (r < 1e-12 * size) return rest[i];
      const double weight = (half_tangent(before, here) + half_tangent(here, after)) / r;
      sum += weight * rest[i];
      total += weight;
    }
    return std::abs(total) > 0 ? sum / total : 0.0;
  };
  Points points(n_segments + 1, 3);
  for (int k = 0; k <= n_segments; ++k) {
    const double t = static_cast<double>(k) / n_segments;
    const Vector2d q = (1 - t) * from + t * to;
    const double height = terms(q).dot(quadric) + interpolated(q);
    points.row(k) = (origin_ + q.x() * first_ + q.y() * second_ + height * normal_).transpose();
  }
  return points;
}

SplitCost cost_with_diagonals(const Face& face, const std::vector<std::vector<int>>& parts) {
  SplitCost total;
  for (const std::vector<int>& part : parts) {
    const auto size = static_cast<int>(part.size());
    total = total + face.cost_of_part(part.data(), size);
    // Each diagonal belongs to two parts and is counted where it runs from its lower corner.
    for (int k = 0; k < size; ++k) {
      const int i = part[at(k)], j = part[at((k + 1) % size)];
      if (i < j) total.flaws += face.flaws_of_diagonal(i, j);
    }
  }
  return total;
}

/// Cuts quads off until `enough` corners are left. @return those.
std::vector<int> cut_off_quads(const Face& face, const FacePatch& quad, int enough,
                               std::vector<std::vector<int>>& parts) {
  std::vector<int> left(at(face.n()));
  for (int k = 0; k < face.n(); ++k) left[at(k)] = k;
  while (static_cast<int>(left.size()) > enough) {
    const auto n = static_cast<int>(left.size());
    SplitCost best;
    int best_start = -1;
    for (int start = 0; start < n; ++start) {
      std::array<int, 4> part{};
      for (int k = 0; k < 4; ++k) part[at(k)] = left[at((start + k) % n)];
      // Not four corners of one edge of the quad (H 6.1.1): the part would have no area in its parameters.
      if (quad.on_one_side(part[0], part[1]) && quad.on_one_side(part[0], part[2]) &&
          quad.on_one_side(part[0], part[3]))
        continue;
      SplitCost cost = face.cost_of_part(part.data(), 4);
      cost.flaws += face.flaws_of_diagonal(part[0], part[3]);
      if (best_start < 0 || is_less(cost, best)) {
        best = cost;
        best_start = start;
      }
    }
    if (best_start < 0) break;
    std::vector<int> part(4);
    for (int k = 0; k < 4; ++k) part[at(k)] = left[at((best_start + k) % n)];
    std::vector<int> rest;
    for (int k = 3; k <= n; ++k) rest.push_back(left[at((best_start + k) % n)]);
    parts.push_back(std::move(part));
    left = std::move(rest);
  }
  return left;
}

/// Dynamic programming over a polygon of corners of a face: the part at the diagonal from the first to the
/// last corner of a range leaves two or three smaller ranges.
class OptimalSplit {
 public:
  OptimalSplit(const Face& face, const std::vector<int>& corners)
      : face_(face),
        corners_(corners),
        n_(static_cast<int>(corners.size())),
        cost_(at(n_) * at(n_)),
        choice_(at(n_) * at(n_), {-1, -1}) {
    for (int span = 2; span < n_; ++span)
      for (int i = 0; i + span < n_; ++i) find(i, i + span);
  }

  void collect(std::vector<std::vector<int>>& parts) const { collect(0, n_ - 1, parts); }

 private:
  size_t entry(int i, int j) const { return at(i) * at(n_) + at(j); }

  void find(int i, int j) {
    SplitCost best;
    bool found = false;
    const auto consider = [&](std::initializer_list<int> part, int k, int l) {
      std::array<int, 4> corner{};
      std::transform(part.begin(), part.end(), corner.begin(), [&](int c) { return corners_[at(c)]; });
      SplitCost cost = cost_[entry(i, k)] + cost_[entry(l < 0 ? k : l, j)];
      if (l >= 0) cost = cost + cost_[entry(k, l)];
      // Whatever the part itself costs is not below zero.
      if (found && !is_less(cost, best)) return;
      cost = cost + face_.cost_of_part(corner.data(), static_cast<int>(part.size()));
      if (found && !is_less(cost, best)) return;
      best = cost;
      found = true;
      choice_[entry(i, j)] = {k, l};
    };
    // Quads first: of equal divisions the one with fewer parts.
    for (int k = i + 1; k < j; ++k)
      for (int l = k + 1; l < j; ++l) consider({i, k, l, j}, k, l);
    for (int k = i + 1; k < j; ++k) consider({i, k, j}, k, -1);
    best.flaws += face_.flaws_of_diagonal(corners_[at(i)], corners_[at(j)]);
    cost_[entry(i, j)] = best;
  }

  void collect(int i, int j, std::vector<std::vector<int>>& parts) const {
    if (j - i < 2) return;
    const auto [k, l] = choice_[entry(i, j)];
    std::vector<int> part{corners_[at(i)], corners_[at(k)]};
    if (l >= 0) part.push_back(corners_[at(l)]);
    part.push_back(corners_[at(j)]);
    parts.push_back(std::move(part));
    collect(i, k, parts);
    if (l >= 0) collect(k, l, parts);
    collect(l >= 0 ? l : k, j, parts);
  }

  const Face& face_;
  const std::vector<int>& corners_;
  int n_;
  std::vector<SplitCost> cost_;
  std::vector<std::pair<int, int>> choice_;
};

}  // namespace

FaceSplit split_face(const std::vector<SharedPolyline>& sides, SplitSearch search) {
  if (sides.size() < 3) throw InvalidInput("a face needs three sides or more to be divided");
  const Face face(sides);
  FaceSplit split;
  const int enough = search == SplitSearch::Greedy ? 4 : kMostSides;
  std::vector<int> left;
  if (face.n() > enough) {
    left = cut_off_quads(face, associate_quad(sides), enough, split.parts);
  } else {
    left.resize(sides.size());
    for (int k = 0; k < face.n(); ++k) left[at(k)] = k;
  }
  if (left.size() == 3 || (search == SplitSearch::Greedy && left.size() == 4))
    split.parts.push_back(left);
  else
    OptimalSplit(face, left).collect(split.parts);
  split.cost = cost_with_diagonals(face, split.parts);
  return split;
}

SplitCost cost_of_split(const std::vector<SharedPolyline>& sides,
                        const std::vector<std::vector<int>>& parts) {
  return cost_with_diagonals(Face(sides), parts);
}

FaceDiagonals diagonals_of_split(const std::vector<SharedPolyline>& sides, const FaceSplit& split) {
  FaceDiagonals result;
  std::vector<Diagonal>& diagonals = result.diagonals;
  const auto n = static_cast<int>(sides.size());
  for (const std::vector<int>& part : split.parts)
    for (size_t k = 0; k < part.size(); ++k) {
      const int i = part[k], j = part[(k + 1) % part.size()];
      if (i < j && j != i + 1 && !(i == 0 && j == n - 1)) diagonals.push_back({i, j, nullptr});
    }
  if (diagonals.empty()) return result;
  const Face face(sides);
  FacePatch quad = associate_quad(sides);
  const auto straight = [&](const Diagonal& diagonal) {
    Points line(2, 3);
    line << face.corner(diagonal.from).transpose(), face.corner(diagonal.to).transpose();
    return line;
  };
  std::vector<Points> curves;
  // The patch maps a straight side of its square onto a side with a reflex corner: it may stay within the
  // face and still be far from what its outline suggests.
  bool any_along_border = false;
  bool is_good = !face.is_simple() || !face.has_reflex_corner();
  for (const Diagonal& diagonal : diagonals) {
    const bool along_border = quad.on_one_side(diagonal.from, diagonal.to);
    any_along_border = any_along_border || along_border;
    curves.push_back(along_border ? straight(diagonal)  // of H 6.4.2
                                  : quad.patch.along(quad.parameters[at(diagonal.from)],
                                                     quad.parameters[at(diagonal.to)], kPointsOfDiagonal));
    if (face.is_simple() && (along_border || face.leaves(curves.back()))) is_good = false;
  }
  if (!is_good)
    for (size_t d = 0; d < diagonals.size(); ++d)
      curves[d] = face.lifted(face.flat(face.corner(diagonals[d].from)),
                              face.flat(face.corner(diagonals[d].to)), kPointsOfDiagonal);
  else if (!any_along_border)
    result.patch = std::move(quad);
  for (size_t d = 0; d < diagonals.size(); ++d) {
    curves[d].row(0) = face.corner(diagonals[d].from).transpose();
    curves[d].row(curves[d].rows() - 1) = face.corner(diagonals[d].to).transpose();
    diagonals[d].polyline = std::make_shared<Polyline>(std::move(curves[d]));
  }
  return result;
}

}  // namespace batten
