#include "batten/simulation/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// One stream of random numbers per effect.
enum Stream : std::uint64_t {
  kJitter = 1,
  kWhite,
  kDrift,
  kOdometer,
  kCurveLength,
  kOutlierChoice,
  kOutlierFrame,
  kDisturbance,
  kUnevenSpeed
};

struct Streams {
  explicit Streams(std::uint64_t seed)
      : jitter(seed, kJitter),
        white(seed, kWhite),
        drift(seed, kDrift),
        odometer(seed, kOdometer),
        curve_length(seed, kCurveLength),
        outlier_choice(seed, kOutlierChoice),
        outlier_frame(seed, kOutlierFrame),
        speed(seed, kUnevenSpeed) {}
  Random jitter, white, drift, odometer, curve_length, outlier_choice, outlier_frame, speed;
};

/// Uniform over all rotations: a normal vector of four numbers has no preferred direction.
Matrix3d random_rotation(Random& random) {
  const Vector3d v = random.normal3();
  return Eigen::Quaterniond(random.normal(), v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

/// Where the device takes its readings: true distances, and which of them are taken at nodes.
void place_readings(const TracedCurve& curve, double step, const SimulateOptions& options, Random& random,
                    std::vector<double>& distances, ScanCurve& scan_curve) {
  const double length = curve.path->length();
  std::vector<double> stations = curve.node_distances;
  std::vector<int> ids = curve.node_ids;
  constexpr int kNoNode = -1;
  if (stations.empty() || stations.front() > 1e-9 * length) {
    stations.insert(stations.begin(), 0.0);
    ids.insert(ids.begin(), kNoNode);
  }
  if (stations.back() < length * (1 - 1e-9)) {
    stations.push_back(length);
    ids.push_back(kNoNode);
  }
  for (size_t j = 0; j < stations.size(); ++j) {
    if (ids[j] != kNoNode) {
      scan_curve.node_readings.push_back(static_cast<int>(distances.size()));
      scan_curve.node_ids.push_back(ids[j]);
    }
    distances.insert(distances.end(), static_cast<size_t>(ids[j] == kNoNode ? 1 : options.dwell),
                     stations[j]);
    if (j + 1 == stations.size()) break;
    const double gap = stations[j + 1] - stations[j];
    const int pieces = std::max(1, static_cast<int>(std::lround(gap / step)));
    for (int k = 1; k < pieces; ++k) {
      const double shift = options.jitter * random.uniform(-1, 1);
      distances.push_back(stations[j] + gap * (k + shift) / pieces);
    }
  }
}

/// Raised cosine of height 1 at 0 that vanishes at ±1.
double bump(double x) {
  return std::abs(x) < 1 ? 0.5 * (1 + std::cos(kPi * x)) : 0.0;
}

/// What an uneven hand makes of distances that come from time stamps: the time to get so far along a curve,
/// scaled so that the whole takes as long as the curve is.
class HandTime {
 public:
  HandTime(double length, double variation, Random& random) : length_(length) {
    constexpr int kPieces = 1024;
    std::array<double, 3> heights{}, phases{};
    for (size_t k = 0; k < heights.size(); ++k) {
      heights[k] = random.normal();
      phases[k] = random.uniform(-kPi, kPi);
    }
    std::vector<double> speeds;
    double most = 0;
    for (int i = 0; i <= kPieces; ++i) {
      double speed = 0;
      for (size_t k = 0; k < heights.size(); ++k)
        speed += heights[k] *
                 std::cos(kPi * static_cast<double>((k + 1) * static_cast<size_t>(i)) / kPieces + phases[k]);
      speeds.push_back(speed);
      most = std::max(most, std::abs(speed));
    }
    const auto slowness = [&](int i) { return 1 / (1 + variation * speeds[static_cast<size_t>(i)] / most); };
    times_.push_back(0);
    for (int i = 0; i < kPieces; ++i) times_.push_back(times_.back() + slowness(i) + slowness(i + 1));
  }

  double at(double distance) const {
    const double pieces = static_cast<double>(times_.size() - 1);
    const double place = std::clamp(distance / length_, 0.0, 1.0) * pieces;
    const auto i = static_cast<size_t>(std::min(place, pieces - 1));
    const double u = place - static_cast<double>(i);
    return length_ * ((1 - u) * times_[i] + u * times_[i + 1]) / times_.back();
  }

 private:
  double length_;
  std::vector<double> times_;
};

/// A device that goes along the curves of an object one after the other.
class ScanningDevice {
 public:
  /// All must outlive this.
  ScanningDevice(const TracedNetwork& traced, const SimulateOptions& options)
      : traced_(traced),
        options_(options),
        step_(options.step * traced.diameter),
        correlation_length_(options.drift_length * traced.diameter),
        random_(options.seed) {
    if (options.disturbance == 0) return;
    Random choice(options.seed, kDisturbance);
    report_.disturbed_curve = static_cast<int>(choice.below(traced.curves.size()));
    const double length = traced.curves[static_cast<size_t>(report_.disturbed_curve)].path->length();
    const double half = options.disturbance_extent / 2;
    report_.disturbed_centre = length * choice.uniform(half, 1 - half);
  }

  SimulatedScan scan() {
    SimulatedScan result;
    for (size_t c = 0; c < traced_.curves.size(); ++c) add_curve(c, result);
    report_.rms_orientation_noise = std::sqrt(white_squares_ / (3.0 * static_cast<double>(n_readings_)));
    report_.rms_drift = std::sqrt(drift_squares_ / (3.0 * static_cast<double>(n_readings_)));
    result.report = std::move(report_);
    result.scan.tangents = TangentConvention::AtSample;
    return result;
  }

 private:
  void add_curve(size_t c, SimulatedScan& result) {
    const TracedCurve& curve = traced_.curves[c];
    ScanCurve out;
    out.name = curve.name;
    out.boundary = curve.boundary;
    out.closed = curve.closed;
    std::vector<double> distances;
    place_readings(curve, step_, options_, random_.jitter, distances, out);

    const double factor = (1 + options_.odometer_error * random_.odometer.normal()) *
                          (1 + options_.curve_length_error * random_.curve_length.uniform(-1, 1));
    if (!(factor > 0))
      throw InvalidInput("odometer_error is so large that a curve has no length; make it smaller");
    report_.distance_factors.push_back(factor);

    std::optional<HandTime> hand;
    if (options_.speed_variation > 0)
      hand.emplace(curve.path->length(), options_.speed_variation, random_.speed);
    const auto n = static_cast<Eigen::Index>(distances.size());
    out.distances.resize(n);
    out.tangents.resize(n, 3);
    out.normals.resize(n, 3);
    std::vector<Matrix3d> frames;
    drift_.setZero();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double s = distances[static_cast<size_t>(i)];
      const CurvePoint point = curve.path->at(s);
      frames.push_back(darboux_frame(point.tangent, point.normal));
      const double memory =
          i == 0 ? 0 : std::exp(-(s - distances[static_cast<size_t>(i) - 1]) / correlation_length_);
      const Matrix3d measured = reading(frames.back(), memory, disturbance(c, s));
      out.distances[i] = factor * (hand ? hand->at(s) : s);
      out.tangents.row(i) = measured.col(0);
      out.normals.row(i) = measured.col(1);
    }
    n_readings_ += n;
    result.true_distances.emplace_back(Eigen::Map<const Eigen::VectorXd>(distances.data(), n));
    result.true_frames.push_back(std::move(frames));
    result.scan.curves.push_back(std::move(out));
  }

  /// The turn of the heading at distance s of a curve, radians; nothing on curves that are not disturbed.
  std::optional<double> disturbance(size_t curve, double s) const {
    if (report_.disturbed_curve != static_cast<int>(curve)) return std::nullopt;
    const double half_width = options_.disturbance_extent * traced_.curves[curve].path->length() / 2;
    return options_.disturbance * bump((s - report_.disturbed_centre) / half_width);
  }

  /// What the device reads of a frame. The numbers are drawn whatever the amplitudes, so that every effect
  /// has the same course at any size. @param memory the share of the drift of the reading before that is
  /// left.
  Matrix3d reading(const Matrix3d& truth, double memory, const std::optional<double>& turn) {
    const Vector3d white = options_.orientation_noise * random_.white.normal3();
    const Vector3d fresh = random_.drift.normal3();
    drift_ = memory * drift_ + std::sqrt(1 - memory * memory) * options_.drift * fresh;
    white_squares_ += white.squaredNorm();
    drift_squares_ += drift_.squaredNorm();

    Matrix3d measured = truth;
    if (turn) measured = so3_exp({0, 0, *turn}) * measured;
    const Vector3d error = white + drift_;
    if (error.squaredNorm() > 0) measured = so3_exp(error) * measured;
    const Matrix3d anywhere = random_rotation(random_.outlier_frame);
    if (random_.outlier_choice.uniform() < options_.outliers) {
      measured = anywhere;
      ++report_.n_outliers;
    }
    return measured;
  }

  const TracedNetwork& traced_;
  const SimulateOptions& options_;
  double step_, correlation_length_;  ///< unit of the object
  Streams random_;
  SimulateReport report_;
  Vector3d drift_ = Vector3d::Zero();  ///< at the last reading
  double white_squares_ = 0, drift_squares_ = 0;
  long n_readings_ = 0;
};

}  // namespace

