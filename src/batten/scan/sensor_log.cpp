#include "batten/scan/sensor_log.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/gyroscope_turns_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
// A device that turns farther than this between two rows has lost count (radians).
constexpr double kLargestTurn = kPi;

bool complete(const SensorLog& log, Eigen::Index row) {
  return log.accelerometer.row(row).allFinite() && log.magnetometer.row(row).allFinite();
}

std::string curve_words(const LogCurve& curve) {
  return curve.name.empty() ? concat("curve ", curve.number)
                            : concat("curve ", curve.number, " '", curve.name, "'");
}

/// The inclination that the readings show: the field dips below the horizon by the angle between both vectors
/// less 90 degrees. The median does not mind disturbances on less than half of the readings.
double estimate_inclination(const SensorLog& log, const Calibration& calibration) {
  std::vector<double> cosines;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    if (log.curve[static_cast<size_t>(i)] == SensorLog::kNone || !complete(log, i)) continue;
    const Vector3d up = calibration.accelerometer.apply(log.accelerometer.row(i)).normalized();
    const Vector3d field = calibration.magnetometer.apply(log.magnetometer.row(i)).normalized();
    cosines.push_back(up.dot(field));
  }
  const auto middle = cosines.begin() + static_cast<std::ptrdiff_t>(cosines.size() / 2);
  std::nth_element(cosines.begin(), middle, cosines.end());
  return std::asin(std::clamp(-*middle, -1.0, 1.0));
}

/// Turns the rows of one curve into readings.
class CurveBuilder {
 public:
  CurveBuilder(const SensorLog& log, const LogScanOptions& options, double inclination, bool use_times)
      : log_(log),
        options_(options),
        to_device_(log.axes.matrix()),
        up_(0, 0, 1),
        field_(std::cos(inclination), 0, -std::sin(inclination)),
        use_times_(use_times) {}

  /// @param rows of the curve, in order.
  /// @param turns see LogScan::gyroscope_turns.
  /// @param n_skipped counts the rows without both vectors.
  ScanCurve build(const LogCurve& source, const std::vector<Eigen::Index>& rows, Points& turns,
                  long& n_skipped) {
    ScanCurve curve;
    curve.name = source.name;
    curve.boundary = source.boundary;
    curve.sharp = source.sharp;
    curve.closed = source.closed;
    const auto n = static_cast<Eigen::Index>(rows.size());
    curve.distances.resize(n);
    curve.tangents.resize(n, 3);
    curve.normals.resize(n, 3);
    turns.resize(n, 3);
    Eigen::Index kept = 0;
    Matrix3d turned = Matrix3d::Identity();  // by the gyroscope since the reading kept last
    bool turn_known = true;
    double moving_time = 0;
    int pending_node = SensorLog::kNone;  // of a stay at a node without a complete reading so far
    int current_node = SensorLog::kNone;
    for (size_t k = 0; k < rows.size(); ++k) {
      const Eigen::Index row = rows[k];
      if (k > 0) turn_known = integrate_gyroscope(rows[k - 1], row, turned) && turn_known;
      const int node = log_.node[static_cast<size_t>(row)];
      // While the device rests at a node, time passes but no distance.
      if (k > 0 && (node == SensorLog::kNone || node != current_node))
        moving_time += log_.time[row] - log_.time[rows[k - 1]];
      if (node != current_node) {
        if (pending_node != SensorLog::kNone) fail_node(source, pending_node);
        current_node = pending_node = node;
      }
      if (!complete(log_, row)) {
        // Rows of the gyroscope alone lack nothing.
        if (log_.accelerometer.row(row).allFinite() || log_.magnetometer.row(row).allFinite() ||
            !log_.gyroscope.row(row).allFinite())
          ++n_skipped;
        continue;
      }
      const Matrix3d X = orientation(source, row);
      curve.distances[kept] = use_times_ ? moving_time : log_.distance[row];
      curve.tangents.row(kept) = X.col(0);
      curve.normals.row(kept) = X.col(1);
      if (kept == 0 || !turn_known)
        turns.row(kept).setConstant(kMissing);
      else
        turns.row(kept) = so3_log(turned);
      turned.setIdentity();
      turn_known = true;
      if (pending_node != SensorLog::kNone) {
        curve.node_readings.push_back(static_cast<int>(kept));
        curve.node_ids.push_back(pending_node);
        pending_node = SensorLog::kNone;
      }
      ++kept;
    }
    if (pending_node != SensorLog::kNone) fail_node(source, pending_node);
    curve.distances.conservativeResize(kept);
    curve.tangents.conservativeResize(kept, 3);
    curve.normals.conservativeResize(kept, 3);
    turns.conservativeResize(kept, 3);
    return curve;
  }

 private:
  Matrix3d orientation(const LogCurve& source, Eigen::Index row) const {
    const Matrix3d to_darboux = to_device_.transpose();
    const Vector3d up = options_.calibration.accelerometer.apply(log_.accelerometer.row(row));
    const Vector3d field = options_.calibration.magnetometer.apply(log_.magnetometer.row(row));
    try {
      return solve_wahba({{up_, to_darboux * up, options_.accelerometer_weight},
                          {field_, to_darboux * field, options_.magnetometer_weight}},
                         options_.method);
    } catch (const InvalidInput& error) {
      throw InvalidInput(concat(curve_words(source), ", row ", row + 1, ": ", error.what()));
    }
  }

  /// Appends the turn between two rows (trapezoidal rule). False where the gyroscope is missing.
  bool integrate_gyroscope(Eigen::Index from, Eigen::Index to, Matrix3d& turned) const {
    const Vector3d before = log_.gyroscope.row(from);
    const Vector3d after = log_.gyroscope.row(to);
    const Vector3d rate = 0.5 * (before + after) - options_.calibration.gyroscope_bias;
    const Vector3d turn = to_device_.transpose() * rate * (log_.time[to] - log_.time[from]);
    if (!turn.allFinite() || turn.norm() > kLargestTurn) return false;
    turned *= so3_exp(turn);
    return true;
  }

