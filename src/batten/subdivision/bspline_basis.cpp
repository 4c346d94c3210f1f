#include <algorithm>
#include <cmath>

#include "batten/core/index.hpp"
#include "batten/subdivision/bspline_basis_detail.hpp"

namespace batten::detail {

namespace {

/// The span of the knots that holds t: the last i with knots[i] ≤ t < knots[i + 1].
int span_of(const std::vector<double>& knots, double t) {
  const int last = static_cast<int>(knots.size()) - 5;
  const int span = static_cast<int>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin()) - 1;
  return std::clamp(span, 3, last);
}

}  // namespace

std::vector<double> graded_knots(bool from_begin, bool from_end, int isolation) {
  std::vector<double> knots(4, 0.0);
  if (from_begin)
    for (int k = isolation; k >= 1; --k)
      knots.insert(knots.end(), k == isolation ? 2 : 1, std::ldexp(1.0, -k));
  if (from_end)
    for (int k = 1; k <= isolation; ++k)
      if (k > 1 || !from_begin) knots.insert(knots.end(), k == isolation ? 2 : 1, 1 - std::ldexp(1.0, -k));
  knots.insert(knots.end(), 4, 1.0);
  return knots;
}

ControlSite control_site(const std::vector<double>& knots, Eigen::Index i) {
  const size_t k = static_cast<size_t>(i);
  ControlSite result{{knots[k + 1], knots[k + 2], knots[k + 3]}, 0};
  // The cell behind the middle argument in the first half, before it in the second: away from irregular ends.
  const double b = result.arguments[1];
  if (b <= 0.5 && b < 1) {
    const double next = *std::upper_bound(knots.begin(), knots.end(), b);
    result.inside = 0.5 * (b + next);
  } else {
    const double before = *(std::lower_bound(knots.begin(), knots.end(), b) - 1);
    result.inside = 0.5 * (b + before);
  }
  return result;
}

double bernstein(int i, double t) {
  const double s = 1 - t;
  return i == 0 ? s * s * s : i == 1 ? 3 * s * s * t : i == 2 ? 3 * s * t * t : t * t * t;
}

BsplineBasis bspline_basis(const std::vector<double>& knots, double t) {
  BsplineBasis result;
  const int span = span_of(knots, t);
  result.first = span - 3;
  double low[4] = {1, 0, 0, 0};
  double quadratic[4] = {0, 0, 0, 0};
  for (int degree = 1; degree <= 3; ++degree) {
    if (degree == 3) std::copy(low, low + 3, quadratic);
    double next[4] = {0, 0, 0, 0};
    for (int i = 0; i < degree; ++i) {
      const double a = knots[at(span - degree + 1 + i)], b = knots[at(span + 1 + i)];
      const double w = (t - a) / (b - a);
      next[i] += (1 - w) * low[i];
      next[i + 1] += w * low[i];
    }
    std::copy(next, next + 4, low);
  }
  std::copy(low, low + 4, result.value);
  for (int i = 0; i < 4; ++i) result.derivative[i] = 0;
  for (int i = 0; i < 3; ++i) {
    const double width = knots[at(span + 1 + i)] - knots[at(span - 2 + i)];
    result.derivative[i] -= 3 / width * quadratic[i];
    result.derivative[i + 1] += 3 / width * quadratic[i];
  }
  return result;
}

PolarWeights polar_weights(const std::vector<double>& knots, double inside, const PolarArguments& arguments) {
  PolarWeights result;
  const int span = span_of(knots, inside);
  result.first = span - 3;
  std::array<std::array<double, 4>, 4> d{};  // the scheme on the unit vectors
  for (std::size_t i = 0; i < 4; ++i) d[i][i] = 1;
  for (int r = 1; r <= 3; ++r)
    for (int j = 3; j >= r; --j) {
      const double low = knots[at(span - 3 + j)], high = knots[at(span + 1 + j - r)];
      const double t = (arguments[at(r - 1)] - low) / (high - low);
      for (std::size_t i = 0; i < 4; ++i) d[at(j)][i] = (1 - t) * d[at(j - 1)][i] + t * d[at(j)][i];
    }
  result.weights = d[3];
  return result;
}

}  // namespace batten::detail
