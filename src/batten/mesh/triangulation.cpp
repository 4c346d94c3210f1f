#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

using Row = Eigen::RowVector3d;

// Cutting ears takes quadratic time in the worst case; a longer polygon is no face that a program writes.
constexpr int kMostCorners = 10000;

/// Cuts one polygon into triangles, the best-shaped ear first, in the plane that fits it best.
class EarCutter {
 public:
  EarCutter(const Points& positions, const int* corners, int n) : n_(n) {
    // Newell's normal: the sum of the areas projected on the three planes, taken from the centroid so that a
    // polygon far from the origin loses no digits.
    Row centre = Row::Zero();
    for (int i = 0; i < n; ++i) centre += positions.row(corners[i]);
    centre /= n;
    Row normal = Row::Zero();
    for (int i = 0; i < n; ++i) {
      const Row a = positions.row(corners[i]) - centre, b = positions.row(corners[(i + 1) % n]) - centre;
      normal += a.cross(b);
    }
    Row u;
    const double length = normal.norm();
    if (length > 0) {
      normal /= length;
      u = normal.cross(Row::Unit(std::abs(normal(0)) < 0.6 ? 0 : 1)).normalized();
    } else {  // no area at all: any plane gives triangles without area
      normal = Row::UnitZ();
      u = Row::UnitX();
    }
    const Row v = normal.cross(u);
    points_.resize(static_cast<size_t>(n));
    for (int i = 0; i < n; ++i) {
      const Row p = positions.row(corners[i]) - centre;
      points_[static_cast<size_t>(i)] = {p.dot(u), p.dot(v)};
    }
  }

  /// Calls emit(a, b, c) with corner numbers of n − 2 triangles that keep the sense of the polygon.
  template <typename Emit>
  void cut(Emit emit) {
    if (n_ == 3) return emit(0, 1, 2);
    next_.resize(static_cast<size_t>(n_));
    previous_.resize(static_cast<size_t>(n_));
    stamp_.assign(static_cast<size_t>(n_), 0);
    for (int i = 0; i < n_; ++i) {
      next_[static_cast<size_t>(i)] = (i + 1) % n_;
      previous_[static_cast<size_t>(i)] = (i + n_ - 1) % n_;
    }
    for (int i = 0; i < n_; ++i)
      if (turn(i) <= 0) reflex_.push_back(i);
    for (int i = 0; i < n_; ++i) offer(i);
    for (int left = n_; left > 3; --left) {
      const int ear = best_ear();
      const int a = previous_[static_cast<size_t>(ear)], c = next_[static_cast<size_t>(ear)];
      emit(a, ear, c);
      next_[static_cast<size_t>(a)] = c;
      previous_[static_cast<size_t>(c)] = a;
      next_[static_cast<size_t>(ear)] = -1;
      any_ = a;
      reflex_.erase(std::remove_if(reflex_.begin(), reflex_.end(),
                                   [&](int i) { return i == ear || ((i == a || i == c) && turn(i) > 0); }),
                    reflex_.end());
      offer(a);
      offer(c);
    }
    const int b = any_, a = previous_[static_cast<size_t>(b)], c = next_[static_cast<size_t>(b)];
    emit(a, b, c);
  }

 private:
  struct Ear {
    double quality;
    int corner;
    int stamp;
    bool operator<(const Ear& other) const {
      return quality != other.quality ? quality < other.quality : corner > other.corner;
    }
  };

  double area(int a, int b, int c) const {
    const Eigen::Vector2d u = points_[static_cast<size_t>(b)] - points_[static_cast<size_t>(a)];
    const Eigen::Vector2d v = points_[static_cast<size_t>(c)] - points_[static_cast<size_t>(a)];
    return u.x() * v.y() - u.y() * v.x();
  }
  double turn(int i) const {
    return area(previous_[static_cast<size_t>(i)], i, next_[static_cast<size_t>(i)]);
  }

  /// Twice the area over the sum of the squared sides: 0 for a sliver, largest for an equilateral triangle.
  double quality(int i) const {
    const auto a = static_cast<size_t>(previous_[static_cast<size_t>(i)]),
               c = static_cast<size_t>(next_[static_cast<size_t>(i)]);
    const double sides = (points_[a] - points_[static_cast<size_t>(i)]).squaredNorm() +
                         (points_[c] - points_[static_cast<size_t>(i)]).squaredNorm() +
                         (points_[a] - points_[c]).squaredNorm();
    return sides > 0 ? turn(i) / sides : 0;
  }