std::optional<std::string> SimulateOptions::problem() const {
  const auto outside = [](const char* name, double value, const char* range) {
    return concat(name, " must ", range, ", got ", value);
  };
  if (!(step > 0 && step <= 1)) return outside("step", step, "lie in (0, 1] diameters");
  if (!(jitter >= 0 && jitter < 0.5)) return outside("jitter", jitter, "lie in [0, 0.5) steps");
  if (dwell < 1) return outside("dwell", dwell, "be at least 1 reading");
  if (!(orientation_noise >= 0 && orientation_noise <= kPi))
    return outside("orientation_noise", orientation_noise, "lie in [0, pi] radians");
  if (!(drift >= 0 && drift <= kPi)) return outside("drift", drift, "lie in [0, pi] radians");
  if (!(drift_length > 0)) return outside("drift_length", drift_length, "be above 0 diameters");
  if (!(odometer_error >= 0 && odometer_error <= 0.2))
    return outside("odometer_error", odometer_error, "lie in [0, 0.2]");
  if (!(curve_length_error >= 0 && curve_length_error < 1))
    return outside("curve_length_error", curve_length_error, "lie in [0, 1)");
  if (!(speed_variation >= 0 && speed_variation <= 0.9))
    return outside("speed_variation", speed_variation, "lie in [0, 0.9]");
  if (!(outliers >= 0 && outliers <= 1)) return outside("outliers", outliers, "lie in [0, 1]");
  if (!(std::abs(disturbance) <= kPi)) return outside("disturbance", disturbance, "lie in [-pi, pi] radians");
  if (!(disturbance_extent > 0 && disturbance_extent <= 1))
    return outside("disturbance_extent", disturbance_extent, "lie in (0, 1]");
  return std::nullopt;
}

SimulatedScan simulate_scan(const TracedNetwork& traced, const SimulateOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (traced.curves.empty()) throw InvalidInput("the object to be scanned has no curves");
  double length = 0;
  for (const TracedCurve& curve : traced.curves) length += curve.path->length();
  constexpr double kMostReadings = 1e8;
  if (const double n = length / (options.step * traced.diameter); n > kMostReadings)
    throw InvalidInput(
        concat("the step gives about ", n, " readings, more than ", kMostReadings, "; use a longer one"));
  return ScanningDevice(traced, options).scan();
}

}  // namespace batten
