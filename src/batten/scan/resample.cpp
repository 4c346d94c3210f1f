#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/average.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/turn_path_detail.hpp"

namespace batten {

namespace {

/// Samples of a chunk, of some 10 µs each.
constexpr Eigen::Index kSampleGrain = 100;

double turn_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  return so3_log(A.transpose() * B).norm();
}

/// Readings that carry weight, over one period more on both sides of a closed curve.
struct Window {
  std::vector<double> distances, counts;
  std::vector<Eigen::Matrix3d> frames;
};

Window window_of(const CleanCurve& curve, bool wrap) {
  Window window;
  const int n = static_cast<int>(curve.frames.size());
  const double length = curve.distances[n - 1];
  for (int period = wrap ? -1 : 0; period <= (wrap ? 1 : 0); ++period) {
    for (int i = 0; i < n; ++i) {
      if (curve.counts[i] == 0) continue;
      // First and last reading of a closed curve lie at one place: shifted copies meet there, which is right.
      window.distances.push_back(curve.distances[i] + period * length);
      window.counts.push_back(curve.counts[i]);
      window.frames.push_back(curve.frames[i]);
    }
  }
  return window;
}

/// The frame at t, fitted to the readings around it.
/// @param lag gets SampledCurve::lag of the fit: what a straight line makes of a parabola.
Eigen::Matrix3d frame_at(const Window& window, double t, double radius, bool local_linear,
                         double* lag = nullptr) {
  constexpr double kReach = 4;  // beyond four radii a Gaussian weight is below 4e-4
  const std::vector<double>& d = window.distances;
  const int n = static_cast<int>(d.size());
  const int after = static_cast<int>(std::lower_bound(d.begin(), d.end(), t) - d.begin());
  // Fewer readings than samples: widen the window so that the readings on both sides count.
  double gap;
  if (after == 0) {
    gap = n > 1 ? d[1] - t : 0;
  } else if (after == n) {
    gap = n > 1 ? t - d[n - 2] : 0;
  } else {
    gap = d[after] - d[after - 1];
    if (d[after] == t && after + 1 < n) gap = std::max(gap, d[after + 1] - t);
  }
  radius = std::max(radius, 0.5 * gap);
  const int begin = static_cast<int>(std::lower_bound(d.begin(), d.end(), t - kReach * radius) - d.begin());
  const int end = static_cast<int>(std::upper_bound(d.begin(), d.end(), t + kReach * radius) - d.begin());
  int nearest = std::clamp(after, begin, std::max(begin, end - 1));
  if (nearest > begin && nearest < n && t - d[nearest - 1] < d[nearest] - t) --nearest;
  const Eigen::Matrix3d& base = window.frames[nearest];
  if (end - begin < 2) return base;
  if (!local_linear) {
    std::vector<Eigen::Quaterniond> q;
    std::vector<double> weights;
    for (int i = begin; i < end; ++i) {
      const double u = (d[i] - t) / radius;
      q.emplace_back(window.frames[i]);
      weights.push_back(std::exp(-0.5 * u * u));
    }
    return rotation_average(q, weights).toRotationMatrix();
  }
  // Weighted straight line through log(baseᵀ A): its value at t, and from it the frame. A second pass about
  // the result removes what the curvature of SO(3) adds when the readings turn much within the window.
  Eigen::Matrix3d frame = base;
  for (int pass = 0; pass < 2; ++pass) {
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    Eigen::Vector3d v0 = Eigen::Vector3d::Zero(), v1 = Eigen::Vector3d::Zero();
    for (int i = begin; i < end; ++i) {
      const double u = (d[i] - t) / radius;
      const double w = window.counts[i] * std::exp(-0.5 * u * u);
      const Eigen::Vector3d v = so3_log(frame.transpose() * window.frames[i]);
      s0 += w, s1 += w * u, s2 += w * u * u, s3 += w * u * u * u;
      v0 += w * v, v1 += w * u * v;
    }
    const double determinant = s0 * s2 - s1 * s1;
    // All readings at one place carry no rate of turn: their average.
    const bool has_slope = determinant > 1e-9 * s0 * s0;
    const Eigen::Vector3d value =
        has_slope ? Eigen::Vector3d((s2 * v0 - s1 * v1) / determinant) : Eigen::Vector3d(v0 / s0);
    if (lag != nullptr && has_slope) *lag = 0.5 * radius * radius * (s2 * s2 - s1 * s3) / determinant;
    frame = frame * so3_exp(value);
  }
  return nearest_rotation(frame);
}

/// Each reading is shared between the two samples around it in proportion: the counts add up to the readings.
Eigen::VectorXd shared_counts(const CleanCurve& curve, const Eigen::VectorXd& parameters) {
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(parameters.size());
  const double* begin = parameters.data();
  const double* end = begin + parameters.size();
  for (Eigen::Index i = 0; i < curve.counts.size(); ++i) {
    const Eigen::Index after = std::clamp<Eigen::Index>(
        std::upper_bound(begin, end, curve.distances[i]) - begin, 1, parameters.size() - 1);
    const double u =
        (curve.distances[i] - parameters[after - 1]) / (parameters[after] - parameters[after - 1]);
    counts[after] += curve.counts[i] * std::clamp(u, 0.0, 1.0);
    counts[after - 1] += curve.counts[i] * (1 - std::clamp(u, 0.0, 1.0));
  }
  return counts;
}

/// More steps where the frame would turn by more than 25° within one: the regression needs less than 90°, and
/// the shape between two samples is taken for an arc.
int enough_steps(const Window& window, double from, double to, int steps, const PrefilterOptions& options,
                 const Progress& progress) {
  constexpr double kMostTurn = radians(25.0);
  constexpr int kDoublings = 4;
  for (int doubling = 0; doubling < kDoublings; ++doubling) {
    const double h = (to - from) / steps;
    bool enough = true;
    Eigen::Matrix3d last = frame_at(window, from, options.sigma * h, options.local_linear);
    for (int k = 1; k <= steps && enough; ++k) {
      if (k % 1000 == 0) progress.report("prefilter", 0.5);
      const Eigen::Matrix3d next = frame_at(window, from + k * h, options.sigma * h, options.local_linear);
      enough = turn_between(last, next) <= kMostTurn;
      last = next;
    }
    if (enough) break;
    steps *= 2;
  }
  return steps;
}

/// Samples of one curve, and which of them are readings.
struct SamplePlaces {
  std::vector<double> parameters;
  std::vector<int> readings;  ///< −1: none lies there, or it is one of many
};

/// Adds the samples behind `from` up to `to`, readings of a curve: `steps` even ones; but where that is more
/// than twice as many as there are readings, all readings and as many places between them as make such steps,
/// so that what is known is not mixed with what lies between.
void add_places(const CleanCurve& clean, int from, int to, int steps, SamplePlaces& places) {
  const double begin = clean.distances[from], length = clean.distances[to] - begin;
  const bool is_sparse = steps > 2 * (to - from);
  if (is_sparse && places.parameters.size() == 1) places.readings.front() = from;
  for (int i = is_sparse ? from : to - 1; i < to; ++i) {
    const double start = is_sparse ? clean.distances[i] : begin;
    const double gap = is_sparse ? clean.distances[i + 1] - start : length;
    const int pieces = is_sparse ? std::max(1, static_cast<int>(std::lround(steps * gap / length))) : steps;
    for (int k = 1; k <= pieces; ++k) {
      places.parameters.push_back(k == pieces ? clean.distances[i + 1] : start + gap * k / pieces);
      places.readings.push_back(is_sparse && k == pieces ? i + 1 : -1);
    }
  }
}

/// A turn at the seam of a closed curve beyond which it is a corner. Noise and drift of good devices stay
/// below; a corner that is this blunt is rounded within one step.
constexpr double kSeamCorner = radians(25.0);

/// A curve whose samples are its readings.
void keep_readings(const CleanCurve& clean, const Window& window, bool wrap, SampledCurve& curve) {
  curve.parameters = clean.distances;
  curve.frames = clean.frames;
  curve.weights = clean.counts;
  curve.node_samples = clean.node_readings;
  curve.node_ids = clean.node_ids;
  curve.lag.setZero(clean.distances.size());
  for (size_t i = 0; i < clean.frames.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (clean.counts[k] == 0) curve.frames[i] = frame_at(window, clean.distances[k], 0, true, &curve.lag[k]);
  }
  if (!curve.smooth_seam || !wrap) return;
  const std::vector<Eigen::Matrix3d> ends{curve.frames.front(), curve.frames.back()};
  curve.frames.front() = curve.frames.back() = rotation_average(ends);
}

}  // namespace

