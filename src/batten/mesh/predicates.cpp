// Based on [shewchuk1997]: expansions and the error bounds of the filters.
#include "batten/mesh/predicates.hpp"

#include <cmath>
#include <vector>

namespace batten {

namespace {

/// A number as a sum of doubles that do not overlap, the smallest first.
using Expansion = std::vector<double>;

void two_sum(double a, double b, double& high, double& low) {
  high = a + b;
  const double virtual_b = high - a;
  low = (a - (high - virtual_b)) + (b - virtual_b);
}

Expansion plus(const Expansion& e, double b) {
  Expansion sum;
  double q = b;
  for (const double term : e) {
    double high = 0, low = 0;
    two_sum(q, term, high, low);
    if (low != 0) sum.push_back(low);
    q = high;
  }
  if (q != 0) sum.push_back(q);
  return sum;
}

Expansion plus(Expansion e, const Expansion& f) {
  for (const double term : f) e = plus(e, term);
  return e;
}

Expansion difference(double a, double b) {
  double high = 0, low = 0;
  two_sum(a, -b, high, low);
  Expansion result;
  if (low != 0) result.push_back(low);
  if (high != 0) result.push_back(high);
  return result;
}

Expansion times(const Expansion& e, const Expansion& f, double sign = 1) {
  Expansion result;
  for (const double x : e)
    for (const double y : f) {
      const double high = sign * x * y;
      const double low = std::fma(sign * x, y, -high);
      result = plus(plus(result, low), high);
    }
  return result;
}

/// a d − b c.
Expansion determinant(const Expansion& a, const Expansion& b, const Expansion& c, const Expansion& d) {
  return plus(times(a, d), times(b, c, -1));
}

/// The largest term decides: the rest together is smaller.
int sign_of(const Expansion& e) {
  if (e.empty()) return 0;
  return e.back() > 0 ? 1 : -1;
}

int sign_of(double value) {
  return value > 0 ? 1 : value < 0 ? -1 : 0;
}

// (3 + 16 ε) ε and (7 + 56 ε) ε with ε = 2⁻⁵³: bounds of the rounding of the plain formulas.
constexpr double kBound2d = 3.3306690738754716e-16;
constexpr double kBound3d = 7.7715611723761027e-16;

Eigen::Vector2d dropped(const Eigen::Vector3d& p, int axis) {
  return {p((axis + 1) % 3), p((axis + 2) % 3)};
}

/// p, which lies on the line through a and b, lies between them.
bool is_between(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::min(a.x(), b.x()) <= p.x() && p.x() <= std::max(a.x(), b.x()) &&
         std::min(a.y(), b.y()) <= p.y() && p.y() <= std::max(a.y(), b.y());
}

bool segments_meet(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& a,
                   const Eigen::Vector2d& b) {
  const int pa = orient2d(a, b, p), qa = orient2d(a, b, q), ap = orient2d(p, q, a), bp = orient2d(p, q, b);
  if (pa * qa < 0 && ap * bp < 0) return true;
  return (pa == 0 && is_between(p, a, b)) || (qa == 0 && is_between(q, a, b)) ||
         (ap == 0 && is_between(a, p, q)) || (bp == 0 && is_between(b, p, q));
}

}  // namespace

int orient2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const double left = (a.x() - c.x()) * (b.y() - c.y()), right = (a.y() - c.y()) * (b.x() - c.x());
  const double determinant_value = left - right;
  const double size = std::abs(left) + std::abs(right);
  if (size == 0 || std::abs(determinant_value) > kBound2d * size) return sign_of(determinant_value);
  return sign_of(determinant(difference(a.x(), c.x()), difference(a.y(), c.y()), difference(b.x(), c.x()),
                             difference(b.y(), c.y())));
}

int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
             const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = b - a, v = c - a, w = d - a;
  const double vw[3] = {v.y() * w.z(), v.z() * w.x(), v.x() * w.y()};
  const double wv[3] = {v.z() * w.y(), v.x() * w.z(), v.y() * w.x()};
  double value = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    value += u(k) * (vw[k] - wv[k]);
    size += std::abs(u(k)) * (std::abs(vw[k]) + std::abs(wv[k]));
  }
  if (size == 0 || std::abs(value) > kBound3d * size) return sign_of(value);
  Expansion e[3][3];
  const Eigen::Vector3d* points[3] = {&b, &c, &d};
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 3; ++k) e[row][k] = difference((*points[row])(k), a(k));
  Expansion sum;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    sum = plus(sum, times(determinant(e[1][l], e[1][m], e[2][l], e[2][m]), e[0][k]));
  }
  return sign_of(sum);
}

bool are_collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  for (int axis = 0; axis < 3; ++axis)
    if (orient2d(dropped(a, axis), dropped(b, axis), dropped(c, axis)) != 0) return false;
  return true;
}

bool segment_meets_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const int sp = orient3d(a, b, c, p), sq = orient3d(a, b, c, q);
  if (sp * sq > 0) return false;
  if (sp != 0 || sq != 0) {
    // The line pq crosses the plane at one point of the segment; it is inside when it passes all edges on the
    // same side.
    const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c), ca = orient3d(p, q, c, a);
    return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector2d a2 = dropped(a, axis), b2 = dropped(b, axis), c2 = dropped(c, axis);
    const int turn = orient2d(a2, b2, c2);
    if (turn == 0) continue;  // seen edge on
    const Eigen::Vector2d p2 = dropped(p, axis), q2 = dropped(q, axis);
    if (segments_meet(p2, q2, a2, b2) || segments_meet(p2, q2, b2, c2) || segments_meet(p2, q2, c2, a2))
      return true;
    return turn * orient2d(a2, b2, p2) > 0 && turn * orient2d(b2, c2, p2) > 0 &&
           turn * orient2d(c2, a2, p2) > 0;
  }
  return false;
}

}  // namespace batten
