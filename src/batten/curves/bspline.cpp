#include "batten/curves/bspline.hpp"

#include <algorithm>
#include <cmath>

namespace batten {

CubicBasis cubic_basis(double u, int spans, bool periodic) {
  const int span = std::clamp(static_cast<int>(std::floor(u)), 0, spans - 1);
  const auto knot = [&](int i) {  // knot i of the vector that starts at −3
    return periodic ? static_cast<double>(i) : static_cast<double>(std::clamp(i, 0, spans));
  };
  CubicBasis basis;
  basis.first = span;
  std::array<double, 4> left{}, right{}, quadratic{};
  basis.values[0] = 1;
  for (int degree = 1; degree <= 3; ++degree) {
    left[degree] = u - knot(span + 1 - degree);
    right[degree] = knot(span + degree) - u;
    if (degree == 3) quadratic = basis.values;
    double saved = 0;
    for (int r = 0; r < degree; ++r) {
      const double share = basis.values[r] / (right[r + 1] + left[degree - r]);
      basis.values[r] = saved + right[r + 1] * share;
      saved = left[degree - r] * share;
    }
    basis.values[degree] = saved;
  }
  for (int r = 0; r < 3; ++r) {
    const double slope = 3 * quadratic[r] / (knot(span + 1 + r) - knot(span - 2 + r));
    basis.slopes[r] -= slope;
    basis.slopes[r + 1] += slope;
  }
  return basis;
}

Eigen::RowVector3d BSplineCurve::at(double u, std::size_t span) const {
  std::vector<Eigen::RowVector3d> d(points.begin() + static_cast<std::ptrdiff_t>(span - degree),
                                    points.begin() + static_cast<std::ptrdiff_t>(span + 1));
  for (std::size_t r = 1; r <= degree; ++r)
    for (std::size_t j = degree; j >= r; --j) {
      const double low = knots[span - degree + j], high = knots[span + 1 + j - r];
      const double alpha = high > low ? (u - low) / (high - low) : 0;
      d[j] = (1 - alpha) * d[j - 1] + alpha * d[j];
    }
  return d[degree];
}

}  // namespace batten
