#include <cmath>

#include "batten/core/units.hpp"
#include "batten/scan/field_detail.hpp"

namespace batten {

namespace {

constexpr double kStrengthDeviation = 0.05;  // of the strength
constexpr double kDipDeviation = radians(4.0);
/// Narrower losses keep magnets out better, wider ones average more of a field that merely varies; between 3
/// and 20 the errors of ten kinds of simulated recordings change by less than a third.
constexpr double kRobustWidth = 4;

}  // namespace

FieldFigures field_figures(const Eigen::Vector3d& field) {
  return {field.norm(), std::atan2(-field.z(), std::hypot(field.x(), field.y()))};
}

double field_distance(const FieldFigures& field, const FieldFigures& reference) {
  const double strength = (field.strength / reference.strength - 1) / kStrengthDeviation;
  const double dip = (field.dip - reference.dip) / kDipDeviation;
  return strength * strength + dip * dip;
}

double robust_weight(double z_squared) {
  const double t = 1 + z_squared / kRobustWidth;
  return 1 / (t * t);
}

}  // namespace batten
