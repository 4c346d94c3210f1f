#include "batten/scan/convention.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/prefilter.hpp"

namespace batten {

namespace {

/// Misfit of the loops when the steps are taken as forward chords or as turning frames, relative to the mean
/// length of a segment.
struct Closure {
  double forward = 0, at_sample = 0;
  int n_loops = 0;
};

Closure closure_of(const Scan& scan) {
  std::vector<std::string> ignored;
  const std::vector<CleanCurve> clean = clean_readings(scan, {0, false}, ignored);
  PrefilterOptions options;
  options.wrap = false;
  const SampledScan samples = resample(scan, clean, options);
  const double length = samples.length() / static_cast<double>(samples.curves.size());
  const auto misfit = [&](StepRule rule) {
    return integrate_steps(samples, frame_steps(samples, rule), ClosureForm::FirstDifference);
  };
  const IntegrationResult forward = misfit(StepRule::Tangent), turning = misfit(StepRule::ConstantRate);
  return {forward.closure_misfit / length, turning.closure_misfit / length, forward.n_loops};
}

}  // namespace

ConventionReport tangent_convention(const Scan& scan) {
  ConventionReport report;
  if (scan.tangents != TangentConvention::Auto) {
    report.convention = scan.tangents;
    report.reason = "stated by the scan";
    if (scan.tangents == TangentConvention::ToNext) {
      const Closure closure = closure_of(scan);
      if (closure.n_loops > 0) report.forward_misfit = closure.forward;
    }
    return report;
  }
  // Root mean square of T·N at the reading and at the middle of the step that follows.
  double here = 0, between = 0;
  long n = 0;
  for (const ScanCurve& curve : scan.curves) {
    for (Eigen::Index i = 0; i + 1 < curve.n_readings(); ++i) {
      if (curve.distances[i + 1] == curve.distances[i]) continue;
      const Eigen::Vector3d t = curve.tangents.row(i).normalized();
      const Eigen::Vector3d a = curve.normals.row(i).normalized(), b = curve.normals.row(i + 1).normalized();
      here += std::pow(t.dot(a), 2);
      between += std::pow(t.dot((a + b).normalized()), 2);
      ++n;
    }
  }
  here = std::sqrt(here / static_cast<double>(std::max(n, 1L)));
  between = std::sqrt(between / static_cast<double>(std::max(n, 1L)));
  const std::string figures = concat("T·N is ", here, " rms at the reading, ", between,
                                     " against the mean normal of the step that follows");
  // Files carry four digits or more; a device's frames are orthonormal by construction.
  constexpr double kRounding = 2e-4;
  if (here < kRounding) {
    report.reason = "frames at the readings: " + figures;
    return report;
  }
  const Closure closure = closure_of(scan);
  if (closure.n_loops > 0) report.forward_misfit = closure.forward;
  const std::string closing = concat("; the loops miss by ", closure.forward,
                                     " of a curve's length with tangents to the next reading, ",
                                     closure.at_sample, " with frames at the readings");
  if (closure.n_loops > 0 && closure.forward < 0.2 * closure.at_sample) {
    report.convention = TangentConvention::ToNext;
    report.reason = "tangents to the next reading: " + figures + closing;
  } else if (closure.n_loops > 0 && closure.at_sample < 0.5 * closure.forward) {
    report.reason = "frames at the readings: " + figures + closing;
  } else if (between < 0.3 * here) {
    report.convention = TangentConvention::ToNext;
    report.reason = "tangents to the next reading: " + figures;
  } else {
    report.reason = "frames at the readings, for want of a sign of the other: " + figures;
    if (closure.n_loops > 0) report.reason += closing;
    report.uncertain = true;
  }
  return report;
}

Scan frames_at_samples(const Scan& scan) {
  Scan converted = scan;
  converted.tangents = TangentConvention::AtSample;
  for (ScanCurve& curve : converted.curves) {
    const Eigen::Index n = curve.n_readings();
    // Steps of positive length, each with its chord direction; readings at one distance share a place.
    std::vector<Eigen::Vector3d> chords;
    std::vector<double> lengths;
    std::vector<Eigen::Index> place(n, 0);
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      const double h = curve.distances[i + 1] - curve.distances[i];
      if (h > 0) {
        chords.push_back(curve.tangents.row(i).normalized());
        lengths.push_back(h);
      }
      place[i + 1] = static_cast<Eigen::Index>(chords.size());
    }
    const int m = static_cast<int>(chords.size());
    const bool ring = curve.closed && m > 3 && chords.front().dot(chords.back()) > 0.7;
    const auto chord = [&](int k) -> const Eigen::Vector3d& { return chords[(k + m) % m]; };
    const auto length = [&](int k) { return lengths[(k + m) % m]; };
    std::vector<Eigen::Vector3d> tangents(m + 1);
    for (int k = 0; k <= m; ++k) {
      const bool has_two = ring || (k >= 1 && k <= m - 1);
      const bool has_four = ring || (k >= 2 && k <= m - 2);
      Eigen::Vector3d t;
      if (has_two) {
        // The chords stand for the middles of their steps: linear between the two nearest …
        const double before = length(k - 1), after = length(k);
        t = (after * chord(k - 1) + before * chord(k)) / (before + after);
        // … and cubic through four, where the steps are even.
        if (has_four) {
          double shortest = before, longest = before;
          for (int j = k - 2; j <= k + 1; ++j)
            shortest = std::min(shortest, length(j)), longest = std::max(longest, length(j));
          if (longest < 1.1 * shortest)
            t = (9 * (chord(k - 1) + chord(k)) - chord(k - 2) - chord(k + 1)) / 16;
        }
      } else if (m == 1) {
        t = chords[0];
      } else {
        const int near = k == 0 ? 0 : m - 1, far = k == 0 ? 1 : m - 2;
        t = chords[near] + lengths[near] / (lengths[near] + lengths[far]) * (chords[near] - chords[far]);
      }
      tangents[k] = t.normalized();
    }
    // Arc over chord: (θ/2)/sin(θ/2) for a step that turns by θ.
    std::vector<double> arc(m + 1, curve.distances[0]);
    for (int k = 0; k < m; ++k) {
      const double half =
          0.5 * std::atan2(tangents[k].cross(tangents[k + 1]).norm(), tangents[k].dot(tangents[k + 1]));
      arc[k + 1] = arc[k] + lengths[k] * (half > 1e-4 ? half / std::sin(half) : 1 + half * half / 6);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      curve.tangents.row(i) = tangents[place[i]].transpose();
      curve.distances[i] = arc[place[i]];
    }
  }
  return converted;
}

}  // namespace batten
