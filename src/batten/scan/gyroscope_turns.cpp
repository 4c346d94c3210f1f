#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/gyroscope_turns_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Readings of the gyroscope that are farther apart on the median, in seconds, miss how a hand turns between
/// them; a gap so much longer is not bridged.
constexpr double kLongestInterval = 0.1, kLongestBridge = 0.5;

/// Where the gyroscope has led the device since the first row.
struct Turned {
  Matrix3d frame = Matrix3d::Identity();
  double time = 0;
  int gaps = 0;
};

double usual_interval_of_gyroscope(const SensorLog& log) {
  std::vector<double> intervals;
  double last = std::numeric_limits<double>::quiet_NaN();
  for (Index i = 0; i < log.n_readings(); ++i) {
    if (!log.gyroscope.row(i).allFinite()) continue;
    if (log.time[i] > last) intervals.push_back(log.time[i] - last);
    last = log.time[i];
  }
  return intervals.empty() ? std::numeric_limits<double>::infinity() : upper_median(intervals);
}

/// Per row, the turns summed up (trapezoidal rule). Rows of other sensors lie in between, in proportion to
/// the time; of those in a silence nothing is known, so that each begins anew.
std::vector<Turned> summed_turns(const SensorLog& log, const Calibration& calibration) {
  const Matrix3d to_darboux = log.axes.matrix().transpose();
  const Index n = log.n_readings();
  std::vector<Turned> turned(static_cast<size_t>(n));
  const auto at = [&](Index row) -> Turned& { return turned[static_cast<size_t>(row)]; };
  for (Index i = 0; i < n; ++i) at(i).time = log.time[i];
  int gaps = 0;
  Matrix3d frame = Matrix3d::Identity();
  Index last = -1;  // row with a gyroscope
  for (Index i = 0; i <= n; ++i) {
    const bool end = i == n;
    if (!end && !log.gyroscope.row(i).allFinite()) continue;
    Vector3d turn = Vector3d::Zero();
    double dt = 0;
    bool known = !end && last >= 0;
    if (known) {
      dt = log.time[i] - log.time[last];
      const Vector3d rate =
          0.5 * (log.gyroscope.row(last) + log.gyroscope.row(i)).transpose() - calibration.gyroscope_bias;
      turn = dt * (to_darboux * rate);
      known = dt >= 0 && dt <= kLongestBridge && turn.norm() < 1;
    }
    for (Index row = last + 1; row < i; ++row) {
      at(row).gaps = known ? gaps : ++gaps;
      const double part = known && dt > 0 ? (log.time[row] - log.time[last]) / dt : 0;
      at(row).frame = frame * so3_exp(part * turn);
    }
    if (end) break;
    if (known)
      frame = frame * so3_exp(turn);
    else
      ++gaps;
    at(i).frame = frame;
    at(i).gaps = gaps;
    last = i;
  }
  return turned;
}

}  // namespace

void add_gyroscope_turns(const SensorLog& log, const Calibration& calibration,
                         const std::vector<std::vector<Index>>& rows, LogScan& scan) {
  if (!(usual_interval_of_gyroscope(log) <= kLongestInterval)) return;
  const std::vector<Turned> turned = summed_turns(log, calibration);
  const Turned* before = nullptr;
  for (size_t c = 0; c < rows.size(); ++c) {
    ScanCurve& curve = scan.scan.curves[c];
    const Index n = curve.n_readings();
    curve.turns.setConstant(n, 3, std::numeric_limits<double>::quiet_NaN());
    curve.turn_times.setConstant(n, std::numeric_limits<double>::quiet_NaN());
    for (Index i = 0; i < n; ++i) {
      const Turned& here = turned[static_cast<size_t>(rows[c][static_cast<size_t>(i)])];
      if (before != nullptr) {
        curve.turn_times[i] = here.time - before->time;
        if (here.gaps == before->gaps) curve.turns.row(i) = so3_log(before->frame.transpose() * here.frame);
      }
      before = &here;
    }
  }
}

}  // namespace batten
