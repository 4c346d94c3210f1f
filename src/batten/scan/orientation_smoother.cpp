#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/orientation_smoother_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Unknowns of the border: InertialErrors, then the excess of gravity.
constexpr int kGravity = InertialErrors::kCount, kBorder = kGravity + 1;
// Unknowns of a knot.
constexpr int kTurnPart = 0, kVelocityPart = 3, kPlacePart = 6;

/// Scale and alignment of gyroscopes, one entry of M; and gravity with the scale of accelerometers.
constexpr double kMatrixDeviation = 0.01, kGravityDeviation = 0.01;
/// Holds the heading of the first knot where nothing else does, radians.
constexpr double kFirstHeadingDeviation = 1.5;

constexpr int kMostSmoothingSteps = 25;
/// Steps end at turns below this, radians: far below every sensor.
constexpr double kLeastTurn = 5e-5;
/// The start may be wrong, so that headings far off are let in at first: so many steps with this deviation,
/// radians, in which all fields count; then it falls by a factor a step down to the true one.
constexpr double kFirstGate = 0.5, kGateFactor = 0.4;
constexpr int kOpenSteps = 2, kOffsetPasses = 6;
/// Entries of bias (rad/s) and M by which a motion may be corrected to first order: the second is 1e-5 rad.
constexpr double kMuchChange = 0.01;
/// Deviation of one reading of the field, in strengths, and of the magnetometer's offset beforehand; where
/// the offset makes the median residual smaller by this factor it is real.
constexpr double kFieldDeviation = 0.05, kOffsetDeviation = 0.5, kNoOffset = 1e-6, kOffsetGain = 0.7;
/// Limits of the deviation of the headings when it is found from the readings, and where the search begins.
constexpr double kFirstDeviation = 0.07, kLeastDeviation = 0.02, kMostDeviation = 0.5;

}  // namespace

void InertialRecording::append(Eigen::Index i, const InertialErrors& errors, Motion& motion) const {
  const double dt = time[i + 1] - time[i];
  if (!(dt > 0)) return;
  const auto a = static_cast<size_t>(i), b = a + 1;
  const bool rate_known = rate.known[a] != 0 && rate.known[b] != 0;
  const bool force_known = force.known[a] != 0 && force.known[b] != 0;
  if (!rate_known || dt > longest_gap)
    motion.append_gap(dt);
  else if (!force_known)
    motion.append_turn(dt, rate.values.row(i), rate.values.row(i + 1), errors);
  else
    motion.append(dt, rate.values.row(i), rate.values.row(i + 1), force.values.row(i),
                  force.values.row(i + 1), errors);
}

OrientationSmoother::OrientationSmoother(const InertialRecording& recording,
                                         const OrientationOptions& options,
                                         const std::vector<Matrix3d>& start)
    : recording_(recording),
      options_(options),
      heading_deviation_(options.heading_deviation.value_or(kFirstDeviation)),
      system_(1, kBorder) {
  const Eigen::Index n = recording.time.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    if (!knots_.empty()) {
      const double T = recording.time[i] - recording.time[knots_.back().row];
      if (T < kKnotInterval && !(last && T > 0)) continue;
    }
    Knot knot;
    knot.row = i;
    knot.X = start[static_cast<size_t>(i)];
    knots_.push_back(knot);
  }
  for (size_t k = 0; k < knots_.size(); ++k) {
    const Eigen::Index before = knots_[k > 0 ? k - 1 : k].row;
    const Eigen::Index after = knots_[std::min(k + 1, knots_.size() - 1)].row;
    // What follows a gap does not stand for it.
    knots_[k].time = std::min(0.5 * (recording.time[after] - recording.time[before]), kFieldCorrelation);
  }
  system_ = Chain(static_cast<int>(knots_.size()), kBorder);
}

void OrientationSmoother::preintegrate() {
  summed_.assign(knots_.size() - 1, Motion());
  summed_with_ = errors_;
  for (size_t k = 0; k < knots_.size(); ++k) {
    Knot& knot = knots_[k];
    const bool last = k + 1 == knots_.size();
    const Eigen::Index end = last ? knot.row + 1 : knots_[k + 1].row;
    Motion own;
    Motion& motion = last ? own : summed_[k];
    Vector3d sum = Vector3d::Zero();
    Matrix3d turns = Matrix3d::Zero();
    int n = 0;
    for (Eigen::Index i = knot.row; i < end; ++i) {
      if (recording_.field.row(i).allFinite()) {
        sum += motion.R * recording_.field.row(i).transpose();
        turns += motion.R;
        ++n;
      }
      if (!last) recording_.append(i, errors_, motion);
    }
    knot.has_field = n > 0;
    if (n > 0) {
      knot.reading = sum / n;
      knot.turn = turns / n;
    }
    has_field_ = has_field_ || n > 0;
  }
  motions_ = summed_;
}

