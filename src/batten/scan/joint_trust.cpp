#include <algorithm>
#include <cmath>

#include "batten/core/units.hpp"
#include "batten/scan/joint_model_detail.hpp"

// The robust loss of the joint estimate.
namespace batten {

namespace {

/// Residuals of so many standard deviations keep their whole say, and all below one degree do.
constexpr double kTrustedDeviations = 4, kTrustedAngle = radians(1.0);

}  // namespace

double JointModel::trusted_angle(int curve, int k, double white) const {
  const double readings = std::max(scan_.curves[curve].weights[k], 1.0);
  return std::max(kTrustedDeviations * white / std::sqrt(readings), kTrustedAngle);
}

double JointModel::distrust_cost(double white) const {
  // The weight of the loss is t = (L²/r²)² beyond L, so that the loss is 2L² − L⁴/r²; t r² = L⁴/r² is
  // counted.
  double cost = 0;
  for (int c = 0; c < layout_.n_curves; ++c)
    for (int k = 0; k < scan_.curves[c].n_samples(); ++k) {
      const double limit = trusted_angle(c, k, white);
      const double trust = state_.trust[layout_.first_sample[c] + k];
      cost += std::max(scan_.curves[c].weights[k], 0.0) * 2 * limit * limit * (1 - std::sqrt(trust));
    }
  return cost / (white * white);
}

void JointModel::update_trust(double white) {
  for (int c = 0; c < layout_.n_curves; ++c) {
    for (int k = 0; k < scan_.curves[c].n_samples(); ++k) {
      // What lies between readings has no data to be wrong.
      if (!(scan_.curves[c].weights[k] > 0)) continue;
      const double limit = trusted_angle(c, k, white);
      const double ratio = limit * limit / std::max(reading_residual(c, k).squaredNorm(), 1e-300);
      state_.trust[layout_.first_sample[c] + k] = ratio >= 1 ? 1 : ratio * ratio;
    }
  }
}

}  // namespace batten
