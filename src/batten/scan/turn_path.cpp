#include <algorithm>
#include <limits>

#include "batten/rotation/so3.hpp"
#include "batten/scan/turn_path_detail.hpp"

namespace batten {

namespace {

/// Where the gyroscope has led the device at a place of a curve.
struct Place {
  Eigen::Matrix3d frame;
  double time;
  int gaps_before, gaps_after;  ///< at the readings around it
};

}  // namespace

TurnPath turn_path(const ScanCurve& curve) {
  TurnPath path;
  const Eigen::Index n = curve.n_readings();
  if (curve.turns.rows() != n || curve.turn_times.size() != n) return path;
  path.times.resize(n);
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  double time = 0;
  int gaps = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i > 0) {  // the first leads here from another curve
      const Eigen::Vector3d turn = curve.turns.row(i);
      if (turn.allFinite())
        turned = turned * so3_exp(turn);
      else
        ++gaps;
      time += curve.turn_times[i];
    }
    path.frames.push_back(turned);
    path.times[i] = time;
    path.gaps.push_back(gaps);
  }
  return path;
}

void set_turns(const ScanCurve& source, const CleanCurve& clean, SampledCurve& curve) {
  if (clean.turned.empty()) return;
  const int n = curve.n_samples(), n_readings = static_cast<int>(clean.frames.size());
  curve.turns.resize(n, 3);
  curve.turn_times.resize(n);
  curve.turns.row(0) = source.turns.row(0);
  curve.turn_times[0] = source.turn_times[0];
  int j = 0;
  const auto at = [&](double s) -> Place {
    while (j + 2 < n_readings && clean.distances[j + 1] <= s) ++j;
    const int next = std::min(j + 1, n_readings - 1);
    const double gap = clean.distances[next] - clean.distances[j];
    const double u = gap > 0 ? std::clamp((s - clean.distances[j]) / gap, 0.0, 1.0) : 0;
    const Eigen::Matrix3d &a = clean.turned.frames[j], &b = clean.turned.frames[next];
    return {a * so3_exp(u * so3_log(a.transpose() * b)),
            (1 - u) * clean.turned.times[j] + u * clean.turned.times[next],
            clean.turned.gaps[u < 1 ? j : next], clean.turned.gaps[u > 0 ? next : j]};
  };
  Place before = at(curve.parameters[0]);
  for (int k = 1; k < n; ++k) {
    const Place here = at(curve.parameters[k]);
    curve.turn_times[k] = here.time - before.time;
    if (here.gaps_after == before.gaps_before)
      curve.turns.row(k) = so3_log(before.frame.transpose() * here.frame);
    else
      curve.turns.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
    before = here;
  }
}

}  // namespace batten