/// The motions for the present errors: summed up anew where these have changed much.
void OrientationSmoother::update_motions() {
  const Eigen::Matrix<double, InertialErrors::kCount, 1> change = errors_.vector() - summed_with_.vector();
  if (summed_.empty() || change.head<InertialErrors::kForce>().cwiseAbs().maxCoeff() > kMuchChange) {
    preintegrate();
    return;
  }
  for (size_t k = 0; k < summed_.size(); ++k) motions_[k] = summed_[k].corrected(change);
}

Vector3d OrientationSmoother::turn_misfit(int k) const {
  return so3_log(motions_[k].R.transpose() * knots_[k].X.transpose() * knots_[k + 1].X);
}

double OrientationSmoother::turn_deviation(int k) const {
  const Motion& m = motions_[k];
  return (m.turn_known ? options_.gyroscope_noise : kUnknownTurn) * std::sqrt(m.time);
}

double OrientationSmoother::velocity_deviation(int k) const {
  const Motion& m = motions_[k];
  return (m.force_known ? options_.accelerometer_noise : kUnknownVelocity) * std::sqrt(m.time);
}

Vector3d OrientationSmoother::turn_residual(int k) const {
  return turn_misfit(k) / turn_deviation(k);
}

Vector3d OrientationSmoother::velocity_residual(int k) const {
  const Motion& m = motions_[k];
  const Knot &a = knots_[k], &b = knots_[k + 1];
  Vector3d r = b.v - a.v;
  if (m.force_known) r += Vector3d(0, 0, gravity() * m.time) - a.X * m.v;
  return r / velocity_deviation(k);
}

/// The offset of the magnetometer, with which its readings come from one field of the world: least squares
/// for both together, with less and less say for what does not fit. Magnets that go with the device show so.
/// @param decide whether the offset is taken at all.
void OrientationSmoother::fit_offset(bool decide) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  if (!decide && !has_offset_) return;
  std::vector<double> sizes;
  const auto residuals = [&](const Vector6& x) {
    sizes.clear();
    for (const Knot& knot : knots_)
      if (knot.has_field)
        sizes.push_back((knot.X * (knot.reading - knot.turn * x.tail<3>()) - x.head<3>()).norm());
    return upper_median(sizes);
  };
  const auto fit = [&](bool with_offset) {
    Vector6 x = Vector6::Zero();
    double scale = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < kOffsetPasses; ++pass) {
      Matrix6 A = Matrix6::Zero();
      Vector6 right = Vector6::Zero();
      for (const Knot& knot : knots_) {
        if (!knot.has_field) continue;
        const Vector3d m = knot.X * knot.reading;
        const Matrix3d B = knot.X * knot.turn;
        const double r = (m - B * x.tail<3>() - x.head<3>()).norm();
        const double w = knot.time / kFieldCorrelation * robust_weight(r * r / (scale * scale));
        A.topLeftCorner<3, 3>() += w * Matrix3d::Identity();
        A.topRightCorner<3, 3>() += w * B;
        A.bottomRightCorner<3, 3>() += w * (B.transpose() * B);
        right.head<3>() += w * m;
        right.tail<3>() += w * (B.transpose() * m);
      }
      A.bottomLeftCorner<3, 3>() = A.topRightCorner<3, 3>().transpose();
      const double ratio = kFieldDeviation / (with_offset ? kOffsetDeviation : kNoOffset);
      A.bottomRightCorner<3, 3>().diagonal().array() += ratio * ratio;
      x = A.ldlt().solve(right);
      scale = std::max(kFieldDeviation * x.head<3>().norm(), residuals(x));
    }
    return x;
  };
  const Vector6 with = fit(true);
  if (decide) has_offset_ = residuals(with) < kOffsetGain * residuals(fit(false));
  if (has_offset_) offset_ = with.tail<3>();
}

void OrientationSmoother::fit_reference() {
  std::vector<double> strengths, dips;
  for (Knot& knot : knots_) {
    if (!knot.has_field) continue;
    knot.field = knot.X * (knot.reading - knot.turn * offset_);
    const FieldFigures figures = field_figures(knot.field);
    strengths.push_back(figures.strength);
    dips.push_back(figures.dip);
  }
  if (strengths.empty()) return;
  reference_ = {median(strengths), median(dips)};
  // Then the mean of what lies about the median, each with its say.
  for (int pass = 0; pass < 3; ++pass) {
    double weight = 0, strength = 0, dip = 0;
    for (const Knot& knot : knots_) {
      if (!knot.has_field) continue;
      const FieldFigures figures = field_figures(knot.field);
      const double w = knot.time * robust_weight(field_distance(figures, reference_));
      weight += w;
      strength += w * figures.strength;
      dip += w * figures.dip;
    }
    if (!(weight > 0)) return;
    reference_ = {strength / weight, dip / weight};
  }
}