std::optional<std::string> PrefilterOptions::problem() const {
  if (!(step >= 0) || !std::isfinite(step)) return concat("step must be >= 0, got ", step);
  if (!(sigma > 0 && sigma <= 2)) return concat("sigma must be in (0, 2], got ", sigma);
  return std::nullopt;
}

SampledScan resample(const Scan& scan, const std::vector<CleanCurve>& curves, const PrefilterOptions& options,
                     const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  SampledScan samples;
  for (size_t c = 0; c < curves.size(); ++c) {
    progress.report("prefilter", static_cast<double>(c) / static_cast<double>(curves.size()));
    const CleanCurve& clean = curves[c];
    SampledCurve curve;
    curve.name = scan.curves[c].name;
    curve.boundary = scan.curves[c].boundary;
    curve.sharp = scan.curves[c].sharp;
    curve.closed = scan.curves[c].closed;
    const int n = static_cast<int>(clean.frames.size());
    if (curve.closed)
      curve.smooth_seam = turn_between(clean.frames.front(), clean.frames.back()) < kSeamCorner;
    const Window window = window_of(clean, options.wrap && curve.smooth_seam);
    if (options.step <= 0) {
      keep_readings(clean, window, options.wrap, curve);
      set_turns(scan.curves[c], clean, curve);
      samples.curves.push_back(std::move(curve));
      continue;
    }
    // Cuts: the ends of the curve and its nodes.
    std::vector<int> cuts{0};
    for (const int reading : clean.node_readings)
      if (reading != 0 && reading != n - 1) cuts.push_back(reading);
    cuts.push_back(n - 1);
    SamplePlaces places{{clean.distances[0]}, {-1}};
    std::vector<double>& parameters = places.parameters;
    std::vector<int> sample_of_cut{0};
    for (size_t s = 0; s + 1 < cuts.size(); ++s) {
      const double from = clean.distances[cuts[s]], to = clean.distances[cuts[s + 1]];
      const int fewest = curve.closed && cuts.size() == 2 ? 3 : 1;  // a loop of fewer steps has no area
      int steps = std::max(fewest, static_cast<int>(std::lround((to - from) / options.step)));
      steps = enough_steps(window, from, to, steps, options, progress);
      add_places(clean, cuts[s], cuts[s + 1], steps, places);
      sample_of_cut.push_back(static_cast<int>(parameters.size()) - 1);
    }
    curve.parameters =
        Eigen::Map<Eigen::VectorXd>(parameters.data(), static_cast<Eigen::Index>(parameters.size()));
    for (size_t j = 0; j < clean.node_readings.size(); ++j) {
      const auto cut = std::find(cuts.begin(), cuts.end(), clean.node_readings[j]);
      curve.node_samples.push_back(sample_of_cut[cut - cuts.begin()]);
      curve.node_ids.push_back(clean.node_ids[j]);
    }
    const int n_samples = static_cast<int>(parameters.size());
    curve.frames.resize(n_samples);
    curve.lag.setZero(n_samples);
    const auto fit = [&](int k) {
      if (const int reading = places.readings[k]; reading >= 0 && clean.counts[reading] > 0) {
        curve.frames[k] = clean.frames[reading];
        return;
      }
      const double h = k == 0               ? parameters[1] - parameters[0]
                       : k == n_samples - 1 ? parameters[k] - parameters[k - 1]
                                            : 0.5 * (parameters[k + 1] - parameters[k - 1]);
      curve.frames[k] =
          frame_at(window, parameters[k], options.sigma * h, options.local_linear, &curve.lag[k]);
    };
    parallel_for(
        n_samples, kSampleGrain,
        [&](Eigen::Index begin, Eigen::Index end) {
          for (Eigen::Index k = begin; k < end; ++k) fit(static_cast<int>(k));
        },
        progress);
    curve.weights = shared_counts(clean, curve.parameters);
    set_turns(scan.curves[c], clean, curve);
    samples.curves.push_back(std::move(curve));
  }
  return samples;
}

}  // namespace batten