  bool is_ear(int i) const {
    const int a = previous_[static_cast<size_t>(i)], c = next_[static_cast<size_t>(i)];
    if (!(turn(i) > 0)) return false;
    if (crosses_itself_) return true;
    for (const int r : reflex_) {
      if (r == i || r == a || r == c || next_[static_cast<size_t>(r)] < 0) continue;
      const Eigen::Vector2d& p = points_[static_cast<size_t>(r)];
      if (p == points_[static_cast<size_t>(a)] || p == points_[static_cast<size_t>(i)] ||
          p == points_[static_cast<size_t>(c)])
        continue;
      if (area(a, i, r) >= 0 && area(i, c, r) >= 0 && area(c, a, r) >= 0) return false;
    }
    return true;
  }

  /// For four corners the second triangle counts as well: the diagonal is chosen by the worse of both.
  void offer(int i) {
    const auto k = static_cast<size_t>(i);
    ++stamp_[k];
    if (!is_ear(i)) return;
    double q = quality(i);
    const int opposite = next_[static_cast<size_t>(next_[k])];
    if (next_[static_cast<size_t>(opposite)] == previous_[k]) q = std::min(q, quality(opposite));
    ears_.push({q, i, stamp_[k]});
  }

  void offer_all() {
    int i = any_;
    do {
      offer(i);
      i = next_[static_cast<size_t>(i)];
    } while (i != any_);
  }

  int best_ear() {
    while (!ears_.empty()) {
      const Ear ear = ears_.top();
      ears_.pop();
      const auto k = static_cast<size_t>(ear.corner);
      if (next_[k] >= 0 && ear.stamp == stamp_[k]) return ear.corner;
    }
    // Blocked ears may be free by now. A simple polygon always has one, so where none is the polygon crosses
    // itself: from then on nothing blocks an ear, and where no corner is convex the least bad one goes.
    offer_all();
    if (!ears_.empty()) return best_ear();
    if (!crosses_itself_) {
      crosses_itself_ = true;
      return best_ear();
    }
    int best = any_, i = any_;
    do {
      if (quality(i) > quality(best)) best = i;
      i = next_[static_cast<size_t>(i)];
    } while (i != any_);
    return best;
  }

  int n_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<int> next_, previous_;  // next_ is −1 for corners that were cut off
  std::vector<int> stamp_;
  std::vector<int> reflex_;
  std::priority_queue<Ear> ears_;
  int any_ = 0;
  bool crosses_itself_ = false;
};

}  // namespace

TriangleMesh triangulated(const PolygonMesh& mesh) {
  const Eigen::Index n_faces = mesh.n_faces();
  const auto n_vertices = static_cast<int>(mesh.positions.rows());
  Eigen::Index n_triangles = 0;
  for (Eigen::Index f = 0; f < n_faces; ++f) {
    const int begin = mesh.offsets[static_cast<size_t>(f)], end = mesh.offsets[static_cast<size_t>(f) + 1];
    if (end - begin < 3)
      throw InvalidInput(concat("face ", f, " has ", end - begin, " corners, expected at least 3"));
    if (end - begin > kMostCorners)
      throw InvalidInput(
          concat("face ", f, " has ", end - begin, " corners, more than ", kMostCorners, "; split it"));
    for (int c = begin; c < end; ++c) {
      const int v = mesh.corners[static_cast<size_t>(c)];
      if (v < 0 || v >= n_vertices)
        throw InvalidInput(concat("face ", f, " names vertex ", v, ", but there are ", n_vertices));
    }
    n_triangles += end - begin - 2;
  }
  TriangleMesh result;
  result.positions = mesh.positions;
  result.triangles.resize(n_triangles, 3);
  Eigen::Index t = 0;
  for (Eigen::Index f = 0; f < n_faces; ++f) {
    const int begin = mesh.offsets[static_cast<size_t>(f)],
              n = mesh.offsets[static_cast<size_t>(f) + 1] - begin;
    const int* corners = mesh.corners.data() + begin;
    EarCutter(mesh.positions, corners, n).cut([&](int a, int b, int c) {
      result.triangles.row(t++) << corners[a], corners[b], corners[c];
    });
  }
  return result;
}

Triangles cut_at_first_corners(const PolygonMesh& quads) {
  Triangles triangles(2 * quads.n_faces(), 3);
  for (Eigen::Index f = 0; f < quads.n_faces(); ++f) {
    const int* c = &quads.corners[at(4 * f)];
    triangles.row(2 * f) << c[0], c[1], c[2];
    triangles.row(2 * f + 1) << c[0], c[2], c[3];
  }
  return triangles;
}

}  // namespace batten