void OrientationSmoother::weigh_fields(double gate) {
  fit_reference();
  const bool open = gate >= kFirstGate;
  deviation_ = std::max(gate, heading_deviation_);
  for (Knot& knot : knots_) {
    knot.quality = knot.weight = 0;
    if (!knot.has_field || !(std::hypot(knot.field.x(), knot.field.y()) > 0)) continue;
    knot.heading = std::atan2(knot.field.y(), knot.field.x());
    const double distance = field_distance(field_figures(knot.field), reference_);
    const double z = knot.heading / deviation_;
    knot.quality = open ? 1 : robust_weight(distance);
    knot.weight = open ? 1 : robust_weight(distance + z * z);
  }
}

/// A step of expectation-maximisation of the marginal likelihood of the headings: the mean square of the
/// residuals with what is not known of the orientation, each weighted as in a t-distribution.
void OrientationSmoother::update_deviation() {
  double sum = 0, count = 0;
  const double s2 = heading_deviation_ * heading_deviation_;
  for (size_t k = 0; k < knots_.size(); ++k) {
    const Knot& knot = knots_[k];
    if (knot.quality <= 0) continue;
    const Vector3d down = knot.X.row(2).transpose();
    const double variance = down.dot(covariances_[k] * down);
    const double square = knot.heading * knot.heading + variance;
    constexpr double kFreedom = 4;
    sum += knot.time * knot.quality * (kFreedom + 1) / (kFreedom + square / s2) * square;
    count += knot.time * knot.quality;
  }
  if (count > 0) heading_deviation_ = std::clamp(std::sqrt(sum / count), kLeastDeviation, kMostDeviation);
}

void OrientationSmoother::assemble_step(int k) {
  using Row = Chain::Rows<3>;
  using BorderRows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const Motion& m = motions_[k];
  const Knot &a = knots_[k], &b = knots_[k + 1];
  const Matrix3d I = Matrix3d::Identity();
  const double T = m.time;

  const double turn = 1 / turn_deviation(k);
  const Vector3d r = turn_misfit(k);
  const Matrix3d J = so3_right_jacobian_inverse(r);
  Row by_a = Row::Zero(), by_b = Row::Zero();
  BorderRows by_border = BorderRows::Zero(3, kBorder);
  by_b.middleCols<3>(kTurnPart) = turn * J;
  by_a.middleCols<3>(kTurnPart) = -turn * J * b.X.transpose() * a.X;
  by_border.leftCols<InertialErrors::kCount>() = -turn * J * so3_exp(r).transpose() * m.R_by;
  system_.add<3>(k, by_a, by_b, by_border, turn * r);

  const double velocity = 1 / velocity_deviation(k);
  Row va = Row::Zero(), vb = Row::Zero();
  BorderRows v_border = BorderRows::Zero(3, kBorder);
  Vector3d rv = b.v - a.v;
  va.middleCols<3>(kVelocityPart) = -I;
  vb.middleCols<3>(kVelocityPart) = I;
  Row pa = Row::Zero(), pb = Row::Zero();
  BorderRows p_border = BorderRows::Zero(3, kBorder);
  Vector3d rp = b.p - a.p - T * a.v;
  pa.middleCols<3>(kPlacePart) = -I;
  pa.middleCols<3>(kVelocityPart) = -T * I;
  pb.middleCols<3>(kPlacePart) = I;
  if (m.force_known) {
    rv += Vector3d(0, 0, gravity() * T) - a.X * m.v;
    va.middleCols<3>(kTurnPart) = a.X * hat(m.v);
    v_border.leftCols<InertialErrors::kCount>() = -a.X * m.v_by;
    v_border(2, kGravity) = kUsualGravity * T;
    rp += Vector3d(0, 0, 0.5 * gravity() * T * T) - a.X * m.p;
    pa.middleCols<3>(kTurnPart) = a.X * hat(m.p);
    p_border.leftCols<InertialErrors::kCount>() = -a.X * m.p_by;
    p_border(2, kGravity) = 0.5 * kUsualGravity * T * T;
  }
  // White noise of the force over T makes errors of velocity and place with covariance
  // [T, T²/2; T²/2, T³/3]: place less T/2 velocity is independent of velocity, with variance T³/12.
  system_.add<3>(k, velocity * va, velocity * vb, velocity * v_border, velocity * rv);
  const double place = velocity * std::sqrt(12.0) / T;
  system_.add<3>(k, place * (pa - 0.5 * T * va), place * (pb - 0.5 * T * vb),
                 place * (p_border - 0.5 * T * v_border), place * (rp - 0.5 * T * rv));
}