  [[noreturn]] static void fail_node(const LogCurve& source, int node) {
    throw InvalidInput(concat(curve_words(source), ": no reading at node ", node,
                              " has both accelerometer and magnetometer; record the curve again"));
  }

  const SensorLog& log_;
  const LogScanOptions& options_;
  Matrix3d to_device_;
  Vector3d up_, field_;
  bool use_times_;
};

void check_log(const SensorLog& log) {
  const Eigen::Index n = log.n_readings();
  const auto rows = static_cast<size_t>(n);
  if (log.curve.size() != rows || log.node.size() != rows || log.distance.size() != n ||
      log.accelerometer.rows() != n || log.magnetometer.rows() != n || log.gyroscope.rows() != n)
    throw InvalidInput("the columns of the sensor log differ in length");
  if (log.curves.empty()) throw InvalidInput("the sensor log names no curve; fill its column 'curve'");
  if (log.accelerometer.array().isNaN().all())
    throw InvalidInput("the sensor log has no accelerometer readings; orientations need them");
  if (log.magnetometer.array().isNaN().all())
    throw InvalidInput("the sensor log has no magnetometer readings; without them the heading is unknown");
}

}  // namespace

Matrix3d DeviceAxes::matrix() const {
  Matrix3d m;
  m << forward, normal, forward.cross(normal);
  return m;
}

void SensorLog::resize(Eigen::Index n) {
  const Eigen::Index before = n_readings();
  const auto grow = [&](auto& column, Eigen::Index columns) {
    column.conservativeResize(n, columns);
    if (n > before) column.bottomRows(n - before).setConstant(kMissing);
  };
  grow(time, 1);
  grow(distance, 1);
  grow(accelerometer, 3);
  grow(magnetometer, 3);
  grow(gyroscope, 3);
  curve.resize(static_cast<size_t>(n), kNone);
  node.resize(static_cast<size_t>(n), kNone);
}

std::optional<std::string> LogScanOptions::problem() const {
  for (const SensorCalibration* sensor : {&calibration.accelerometer, &calibration.magnetometer})
    if (!sensor->offset.allFinite() || !sensor->matrix.allFinite() || sensor->matrix.determinant() == 0)
      return std::string(
          "calibration must have finite offsets and matrices that can be inverted; calibrate the device "
          "again");
  if (inclination && !(std::abs(*inclination) < kPi / 2))
    return concat("inclination must lie between -90 and 90 degrees, got ", degrees(*inclination));
  if (!(accelerometer_weight > 0) || !std::isfinite(accelerometer_weight))
    return concat("accelerometer_weight must be > 0, got ", accelerometer_weight);
  if (!(magnetometer_weight > 0) || !std::isfinite(magnetometer_weight))
    return concat("magnetometer_weight must be > 0, got ", magnetometer_weight);
  return std::nullopt;
}

LogScan scan_from_log(const SensorLog& log, const LogScanOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  check_log(log);
  LogScan result;
  std::vector<std::vector<Eigen::Index>> rows(log.curves.size());
  long n_on_curves = 0;
  long n_without_distance = 0;
  bool any_complete = false;
  for (Eigen::Index i = 0; i < log.n_readings(); ++i) {
    const int c = log.curve[static_cast<size_t>(i)];
    if (c == SensorLog::kNone) continue;
    if (c < 0 || static_cast<size_t>(c) >= log.curves.size())
      throw InvalidInput(concat("row ", i + 1, " of the sensor log names a curve that does not exist"));
    rows[static_cast<size_t>(c)].push_back(i);
    ++n_on_curves;
    if (std::isnan(log.distance[i])) ++n_without_distance;
    any_complete = any_complete || complete(log, i);
  }
  if (!any_complete)
    throw InvalidInput(
        "no row of the sensor log has both accelerometer and magnetometer on a curve; record both in one "
        "row");
  if (n_without_distance > 0 && n_without_distance < n_on_curves)
    throw InvalidInput(concat(n_without_distance, " of ", n_on_curves,
                              " readings on curves have no distance; fill the column, or leave it empty "
                              "everywhere to take times instead"));
  result.times_for_distances = n_without_distance > 0;
  if (result.times_for_distances)
    result.warnings.emplace_back(
        "the log has no distances; seconds stand in for them, so use --lengths estimated");
  result.inclination_estimated = !options.inclination.has_value();
  result.inclination =
      options.inclination ? *options.inclination : estimate_inclination(log, options.calibration);

  long n_skipped = 0;
  CurveBuilder builder(log, options, result.inclination, result.times_for_distances);
  for (size_t c = 0; c < log.curves.size(); ++c) {
    Points turns;
    result.scan.curves.push_back(builder.build(log.curves[c], rows[c], turns, n_skipped));
    result.gyroscope_turns.push_back(std::move(turns));
    std::vector<Eigen::Index>& kept = rows[c];
    kept.erase(
        std::remove_if(kept.begin(), kept.end(), [&](Eigen::Index row) { return !complete(log, row); }),
        kept.end());
  }
  if (n_skipped > 0)
    result.warnings.push_back(concat(n_skipped, " of ", n_on_curves,
                                     " readings lack accelerometer or magnetometer and are left out"));
  result.scan.tangents = TangentConvention::AtSample;
  result.scan.unit = std::string(1, result.times_for_distances ? 's' : 'm');
  check_scan(result.scan);
  add_gyroscope_turns(log, options.calibration, rows, result);
  return result;
}

}  // namespace batten
