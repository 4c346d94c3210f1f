#include "batten/scan/calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Nine unknowns, and the median needs some more to be robust.
constexpr Eigen::Index kFewestReadings = 30;
// Tukey's constant: 95 % efficient for normal errors.
constexpr double kTukey = 4.685;
// Lengths never agree better than this (relative): sensors have 16 bits.
constexpr double kSmallestScale = 1e-9;
// No gyroscope's zero is farther off (rad/s); a steady turn is faster.
constexpr double kLargestBias = 0.1;
// Readings in a window that is looked at for rest.
constexpr Eigen::Index kRestWindow = 20;
// Below this the unknowns of the fit are not told apart by the readings (smallest to largest eigenvalue of
// the normal matrix, scaled to a unit diagonal).
constexpr double kSmallestDeterminacy = 1e-6;

Points finite_rows(const Points& all) {
  Points kept(all.rows(), 3);
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < all.rows(); ++i)
    if (all.row(i).allFinite()) kept.row(n++) = all.row(i);
  kept.conservativeResize(n, 3);
  return kept;
}

/// Twelve corners and twenty face centres of an icosahedron: directions at most 37.4° apart from the nearest.
std::vector<Vector3d> spread_directions() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vector3d> directions;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-golden, golden}) {
      directions.emplace_back(0, a, b);
      directions.emplace_back(a, b, 0);
      directions.emplace_back(b, 0, a);
    }
  for (const double a : {-1.0, 1.0})
    for (const double b : {-1.0, 1.0}) {
      for (const double c : {-1.0, 1.0}) directions.emplace_back(a, b, c);
      directions.emplace_back(0, a / golden, b * golden);
      directions.emplace_back(a / golden, b * golden, 0);
      directions.emplace_back(b * golden, 0, a / golden);
    }
  for (Vector3d& d : directions) d.normalize();
  return directions;
}

/// A device axis nearest to a direction, as people call it: "+x".
std::string axis_in_words(const Vector3d& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return concat(direction[axis] < 0 ? "-" : "+", "xyz"[axis]);
}

struct Coverage {
  double share = 0;
  std::string missing;  ///< the device axes nearest to the directions without a reading
};

Coverage coverage_of(const std::vector<Vector3d>& unit_readings) {
  static const double kNear = std::cos(radians(20));
  const std::vector<Vector3d> directions = spread_directions();
  Coverage coverage;
  std::array<int, 6> missing{};  // +x −x +y −y +z −z
  for (const Vector3d& d : directions) {
    const bool met = std::any_of(unit_readings.begin(), unit_readings.end(),
                                 [&d](const Vector3d& u) { return u.dot(d) > kNear; });
    if (met) {
      coverage.share += 1.0 / static_cast<double>(directions.size());
      continue;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      const double along = d[static_cast<Eigen::Index>(axis)];
      if (along > 0.7) ++missing[2 * axis];
      if (along < -0.7) ++missing[2 * axis + 1];
    }
  }
  for (size_t k = 0; k < missing.size(); ++k)
    if (missing[k] > 0)
      coverage.missing += concat(coverage.missing.empty() ? "" : ", ", "+-"[k % 2], "xyz"[k / 2]);
  if (coverage.missing.empty()) coverage.missing = "between the axes";
  return coverage;
}

/// Symmetric matrix from its six entries xx, yy, zz, xy, xz, yz.
Matrix3d symmetric(const Vector9d& p) {
  Matrix3d m;
  m << p[0], p[3], p[4], p[3], p[1], p[5], p[4], p[5], p[2];
  return m;
}

/// d(M d)/d(entries): the derivative of M d by the six entries, 3 × 6.
Eigen::Matrix<double, 3, 6> entries_jacobian(const Vector3d& d) {
  Eigen::Matrix<double, 3, 6> j;
  j << d.x(), 0, 0, d.y(), d.z(), 0,  //
      0, d.y(), 0, d.x(), 0, d.z(),   //
      0, 0, d.z(), 0, d.x(), d.y();
  return j;
}

