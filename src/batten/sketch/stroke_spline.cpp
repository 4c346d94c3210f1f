#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "batten/curves/bspline.hpp"
#include "batten/sketch/stroke_spline_detail.hpp"
#include "batten/sketch/stroke_walk_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double kChordError = 1e-5;  // of the length
/// Four held points in a row that are nearer to each other than this share of the length are too dense for a
/// spline to go through all of them: with about one in every span the system is close to singular, with more
/// it has no solution, and the curve swings, each by more than those that it crosses.
constexpr double kDenseFour = 0.07;

}  // namespace

Vector3d StrokeSpline::at(double t) const {
  const CubicBasis basis = cubic_basis(t * spans, spans, periodic);
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 4; ++k) sum += basis.values[k] * control.row(index(basis.first + k)).transpose();
  return offsets.empty() ? sum : sum + offset_at(t);
}

Vector3d StrokeSpline::offset_at(double t) const {
  const auto above =
      std::upper_bound(offsets.begin(), offsets.end(), t,
                       [](double value, const StrokeSample& sample) { return value < sample.t; });
  const bool before_all = above == offsets.begin(), after_all = above == offsets.end();
  const StrokeSample &one = before_all ? offsets.back() : *(above - 1),
                     &next = after_all ? offsets.front() : *above;
  if (!periodic && (before_all || after_all)) return before_all ? next.point : one.point;
  const double t0 = before_all ? one.t - 1 : one.t, t1 = after_all ? next.t + 1 : next.t;
  const double s = t1 > t0 ? (t - t0) / (t1 - t0) : 0, rise = s * s * (3 - 2 * s);
  return (1 - rise) * one.point + rise * next.point;
}

StrokeSpline least_squares_spline(const std::vector<StrokeSample>& samples,
                                  const std::vector<StrokeSample>& held, int spans, bool periodic,
                                  double bending) {
  StrokeSpline spline;
  spline.spans = spans;
  spline.periodic = periodic;
  const Index m = periodic ? spans : spans + 3, c = static_cast<Index>(held.size());
  spline.control.setZero(m, 3);
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + c, m + c);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(m + c, 3);
  for (const StrokeSample& sample : samples) {
    const CubicBasis basis = cubic_basis(sample.t * spans, spans, periodic);
    for (int a = 0; a < 4; ++a) {
      const Index i = spline.index(basis.first + a);
      for (int b = 0; b < 4; ++b)
        system(i, spline.index(basis.first + b)) += sample.weight * basis.values[a] * basis.values[b];
      right.row(i) += sample.weight * basis.values[a] * sample.point.transpose();
    }
  }
  for (Index k = 0; k + 2 < m + (periodic ? 2 : 0); ++k) {
    const Index ids[3] = {k % m, (k + 1) % m, (k + 2) % m};
    const double row[3] = {1, -2, 1};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) system(ids[a], ids[b]) += bending * row[a] * row[b];
  }
  for (Index k = 0; k < c; ++k) {
    const StrokeSample& hold = held[static_cast<size_t>(k)];
    const CubicBasis basis = cubic_basis(hold.t * spans, spans, periodic);
    for (int a = 0; a < 4; ++a) {
      const Index i = spline.index(basis.first + a);
      system(m + k, i) += basis.values[a];
      system(i, m + k) += basis.values[a];
    }
    right.row(m + k) = hold.point.transpose();
  }
  spline.control = system.partialPivLu().solve(right).topRows(m);
  return spline;
}

namespace {

/// The spline with as few spans as follow the samples, held at points that are not dense.
StrokeSpline spline_through(const std::vector<StrokeSample>& samples, const std::vector<StrokeSample>& held,
                            bool periodic, const FitAims& aims) {
  StrokeSpline best;
  const int most_spans = static_cast<int>(samples.size()) / (aims.noisy ? 4 : 1);
  double closest_holds = 1;
  for (size_t i = 0; i < held.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      double gap = std::abs(held[i].t - held[j].t);
      if (periodic) gap = std::min(gap, 1 - gap);
      closest_holds = std::min(closest_holds, gap);
    }
  for (int spans = periodic ? 8 : 4; spans <= 128; spans *= 2) {
    best = least_squares_spline(samples, held, spans, periodic, aims.bending);
    double squares = 0, weights = 0, worst_hold = 0;
    for (const StrokeSample& sample : samples) {
      squares += sample.weight * (best.at(sample.t) - sample.point).squaredNorm();
      weights += sample.weight;
    }
    for (const StrokeSample& hold : held)
      worst_hold = std::max(worst_hold, (best.at(hold.t) - hold.point).norm());
    const bool holds =
        best.control.allFinite() && worst_hold <= aims.tolerance && closest_holds * spans >= 0.5;
    const bool follows = squares <= aims.tolerance * aims.tolerance * weights;
    if (holds && (follows || (aims.noisy ? spans > most_spans : spans >= most_spans))) break;
  }
  return best;
}

}  // namespace

StrokeSpline fitted_spline(const std::vector<StrokeSample>& samples, const std::vector<StrokeSample>& held,
                           bool periodic, const FitAims& aims) {
  const bool dense = [&] {
    for (size_t i = 0; i + 3 < held.size(); ++i)
      if (held[i + 3].t - held[i].t < kDenseFour) return true;
    return false;
  }();
  if (!dense) return spline_through(samples, held, periodic, aims);
  std::vector<StrokeSample> all = samples, ends;
  for (size_t i = 0; i < held.size(); ++i) {
    if (!periodic && (i == 0 || i + 1 == held.size())) {
      ends.push_back(held[i]);
      continue;
    }
    all.push_back(held[i]);
    const double before = i > 0 ? held[i - 1].t : held.back().t - 1;
    const double after = i + 1 < held.size() ? held[i + 1].t : held.front().t + 1;
    all.back().weight = (after - before) / 2;
  }
  StrokeSpline spline = spline_through(all, ends, periodic, aims);
  std::vector<StrokeSample> offsets = held;
  for (StrokeSample& offset : offsets) offset.point -= spline.at(offset.t);
  spline.offsets = std::move(offsets);
  return spline;
}

Points sampled(const StrokeSpline& spline, double t0, double t1, int n) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    double t = t0 + (t1 - t0) * i / n;
    if (t > 1) t = spline.periodic ? t - 1 : 1;
    points.row(i) = spline.at(t).transpose();
  }
  return points;
}

int samples_needed(const StrokeSpline& spline, double t0, double t1, double length) {
  const int probes = 8 + static_cast<int>(4 * spline.spans * (t1 - t0));
  const Points points = sampled(spline, t0, t1, probes);
  double turning = 0, own = 0;
  for (Index i = 1; i < points.rows(); ++i) {
    own += (points.row(i) - points.row(i - 1)).norm();
    if (i + 1 < points.rows())
      turning += angle_between(points.row(i) - points.row(i - 1), points.row(i + 1) - points.row(i));
  }
  return std::clamp(static_cast<int>(std::ceil(std::sqrt(turning * own / (8 * kChordError * length)))), 16,
                    1000);
}

}  // namespace batten::detail
