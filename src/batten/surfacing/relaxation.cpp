#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/relaxation_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::RowVector2d;
using Eigen::RowVector3d;

/// Rounds of flips and moves; most of what they do is done in the first three.
constexpr int kRelaxationRounds = 8;
constexpr int kMostSweeps = 20;
/// Needles are evened out with the triangles within this many rings around them.
constexpr int kRings = 4;
/// A triangle with an angle below this is a needle.
const double kNeedle = radians(15);
/// Rounds end when all angles are above this: the solve that follows takes some back.
const double kWanted = radians(18);
/// A move that leaves all angles around above this is taken although one becomes smaller.
const double kGoodAngle = radians(30);

double angle_at(const RowVector3d& a, const RowVector3d& b, const RowVector3d& c) {
  const RowVector3d p = b - a, q = c - a;
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

double least_angle(const RowVector3d& a, const RowVector3d& b, const RowVector3d& c) {
  return std::min({angle_at(a, b, c), angle_at(b, c, a), angle_at(c, a, b)});
}

bool is_needle(const Points& X, const Triangles& T, Index f, const std::vector<char>& on_network,
               double least = kNeedle) {
  for (int k = 0; k < 3; ++k) {
    const int a = T(f, k), b = T(f, (k + 1) % 3), c = T(f, (k + 2) % 3);
    if (on_network[at(a)] && on_network[at(b)] && on_network[at(c)]) return false;  // forced by curves
    if (angle_at(X.row(a), X.row(b), X.row(c)) < least) return true;
  }
  return false;
}

class Relaxation {
 public:
  Relaxation(Points& X, const Points& N, Triangles& T, const std::vector<char>& on_network,
             std::vector<char> active)
      : X_(X), N_(N), T_(T), on_network_(on_network), active_(std::move(active)) {
    opposite_ = opposite_half_edges(T_);
  }

  void run() {
    for (int round = 0; round < kRelaxationRounds; ++round) {
      bool changed = false;
      for (int sweep = 0; sweep < kMostSweeps && flip_all(); ++sweep) changed = true;
      if (move_all()) changed = true;
      if (!changed || !any_needle()) return;
    }
  }

 private:
  bool any_needle() const {
    for (Index f = 0; f < T_.rows(); ++f)
      if (active_[at(f)] && is_needle(X_, T_, f, on_network_, kWanted)) return true;
    return false;
  }

  int corner(int h, int step) const { return T_(h / 3, (h % 3 + step) % 3); }

  bool faces_outward(int a, int b, int c) const {
    const RowVector3d area = (X_.row(b) - X_.row(a)).cross(X_.row(c) - X_.row(a));
    return area.dot(N_.row(a) + N_.row(b) + N_.row(c)) > 0;
  }

  double least(int a, int b, int c) const { return least_angle(X_.row(a), X_.row(b), X_.row(c)); }

  /// Walks round the inner vertex at corner h (of triangle h / 3) and looks for the other one.
  bool joined(int h, int other) const {
    const int begin = h;
    do {
      if (corner(h, 1) == other || corner(h, 2) == other) return true;
      const int across =
          opposite_[at(3 * (h / 3) + (h % 3 + 1) % 3)];  // over the edge opposite the next corner
      if (across < 0) return true;                       // no inner vertex: leave it
      h = 3 * (across / 3) + (across % 3 + 1) % 3;
    } while (h != begin);
    return false;
  }

  bool flip(int h) {
    const int g = opposite_[at(h)];
    if (g < 0 || g < h || !active_[at(h / 3)] || !active_[at(g / 3)]) return false;
    const int a = corner(h, 0), b = corner(h, 1), c = corner(h, 2), d = corner(g, 0);
    if ((on_network_[at(b)] && on_network_[at(c)]) || (on_network_[at(a)] && on_network_[at(d)]) || a == d)
      return false;
    const double before = std::min(least(a, b, c), least(d, c, b));
    if (!(std::min(least(a, b, d), least(d, c, a)) > before + 1e-6)) return false;
    if (!faces_outward(a, b, d) || !faces_outward(d, c, a)) return false;
    if (on_network_[at(a)] ? joined(g, a) : joined(h, d)) return false;
    const auto next = [](int x, int step) { return 3 * (x / 3) + (x % 3 + step) % 3; };
    const int bd = opposite_[at(next(g, 1))], ab = opposite_[at(next(h, 2))], ca = opposite_[at(next(h, 1))],
              dc = opposite_[at(next(g, 2))];
    const int f0 = 3 * (h / 3), g0 = 3 * (g / 3);
    T_.row(h / 3) << a, b, d;
    T_.row(g / 3) << d, c, a;
    const auto link = [&](int x, int y) {
      opposite_[at(x)] = y;
      if (y >= 0) opposite_[at(y)] = x;
    };
    link(f0, bd);
    link(f0 + 1, g0 + 1);
    link(f0 + 2, ab);
    link(g0, ca);
    link(g0 + 2, dc);
    return true;
  }

  bool flip_all() {
    bool any = false;
    for (int h = 0; h < static_cast<int>(opposite_.size()); ++h)
      if (flip(h)) any = true;
    return any;
  }

  /// Smallest angle of the triangles around v were it at x; −1 where one of them is turned over.
  double least_around(int v, const RowVector3d& x, const int* begin, const int* end) {
    const RowVector3d old = X_.row(v);
    X_.row(v) = x;
    double smallest = kPi;
    for (const int* f = begin; f != end && smallest >= 0; ++f) {
      const int a = T_(*f, 0), b = T_(*f, 1), c = T_(*f, 2);
      smallest = faces_outward(a, b, c) ? std::min(smallest, least(a, b, c)) : -1;
    }
    X_.row(v) = old;
    return smallest;
  }

  /// The area-weighted mean of the circumcentres around v, in its tangent plane.
  RowVector3d wanted_place(int v, const int* begin, const int* end) const {
    const RowVector3d x = X_.row(v), n = N_.row(v);
    const RowVector3d e = n.unitOrthogonal(), e2 = n.cross(e);
    RowVector2d sum = RowVector2d::Zero();
    double total = 0;
    for (const int* f = begin; f != end; ++f) {
      const int k = T_(*f, 0) == v ? 0 : T_(*f, 1) == v ? 1 : 2;
      const RowVector3d p3 = X_.row(T_(*f, (k + 1) % 3)) - x, q3 = X_.row(T_(*f, (k + 2) % 3)) - x;
      const RowVector2d p(p3.dot(e), p3.dot(e2)), q(q3.dot(e), q3.dot(e2));
      total += p.x() * q.y() - p.y() * q.x();
      sum += 0.5 * RowVector2d(q.y() * p.squaredNorm() - p.y() * q.squaredNorm(),
                               q.x() * -p.squaredNorm() + p.x() * q.squaredNorm());
    }
    if (!(total > 0)) return x;
    sum /= total;
    return x + sum.x() * e + sum.y() * e2;
  }

  bool move_all() {
    std::vector<int> start(at(X_.rows() + 1), 0);
    for (Index f = 0; f < T_.rows(); ++f)
      for (int k = 0; k < 3; ++k) ++start[at(T_(f, k) + 1)];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<int> around(at(start.back())), fill(start.begin(), start.end() - 1);
    for (Index f = 0; f < T_.rows(); ++f)
      for (int k = 0; k < 3; ++k) around[at(fill[at(T_(f, k))]++)] = static_cast<int>(f);
    bool any = false;
    for (int v = 0; v < X_.rows(); ++v) {
      const int *begin = around.data() + start[at(v)], *end = around.data() + start[at(v + 1)];
      const auto is_active = [&](int f) { return active_[at(f)] != 0; };
      if (on_network_[at(v)] || begin == end || !std::all_of(begin, end, is_active)) continue;
      // With three neighbours the mean of the circumcentres is that of the triangle around, often on its
      // edge.
      if (move_towards(v, wanted_place(v, begin, end), begin, end) ||
          move_towards(v, mean_of_ring(v, begin, end), begin, end))
        any = true;
    }
    return any;
  }

  bool move_towards(int v, const RowVector3d& place, const int* begin, const int* end) {
    const RowVector3d x = X_.row(v), way = place - x;
    const double least = std::min(least_around(v, x, begin, end) + 1e-3, kGoodAngle);
    for (const double part : {1.0, 0.5, 0.25}) {
      if (!(least_around(v, x + part * way, begin, end) > least)) continue;
      X_.row(v) = x + part * way;
      return true;
    }
    return false;
  }

  /// The mean of the neighbours of v, in its tangent plane.
  RowVector3d mean_of_ring(int v, const int* begin, const int* end) const {
    const RowVector3d x = X_.row(v), n = N_.row(v);
    RowVector3d sum = RowVector3d::Zero();
    for (const int* f = begin; f != end; ++f)
      for (int k = 0; k < 3; ++k)
        if (T_(*f, k) != v) sum += X_.row(T_(*f, k)) - x;  // every neighbour twice
    sum /= 2 * static_cast<double>(end - begin);
    return x + sum - sum.dot(n) * n;
  }

  Points& X_;
  const Points& N_;
  Triangles& T_;
  const std::vector<char>& on_network_;
  std::vector<char> active_;  ///< per triangle
  std::vector<int> opposite_;
};

}  // namespace

bool relax_triangles(Points& X, const Points& N, Triangles& T, const std::vector<char>& on_network) {
  std::vector<char> active(at(T.rows()), 0), near(at(X.rows()), 0);
  for (Index f = 0; f < T.rows(); ++f) active[at(f)] = is_needle(X, T, f, on_network);
  if (std::find(active.begin(), active.end(), 1) == active.end()) return false;
  for (int ring = 0; ring < kRings; ++ring) {
    for (Index f = 0; f < T.rows(); ++f)
      for (int k = 0; k < 3 && active[at(f)]; ++k)
        if (!on_network[at(T(f, k))]) near[at(T(f, k))] = 1;
    for (Index f = 0; f < T.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (near[at(T(f, k))]) active[at(f)] = 1;
  }
  try {
    Relaxation(X, N, T, on_network, std::move(active)).run();
  } catch (const InvalidInput&) {
    return false;  // sheets that branch
  }
  return true;
}

int count_needles(const Points& X, const Triangles& T, const std::vector<char>& on_network) {
  int n = 0;
  for (Index f = 0; f < T.rows(); ++f) n += is_needle(X, T, f, on_network);
  return n;
}

}  // namespace batten::detail