/// Sphere through the readings by linear least squares, then again without the farthest tenth: a start that a
/// few outliers cannot carry away.
void fit_sphere(const Points& x, Vector3d& centre, double& radius) {
  std::vector<Eigen::Index> used(static_cast<size_t>(x.rows()));
  for (size_t i = 0; i < used.size(); ++i) used[i] = static_cast<Eigen::Index>(i);
  for (int round = 0; round < 4; ++round) {
    Eigen::MatrixXd a(static_cast<Eigen::Index>(used.size()), 4);
    Eigen::VectorXd b(a.rows());
    for (Eigen::Index r = 0; r < a.rows(); ++r) {
      const Vector3d p = x.row(used[static_cast<size_t>(r)]);
      a.row(r) << 2 * p.transpose(), 1;
      b[r] = p.squaredNorm();
    }
    const Eigen::Vector4d solution = Eigen::MatrixXd(a.transpose() * a).ldlt().solve(a.transpose() * b);
    centre = solution.head<3>();
    radius = std::sqrt(std::max(0.0, solution[3] + centre.squaredNorm()));
    std::vector<std::pair<double, Eigen::Index>> misfits;
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      misfits.emplace_back(std::abs((x.row(i).transpose() - centre).norm() - radius), i);
    std::sort(misfits.begin(), misfits.end());
    used.clear();
    for (size_t k = 0; k < misfits.size() * 9 / 10; ++k) used.push_back(misfits[k].second);
  }
}

/// The zero of the gyroscope: its mean over the windows in which it is as quiet as it ever gets, give or
/// take, and slow. Windows of a turn that starts or stops are not quiet.
void find_gyroscope_bias(const Points& gyroscope, DeviceCalibration& device) {
  struct Window {
    double variance;
    Vector3d mean;
  };
  std::vector<Window> windows;
  for (Eigen::Index i = 0; i + kRestWindow <= gyroscope.rows(); i += kRestWindow / 4) {
    const auto rows = gyroscope.middleRows(i, kRestWindow);
    if (!rows.allFinite()) continue;
    const Eigen::RowVector3d mean = rows.colwise().mean();
    if (mean.norm() > kLargestBias) continue;
    windows.push_back({(rows.rowwise() - mean).squaredNorm(), mean.transpose()});
  }
  if (windows.empty()) return;
  const auto quietest = std::min_element(
      windows.begin(), windows.end(), [](const auto& a, const auto& b) { return a.variance < b.variance; });
  Vector3d sum = Vector3d::Zero();
  long n = 0;
  for (const Window& window : windows) {
    if (window.variance > 2 * quietest->variance) continue;
    sum += window.mean;
    ++n;
  }
  device.calibration.gyroscope_bias = sum / static_cast<double>(n);
  device.gyroscope_windows = n;
}

/// The robust least squares fit of |M (x − o)| = 1 by damped Gauss–Newton steps with Tukey's weights, whose
/// scale follows the residuals.
class RobustEllipsoid {
 public:
  /// @param x must outlive this; centre and radius of a sphere to start from.
  RobustEllipsoid(const Points& x, const Vector3d& centre, double radius)
      : x_(x), residuals_(static_cast<size_t>(x.rows())) {
    p_.head<3>().setConstant(1 / radius);
    p_.tail<3>() = centre;
  }

  /// Returns the number of steps.
  int run(int max_iterations) {
    evaluate(p_);
    deviation_ = robust_scale();
    double damping = 1e-3;
    int iteration = 0;
    while (iteration < max_iterations) {
      ++iteration;
      const Vector9d gradient = linearise();
      const double before = cost();
      Vector9d step = Vector9d::Zero();
      bool improved = false;
      for (int attempt = 0; attempt < 30 && !improved; ++attempt) {
        Eigen::MatrixXd damped = normal_matrix_;
        damped.diagonal() +=
            damping * (normal_matrix_.diagonal().array() + 1e-12 * normal_matrix_.trace()).matrix();
        step = -damped.ldlt().solve(gradient);
        evaluate(p_ + step);
        improved = step.allFinite() && cost() <= before;
        damping = improved ? std::max(1e-12, damping / 10) : damping * 10;
      }
      if (!improved) {
        evaluate(p_);
        break;
      }
      p_ += step;
      const double fresh = robust_scale();
      const bool settled = std::abs(fresh - deviation_) < 1e-6 * deviation_ || fresh <= kSmallestScale;
      deviation_ = fresh;
      if (settled && step.norm() < 1e-12) break;
    }
    return iteration;
  }