void OrientationSmoother::assemble_bounds(int k) {
  using Row = Chain::Rows<3>;
  const Knot& knot = knots_[k];
  const auto bound = [&](int at, const Vector3d& value, double deviation, double correlation) {
    const double w = std::sqrt(knot.time / correlation) / deviation;
    Row J = Row::Zero();
    J.middleCols<3>(at) = w * Matrix3d::Identity();
    system_.add<3>(k, J, w * value);
  };
  bound(kVelocityPart, knot.v, options_.speed, kSpeedCorrelation);
  bound(kPlacePart, knot.p, options_.reach, kReachCorrelation);
  // A turn about the vertical turns the field with it. What a tilt does to the heading of a field that dips
  // is left out: the magnetometer has no say in tilts.
  const auto heading = [&](double w, double value) {
    Chain::Rows<1> J = Chain::Rows<1>::Zero();
    J.segment<3>(kTurnPart) = w * knot.X.row(2);
    system_.add<1>(k, J, Eigen::Matrix<double, 1, 1>(w * value));
  };
  if (knot.weight > 0)
    heading(std::sqrt(knot.weight * knot.time / kFieldCorrelation) / deviation_, knot.heading);
  if (k == 0) heading(1 / kFirstHeadingDeviation, 0);
}

void OrientationSmoother::assemble() {
  system_.clear();
  for (int k = 0; k < static_cast<int>(knots_.size()); ++k) {
    if (k + 1 < static_cast<int>(knots_.size())) assemble_step(k);
    assemble_bounds(k);
  }
  const auto square = [](double x) { return x * x; };
  const auto prior = [&](int first, int n, const double* values, double deviation) {
    for (int i = 0; i < n; ++i) system_.add_border(first + i, 1 / square(deviation), values[i]);
  };
  prior(InertialErrors::kBias, 3, errors_.gyroscope_bias.data(), options_.bias_deviation);
  prior(InertialErrors::kMatrix, 9, errors_.gyroscope_matrix.data(), kMatrixDeviation);
  prior(InertialErrors::kForce, 3, errors_.accelerometer_bias.data(), kForceBiasDeviation);
  prior(kGravity, 1, &gravity_excess_, kGravityDeviation);
}

void OrientationSmoother::apply() {
  turned_ = 0;
  for (size_t k = 0; k < knots_.size(); ++k) {
    const Chain::Vector& step = system_.step(static_cast<int>(k));
    turned_ = std::max(turned_, step.segment<3>(kTurnPart).norm());
    knots_[k].X = nearest_rotation(knots_[k].X * so3_exp(step.segment<3>(kTurnPart)));
    knots_[k].v += step.segment<3>(kVelocityPart);
    knots_[k].p += step.segment<3>(kPlacePart);
  }
  const Eigen::VectorXd& shared = system_.border_step();
  errors_.gyroscope_bias += shared.segment<3>(InertialErrors::kBias);
  errors_.gyroscope_matrix += shared.segment<9>(InertialErrors::kMatrix).reshaped(3, 3);
  errors_.accelerometer_bias += shared.segment<3>(InertialErrors::kForce);
  gravity_excess_ += shared[kGravity];
}

void OrientationSmoother::step(const Progress& progress) {
  progress.report("smoothing", std::min(0.95, iterations_ / 15.0));
  ++iterations_;
  assemble();
  if (!system_.solve()) throw SolverFailure("orientation of a device", 9L * static_cast<long>(knots_.size()));
  apply();
  update_motions();
}

void OrientationSmoother::solve(const Progress& progress) {
  update_motions();
  double gate = kFirstGate;
  while (iterations_ < kMostSmoothingSteps) {
    if (has_field_) {
      const bool open = iterations_ < kOpenSteps;
      if (!open) {
        fit_offset(iterations_ <= kOpenSteps + 1);
        gate *= kGateFactor;
      }
      weigh_fields(gate);
    }
    step(progress);
    if (has_field_ && deviation_ > heading_deviation_) continue;
    if (has_field_ && !options_.heading_deviation) {
      covariances_ = system_.turn_covariances();
      const double before = heading_deviation_;
      update_deviation();
      if (std::abs(heading_deviation_ - before) > 0.05 * before) continue;
    }
    converged_ = turned_ < kLeastTurn;
    if (converged_) break;
  }
  covariances_ = system_.turn_covariances();
  if (has_field_) weigh_fields(0);
}

Vector3d OrientationSmoother::bias_deviation() const {
  return system_.border_covariance().diagonal().segment<3>(InertialErrors::kBias).cwiseSqrt();
}

}  // namespace batten
