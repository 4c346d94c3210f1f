#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

// Cubic B-splines over [0, 1] with clamped knots. Private to the room.
namespace batten::detail {

/// Three arguments of the polar form (blossom) of a cubic.
using PolarArguments = std::array<double, 3>;

/// Knots that halve towards an irregular end; double where the cell at that end begins, so that this cell
/// need only continue the next one with its first derivative.
/// @param isolation halvings, at least 2.
std::vector<double> graded_knots(bool from_begin, bool from_end, int isolation);

/// Arguments of a control point, and a parameter inside the cell whose polynomial gives it.
struct ControlSite {
  PolarArguments arguments;
  double inside = 0;
};
ControlSite control_site(const std::vector<double>& knots, Eigen::Index i);

/// The i-th cubic Bernstein polynomial.
double bernstein(int i, double t);

/// The four basis functions that are not zero on a span, and their derivatives (Cox and de Boor).
struct BsplineBasis {
  int first = 0;  ///< number of the first of them
  double value[4], derivative[4];
};
/// @pre t is in [0, 1].
BsplineBasis bspline_basis(const std::vector<double>& knots, double t);

/// The polar form of a cell of a spline as weights of four of its control points (de Boor's scheme).
struct PolarWeights {
  int first = 0;  ///< number of the first of them
  std::array<double, 4> weights{};
};
/// @param inside  a parameter in the cell.
PolarWeights polar_weights(const std::vector<double>& knots, double inside, const PolarArguments& arguments);

}  // namespace batten::detail