  const Vector9d& unknowns() const { return p_; }
  Matrix3d matrix() const { return symmetric(p_); }
  Vector3d offset() const { return p_.tail<3>(); }
  /// Of the last step taken, close enough to the optimum.
  const Matrix9d& normal_matrix() const { return normal_matrix_; }
  double residual(Eigen::Index i) const { return residuals_[static_cast<size_t>(i)]; }
  bool is_outlier(Eigen::Index i) const { return weight(residual(i)) == 0; }

 private:
  void evaluate(const Vector9d& q) {
    const Matrix3d m = symmetric(q);
    for (Eigen::Index i = 0; i < x_.rows(); ++i)
      residuals_[static_cast<size_t>(i)] = (m * (x_.row(i).transpose() - q.tail<3>())).norm() - 1;
  }
  double robust_scale() const {
    std::vector<double> reordered = residuals_;
    return std::max(kSmallestScale, deviation_by_median(reordered, 0));
  }
  double weight(double r) const {
    const double u = r / (kTukey * deviation_);
    return std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0.0;
  }
  /// Tukey's rho, without its constant factor.
  double cost() const {
    double sum = 0;
    for (const double r : residuals_) {
      const double u = std::min(1.0, std::abs(r) / (kTukey * deviation_));
      const double v = 1 - u * u;
      sum += 1 - v * v * v;
    }
    return sum;
  }
  /// Sets the normal matrix; returns the gradient.
  Vector9d linearise() {
    const Matrix3d m = symmetric(p_);
    normal_matrix_.setZero();
    Vector9d gradient = Vector9d::Zero();
    for (Eigen::Index i = 0; i < x_.rows(); ++i) {
      const double w = weight(residual(i));
      if (w == 0) continue;
      const Vector3d d = x_.row(i).transpose() - p_.tail<3>();
      const Vector3d y = m * d;
      const Vector3d direction = y / std::max(y.norm(), 1e-12);
      Vector9d j;
      j.head<6>() = entries_jacobian(d).transpose() * direction;
      j.tail<3>() = -(m.transpose() * direction);
      normal_matrix_ += w * j * j.transpose();
      gradient += w * residual(i) * j;
    }
    return gradient;
  }

  // Every solver here is of dynamic size: those of sizes 3, 4 and 9 took a minute to compile.
  const Points& x_;
  Vector9d p_ = Vector9d::Zero();  ///< six entries of M, then o
  std::vector<double> residuals_;
  double deviation_ = 0;
  Matrix9d normal_matrix_ = Matrix9d::Zero();
};

/// Share of the directions that the readings cover. @throws InvalidInput where they are too few.
double checked_coverage(const std::vector<Vector3d>& directions, double smallest) {
  const Coverage coverage = coverage_of(directions);
  if (coverage.share < smallest)
    throw InvalidInput(concat("the readings cover only ", std::lround(100 * coverage.share),
                              " % of all directions; turn the device so that the field also comes from ",
                              coverage.missing));
  return coverage.share;
}

/// The largest standard deviation of the offset along any axis.
/// @param variance of one residual.
/// @throws InvalidInput where the readings leave a combination of the unknowns open, and where the offset is
/// known worse than `largest` · strength.
double checked_uncertainty(const Matrix9d& normal_matrix, double variance, double strength, double largest) {
  const Vector9d diagonal = normal_matrix.diagonal().cwiseSqrt().cwiseMax(1e-150);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> determinacy(
      diagonal.cwiseInverse().asDiagonal() * normal_matrix * diagonal.cwiseInverse().asDiagonal());
  if (!(determinacy.eigenvalues()[0] > kSmallestDeterminacy * determinacy.eigenvalues()[8]))
    throw InvalidInput(
        "many ellipsoids fit the readings alike: the device was turned about one axis only; turn it over all "
        "sides");
  const Eigen::MatrixXd spread_axes = diagonal.cwiseInverse().asDiagonal() * determinacy.eigenvectors();
  const Matrix9d covariance = variance * spread_axes * determinacy.eigenvalues().cwiseInverse().asDiagonal() *
                              spread_axes.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> offset_spread(covariance.bottomRightCorner<3, 3>());
  const double uncertainty = std::sqrt(std::max(0.0, offset_spread.eigenvalues()[2])) / strength;
  if (uncertainty > largest)
    throw InvalidInput(concat("the zero of the sensor along ",
                              axis_in_words(offset_spread.eigenvectors().col(2)), " is known only to ",
                              100 * uncertainty,
                              " % of the field; record longer, and turn the device over all sides slowly"));
  return uncertainty;
}

}  // namespace

