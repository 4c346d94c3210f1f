#pragma once
#include <array>

namespace batten {

/// A place in [0, 1] and its weight.
struct GaussPoint {
  double place, weight;
};

/// The Gauss–Legendre rule of five points on [0, 1]: exact for polynomials of degree 9 (to rounding: all
/// digits of a double). Its error for other functions f is f⁽¹⁰⁾ / 2.5e12 (Abramowitz and Stegun, Handbook of
/// mathematical functions, 25.4.30).
constexpr std::array<GaussPoint, 5> kGaussRule{{{0.046910077030668004, 0.11846344252809454},
                                                {0.23076534494715845, 0.23931433524968324},
                                                {0.5, 0.28444444444444444},
                                                {0.76923465505284155, 0.23931433524968324},
                                                {0.953089922969332, 0.11846344252809454}}};

/// ∫ f over [0, 1] by kGaussRule. Five calls of f, in order.
template <typename Function>
double gauss_integral(const Function& f) {
  double sum = 0;
  for (const GaussPoint& point : kGaussRule) sum += point.weight * f(point.place);
  return sum;
}

}  // namespace batten
