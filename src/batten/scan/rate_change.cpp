#include <algorithm>

#include <Eigen/Geometry>

#include "batten/rotation/so3.hpp"
#include "batten/scan/rate_change_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A change of the turn from step to step beyond which there is a corner, radians.
constexpr double kMostChange = 0.5;

}  // namespace

std::vector<Vector3d> rate_changes(const std::vector<Vector3d>& omega, const std::vector<double>& lengths,
                                   bool ring) {
  const size_t n = omega.size();
  std::vector<Vector3d> changes(n + 1, Vector3d::Zero());
  if (n < 2) return changes;
  const auto between = [&](size_t before, size_t after) -> Vector3d {
    const double h = 0.5 * (lengths[before] + lengths[after]);
    const Vector3d change = (omega[after] - omega[before]) / h;
    const double turn = h * h * change.norm();
    return turn > kMostChange ? Vector3d(kMostChange / turn * change) : change;
  };
  for (size_t k = 1; k < n; ++k) changes[k] = between(k - 1, k);
  if (ring) {
    changes[0] = changes[n] = between(n - 1, 0);
  } else {
    changes[0] = changes[1];
    changes[n] = changes[n - 1];
  }
  return changes;
}

Vector3d step_of_rate_change(const Matrix3d& X, const Vector3d& phi, double h, const Vector3d& rate_change) {
  return -h * h * h / 12 * (X * (so3_exp(0.5 * phi) * rate_change.cross(Vector3d::UnitX())));
}

void remove_lag(SampledScan& scan) {
  for (SampledCurve& curve : scan.curves) {
    const int n = curve.n_samples();
    if (curve.lag.size() != n) continue;
    std::vector<Vector3d> omega;
    std::vector<double> lengths;
    for (int k = 0; k + 1 < n; ++k) {
      lengths.push_back(curve.step(k));
      omega.push_back(so3_log(curve.frames[k].transpose() * curve.frames[k + 1]) / curve.step(k));
    }
    const std::vector<Vector3d> changes = rate_changes(omega, lengths, curve.smooth_seam);
    for (int k = 0; k < n; ++k)
      curve.frames[k] = nearest_rotation(curve.frames[k] * so3_exp(-curve.lag[k] * changes[k]));
    if (curve.smooth_seam)  // one frame, read with a lag of its own from either end
      curve.frames.front() = curve.frames.back() =
          nearest_rotation(curve.frames.front() + curve.frames.back());
  }
}

}  // namespace batten
