#pragma once
#include <cmath>

#include "batten/core/random.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/samples.hpp"

namespace batten::samples {

/// A noisy scan of a grid of curves on the waves z = 0.1 sin 3x cos 2y over [−1, 1]²: `lines` curves in each
/// direction, which meet in lines² nodes, with `steps` steps between neighbouring nodes. Frames carry white
/// noise (standard deviation `noise` per axis, radians), so that neither the loops close nor the normals
/// agree. Parameters are arc lengths.
inline SampledScan wavy_grid(int lines, int steps, double noise = 0.02) {
  using Eigen::Vector3d;
  Random random(7);
  SampledScan scan;
  const int n = (lines - 1) * steps + 1;
  for (int direction = 0; direction < 2; ++direction) {
    for (int line = 0; line < lines; ++line) {
      const double across = -1 + 2.0 * line / (lines - 1);
      SampledCurve curve;
      curve.parameters.resize(n);
      curve.weights.setOnes(n);
      double distance = 0;
      // ‖dx/du‖ on the curve, for Simpson's rule; x runs along curves of direction 0, y along the others.
      const auto slopes = [&](double u) {
        const double x = direction == 0 ? u : across, y = direction == 0 ? across : u;
        return std::pair(0.3 * std::cos(3 * x) * std::cos(2 * y), -0.2 * std::sin(3 * x) * std::sin(2 * y));
      };
      const auto speed = [&](double u) {
        const auto [zx, zy] = slopes(u);
        return std::sqrt(1 + (direction == 0 ? zx * zx : zy * zy));
      };
      const double du = 2.0 / (n - 1);
      for (int k = 0; k < n; ++k) {
        const double u = -1 + du * k;
        const auto [zx, zy] = slopes(u);
        const Vector3d tangent = direction == 0 ? Vector3d(1, 0, zx) : Vector3d(0, 1, zy);
        const Eigen::Matrix3d exact = darboux_frame(tangent, Vector3d(-zx, -zy, 1), false);
        const Vector3d wrong(random.normal(), random.normal(), random.normal());
        curve.parameters[k] = distance;
        curve.frames.push_back(so3_exp(noise * wrong) * exact);
        distance += du / 6 * (speed(u) + 4 * speed(u + 0.5 * du) + speed(u + du));
        if (k % steps != 0) continue;
        curve.node_samples.push_back(k);
        curve.node_ids.push_back(direction == 0 ? line * lines + k / steps : (k / steps) * lines + line);
      }
      scan.curves.push_back(std::move(curve));
    }
  }
  return scan;
}

/// A grid of about so many samples. The network grows with them at 25 steps per segment, as that of a larger
/// object does; or it stays at 6 × 6 lines and is only sampled more densely.
enum class Growth { Network, Sampling };
inline SampledScan grid_of(long n_samples, Growth growth) {
  int lines = 6, steps = 25;
  const auto count = [](long l, long s) { return 2 * l * ((l - 1) * s + 1); };
  if (growth == Growth::Network) {
    while (count(lines + 1, steps) <= 1.03 * static_cast<double>(n_samples)) ++lines;
  } else {
    steps = static_cast<int>(n_samples / (2 * lines * (lines - 1)));
  }
  return wavy_grid(lines, steps);
}

}  // namespace batten::samples