std::optional<std::string> EllipsoidFitOptions::problem() const {
  if (!(smallest_coverage >= 0 && smallest_coverage <= 1))
    return concat("smallest_coverage must be in [0, 1], got ", smallest_coverage);
  if (!(largest_uncertainty > 0)) return concat("largest_uncertainty must be > 0, got ", largest_uncertainty);
  if (max_iterations < 1) return concat("max_iterations must be at least 1, got ", max_iterations);
  return std::nullopt;
}

SensorCalibration fit_ellipsoid(const Points& readings, EllipsoidFitReport& report,
                                const EllipsoidFitOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const Points raw = finite_rows(readings);
  const Eigen::Index n = raw.rows();
  report = {};
  report.readings = n;
  if (n < kFewestReadings)
    throw InvalidInput(concat("only ", n, " readings, at least ", kFewestReadings,
                              " are needed; record some seconds while turning the device over all sides"));
  const Eigen::VectorXd raw_lengths = raw.rowwise().norm();
  // Everything below is relative to the size of the readings.
  const double scale = raw_lengths.mean();
  if (!(scale > 0)) throw InvalidInput("all readings are zero; is the sensor switched on?");
  const Points x = raw / scale;
  Vector3d centre;
  double radius = 0;
  fit_sphere(x, centre, radius);
  const double spread = std::sqrt((x.rowwise() - x.colwise().mean()).squaredNorm() / static_cast<double>(n));
  if (!(spread > 1e-6) || !(radius > 0.1 * spread) || radius > 100)
    throw InvalidInput("the readings hardly change; turn the device over all sides while recording");

  RobustEllipsoid fit(x, centre, radius);
  report.iterations = fit.run(options.max_iterations);
  const Matrix3d m = fit.matrix();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(m);
  if (!fit.unknowns().allFinite() || !(axes.eigenvalues()[0] > 0) ||
      axes.eigenvalues()[2] > 20 * axes.eigenvalues()[0])
    throw InvalidInput(
        "no ellipsoid fits the readings; turn the device over all sides, slowly and away from iron");
  SensorCalibration calibration;
  calibration.offset = scale * fit.offset();
  const double strength = 1 / std::cbrt(m.determinant());  // M · strength has determinant 1
  calibration.matrix = strength * m;
  report.radius = scale * strength;

  double squares = 0;
  std::vector<Vector3d> directions;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (fit.is_outlier(i)) {
      ++report.outliers;
      continue;
    }
    squares += fit.residual(i) * fit.residual(i);
    directions.push_back((m * (x.row(i).transpose() - fit.offset())).normalized());
  }
  const auto kept = static_cast<double>(directions.size());
  report.rms_residual = std::sqrt(squares / std::max(1.0, kept));
  report.rms_before = std::sqrt((raw_lengths.array() - scale).square().mean()) / scale;
  report.coverage = checked_coverage(directions, options.smallest_coverage);
  report.uncertainty = checked_uncertainty(fit.normal_matrix(), squares / std::max(1.0, kept - 9), strength,
                                           options.largest_uncertainty);
  return calibration;
}

