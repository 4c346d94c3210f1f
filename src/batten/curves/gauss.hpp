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

/// The same to fifteen digits. Lengths of Hermite pieces have always been taken with these: with all digits
/// every resampled network would come out different in the last one.
constexpr std::array<GaussPoint, 5> kGaussRuleOfFifteenDigits{{{0.046910077030668, 0.118463442528095},
                                                               {0.230765344947158, 0.239314335249683},
                                                               {0.5, 0.284444444444444},
                                                               {0.769234655052842, 0.239314335249683},
                                                               {0.953089922969332, 0.118463442528095}}};

/// ∫ f over [0, 1] by Gauss's rule. Five calls of f, in order.
template <typename Function>
double gauss_integral(const Function& f, const std::array<GaussPoint, 5>& rule = kGaussRule) {
  double sum = 0;
  for (const GaussPoint& point : rule) sum += point.weight * f(point.place);
  return sum;
}

}  // namespace batten