double align_magnetometer(const Points& accelerometer, const Points& magnetometer, Calibration& calibration) {
  std::vector<std::pair<Vector3d, Vector3d>> pairs;
  for (Eigen::Index i = 0; i < std::min(accelerometer.rows(), magnetometer.rows()); ++i) {
    if (!accelerometer.row(i).allFinite() || !magnetometer.row(i).allFinite()) continue;
    pairs.emplace_back(calibration.accelerometer.apply(accelerometer.row(i)).normalized(),
                       calibration.magnetometer.apply(magnetometer.row(i)).normalized());
  }
  if (pairs.size() < static_cast<size_t>(kFewestReadings)) return 0;
  // a · R m = c for all readings. With R = exp(θ) R₀: a·(R₀m) + θ·(R₀m × a) = c, linear in θ and c.
  Matrix3d R = Matrix3d::Identity();
  double deviation = 1;
  for (int iteration = 0; iteration < 30; ++iteration) {
    std::vector<double> angles;
    angles.reserve(pairs.size());
    for (const auto& [a, m] : pairs) angles.push_back(a.dot(R * m));
    std::vector<double> reordered = angles;
    const double middle = upper_median(reordered);
    deviation = std::max(kSmallestScale, deviation_by_median(reordered, middle));
    Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (size_t i = 0; i < pairs.size(); ++i) {
      const double u = (angles[i] - middle) / (kTukey * deviation);
      if (std::abs(u) >= 1) continue;
      const double w = (1 - u * u) * (1 - u * u);
      Eigen::Vector4d j;
      j << (R * pairs[i].second).cross(pairs[i].first), -1;
      normal_matrix += w * j * j.transpose();
      right -= w * (angles[i] - middle) * j;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal_matrix);
    // Undetermined where the readings turn about one axis only.
    if (!(eigen.eigenvalues()[0] > 1e-3 * eigen.eigenvalues()[3])) return 0;
    const Vector3d step = Eigen::MatrixXd(normal_matrix).ldlt().solve(right).head<3>();
    if (!step.allFinite()) return 0;
    R = so3_exp(step) * R;
    if (step.norm() < 1e-13) break;
  }
  const double angle = so3_log(R).norm();
  // Sensors on one chip differ by a few degrees; a large angle means that the recording does not fit.
  if (angle > radians(20)) return 0;
  calibration.magnetometer.matrix = R * calibration.magnetometer.matrix;
  return angle;
}

DeviceCalibration calibrate_device(const SensorLog& tumble, const EllipsoidFitOptions& options) {
  DeviceCalibration device;
  const auto fit = [&](const char* sensor, const Points& readings, EllipsoidFitReport& report) {
    try {
      return fit_ellipsoid(readings, report, options);
    } catch (const InvalidInput& error) {
      throw InvalidInput(concat(sensor, ": ", error.what()));
    }
  };
  device.calibration.accelerometer = fit("accelerometer", tumble.accelerometer, device.accelerometer);
  device.calibration.magnetometer = fit("magnetometer", tumble.magnetometer, device.magnetometer);
  device.alignment = align_magnetometer(tumble.accelerometer, tumble.magnetometer, device.calibration);

  std::vector<double> cosines;
  for (Eigen::Index i = 0; i < tumble.n_readings(); ++i) {
    if (!tumble.accelerometer.row(i).allFinite() || !tumble.magnetometer.row(i).allFinite()) continue;
    const Vector3d up = device.calibration.accelerometer.apply(tumble.accelerometer.row(i)).normalized();
    const Vector3d field = device.calibration.magnetometer.apply(tumble.magnetometer.row(i)).normalized();
    cosines.push_back(up.dot(field));
  }
  if (!cosines.empty()) device.inclination = std::asin(std::clamp(-upper_median(cosines), -1.0, 1.0));

  find_gyroscope_bias(tumble.gyroscope, device);

  for (const auto& [sensor, report] :
       {std::pair<const char*, const EllipsoidFitReport&>{"accelerometer", device.accelerometer},
        {"magnetometer", device.magnetometer}}) {
    if (report.coverage < 0.75)
      device.warnings.push_back(
          concat(sensor, ": the readings cover ", std::lround(100 * report.coverage),
                 " % of all directions; turn the device over all sides for a better fit"));
    if (report.rms_residual > 0.05)
      device.warnings.push_back(concat(sensor, ": the calibrated readings still differ by ",
                                       std::lround(100 * report.rms_residual),
                                       " % in length; turn more slowly, and away from iron"));
  }
  return device;
}

}  // namespace batten
