#include "batten/scan/orientation_filter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/field_detail.hpp"
#include "batten/scan/motion_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kTurn = 0, kVelocity = 3, kBias = 6, kForceBias = 9, kUnknowns = 12;
using Covariance = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using State12 = Eigen::Matrix<double, kUnknowns, 1>;

/// Deviations of the first orientation, which one accelerometer reading of a device that may move gives.
constexpr double kFirstTilt = 0.3, kFirstHeading = 0.3;
constexpr double kUsualHeadingDeviation = 0.07;
/// What scale and alignment of the gyroscope, which the filter does not estimate, add to a turn.
constexpr double kScaleDeviation = 0.01;
/// The reference field follows what is accepted with this time constant, seconds.
constexpr double kReferenceTime = 20;
/// A field that is not the reference but stays the same for so long becomes it, seconds; and the time
/// constant with which such a field is followed.
constexpr double kNewFieldTime = 20, kNewFieldFollow = 5;
/// A heading that an undisturbed field contradicts for so long is wrong, seconds.
constexpr double kWrongHeadingTime = 10;

/// The turn that takes a specific force upwards and a field to north, as far as they are known.
Matrix3d first_orientation(const Vector3d& force, const Vector3d& field) {
  const Vector3d up = force.normalized();
  Vector3d north = field.allFinite() ? field : Vector3d::UnitX();
  north -= north.dot(up) * up;
  // Along the vertical there is no north: any direction will do.
  if (north.norm() < 1e-6) north = up.unitOrthogonal();
  north.normalize();
  Matrix3d X;  // rows: north, west, up in device axes
  X << north.transpose(), up.cross(north).transpose(), up.transpose();
  return X;
}

}  // namespace

struct OrientationFilter::State {
  OrientationOptions options;
  bool started = false;
  // At the last knot.
  Matrix3d X = Matrix3d::Identity();
  Vector3d v = Vector3d::Zero();
  InertialErrors errors;
  Covariance P = Covariance::Zero();
  // Since then.
  Motion since;
  Vector3d field_sum = Vector3d::Zero();  ///< in the axes of the last knot
  int n_field = 0;
  // The reading before.
  double time = -std::numeric_limits<double>::infinity();
  double interval = 0,
         force_interval = 0;  ///< mean between readings, and between those of the force, seconds
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  double rate_time = 0, force_time = 0;
  bool has_rate = false, has_force = false;
  // The magnetic field.
  FieldFigures reference, candidate;
  bool has_field = false;
  double reference_age = 0;  ///< seconds of readings in it
  double steady_time = 0, contradicted_time = 0;
  double n_judged = 0, n_rejected = 0;

  void start(const Vector3d& field);
  void advance(const InertialReading& reading, const Vector3d& field);
  void finish_knot();
  void predict();
  void bound_velocity(double T);
  void take_heading(double T);
  double trust_of(const FieldFigures& figures, double heading, double variance, double T);
  template <int R>
  void correct(const Eigen::Matrix<double, R, kUnknowns>& H, const Eigen::Matrix<double, R, R>& noise,
               const Eigen::Matrix<double, R, 1>& innovation);
};

void OrientationFilter::State::start(const Vector3d& field) {
  X = first_orientation(force, field);
  P.setZero();
  const bool known = field.allFinite();
  // Turns are in device axes.
  const Vector3d variances(kFirstTilt * kFirstTilt, kFirstTilt * kFirstTilt,
                           known ? kFirstHeading * kFirstHeading : 1e-12);
  P.block<3, 3>(kTurn, kTurn) = X.transpose() * variances.asDiagonal() * X;
  P.block<3, 3>(kVelocity, kVelocity).diagonal().setConstant(options.speed * options.speed);
  P.block<3, 3>(kBias, kBias).diagonal().setConstant(options.bias_deviation * options.bias_deviation);
  P.block<3, 3>(kForceBias, kForceBias).diagonal().setConstant(kForceBiasDeviation * kForceBiasDeviation);
  started = true;
}

void OrientationFilter::State::advance(const InertialReading& reading, const Vector3d& field) {
  const double dt = reading.time - time;
  if (std::isfinite(dt) && dt > 0) interval = interval == 0 ? dt : interval + 0.05 * (dt - interval);
  const double longest = std::max(kLongestGap, kLongestGapIntervals * interval);
  const bool rate_before = has_rate && time - rate_time <= longest;
  const double since_force = reading.time - force_time;
  if (reading.accelerometer.allFinite() && has_force && since_force > 0)
    force_interval =
        force_interval == 0 ? since_force : force_interval + 0.05 * (since_force - force_interval);
  const double longest_force = std::max(kLongestGap, kLongestGapIntervals * force_interval);
  const bool force_before = has_force && time - force_time <= longest_force;
  const Vector3d last_rate = rate, last_force = force;
  if (reading.gyroscope.allFinite()) {
    rate = reading.gyroscope - options.calibration.gyroscope_bias;
    rate_time = reading.time;
    has_rate = true;
  }
  if (reading.accelerometer.allFinite()) {
    force = options.calibration.accelerometer.apply(reading.accelerometer);
    force_time = reading.time;
    has_force = true;
  } else if (started && rate_before && dt > 0 && dt <= longest) {
    // Held in the world, not in the device that turns away under it.
    force = so3_exp(dt * (0.5 * (last_rate + rate) - errors.gyroscope_bias)).transpose() * force;
  }
  if (started && dt > 0) {
    if (!rate_before || dt > longest || reading.time - rate_time > longest)
      since.append_gap(dt);
    else if (!force_before || reading.time - force_time > longest_force)
      since.append_turn(dt, last_rate, rate, errors);
    else
      since.append(dt, last_rate, rate, last_force, force, errors);
  }
  time = reading.time;
  if (!started && has_force && has_rate && force.norm() > 0) start(field);
  if (started && field.allFinite()) {
    field_sum += since.R * field;
    ++n_field;
  }
}

void OrientationFilter::State::finish_knot() {
  const double T = since.time;
  Vector3d mean = Vector3d::Constant(InertialReading::kMissing);
  if (n_field > 0) mean = since.R.transpose() * field_sum / n_field;
  predict();
  field_sum = mean;
  since = Motion();
  bound_velocity(T);
  if (n_field > 0) take_heading(T);
  field_sum.setZero();
  n_field = 0;
}

void OrientationFilter::State::predict() {
  const double T = since.time;
  Covariance F = Covariance::Identity();
  F.block<3, 3>(kTurn, kTurn) = since.R.transpose();
  F.block<3, 3>(kTurn, kBias) = since.R_by.middleCols<3>(InertialErrors::kBias);
  F.block<3, 3>(kVelocity, kTurn) = -X * hat(since.v);
  F.block<3, 3>(kVelocity, kBias) = X * since.v_by.middleCols<3>(InertialErrors::kBias);
  F.block<3, 3>(kVelocity, kForceBias) = X * since.v_by.middleCols<3>(InertialErrors::kForce);
  const double turn = since.turn_known ? options.gyroscope_noise : kUnknownTurn;
  const double velocity = since.force_known ? options.accelerometer_noise : kUnknownVelocity;
  P = (F * P * F.transpose()).eval();
  const double scale = kScaleDeviation * since.turned;
  P.diagonal().segment<3>(kTurn).array() += turn * turn * T + scale * scale;
  P.diagonal().segment<3>(kVelocity).array() += velocity * velocity * T;
  if (since.force_known)
    v += X * since.v - Vector3d(0, 0, kUsualGravity * T);
  else
    v.setZero();
  X = nearest_rotation(X * since.R);
}

template <int R>
void OrientationFilter::State::correct(const Eigen::Matrix<double, R, kUnknowns>& H,
                                       const Eigen::Matrix<double, R, R>& noise,
                                       const Eigen::Matrix<double, R, 1>& innovation) {
  const Eigen::Matrix<double, kUnknowns, R> PH = P * H.transpose();
  const Eigen::Matrix<double, R, R> S = H * PH + noise;
  const Eigen::Matrix<double, kUnknowns, R> K = S.llt().solve(PH.transpose()).transpose();
  const State12 step = K * innovation;
  P -= K * PH.transpose();
  P = (0.5 * (P + P.transpose())).eval();
  X = X * so3_exp(step.segment<3>(kTurn));
  v += step.segment<3>(kVelocity);
  errors.gyroscope_bias += step.segment<3>(kBias);
  errors.accelerometer_bias += step.segment<3>(kForceBias);
}

void OrientationFilter::State::bound_velocity(double T) {
  Eigen::Matrix<double, 3, kUnknowns> H = Eigen::Matrix<double, 3, kUnknowns>::Zero();
  H.middleCols<3>(kVelocity).setIdentity();
  const double variance = options.speed * options.speed * kSpeedCorrelation / T;
  correct<3>(H, variance * Matrix3d::Identity(), -v);
}

double OrientationFilter::State::trust_of(const FieldFigures& figures, double heading, double variance,
                                          double T) {
  const double distance = field_distance(figures, reference);
  const double quality = robust_weight(distance);
  double weight = robust_weight(distance + heading * heading / variance);
  contradicted_time = quality > 0.5 && weight < 0.25 ? contradicted_time + T : 0;
  if (contradicted_time > kWrongHeadingTime) {
    // Then it is as uncertain as it is wrong.
    const Vector3d down = X.row(2).transpose();
    P.block<3, 3>(kTurn, kTurn) += heading * heading * down * down.transpose();
    weight = quality;
    contradicted_time = 0;
  }
  // A new field that stays.
  if (field_distance(figures, candidate) < 2) {
    steady_time += T;
  } else {
    steady_time = 0;
    candidate = figures;
  }
  const double follow = std::min(1.0, T / kNewFieldFollow);
  candidate.strength += follow * (figures.strength - candidate.strength);
  candidate.dip += follow * (figures.dip - candidate.dip);
  if (steady_time > kNewFieldTime && distance > 2) reference = candidate;
  // The first second is believed; after that the reference follows slowly what agrees with it.
  const double gain = weight * T / std::min(reference_age + T, kReferenceTime);
  reference.strength += gain * (figures.strength - reference.strength);
  reference.dip += gain * (figures.dip - reference.dip);
  reference_age += T;
  return weight;
}

void OrientationFilter::State::take_heading(double T) {
  const Vector3d field = X * field_sum;
  const double horizontal = std::hypot(field.x(), field.y());
  if (!(horizontal > 0)) return;
  const FieldFigures figures = field_figures(field);
  if (!has_field) {
    reference = candidate = figures;
    has_field = true;
  }
  const double deviation = options.heading_deviation.value_or(kUsualHeadingDeviation);
  const double heading = std::atan2(field.y(), field.x());
  Eigen::Matrix<double, 1, kUnknowns> H = Eigen::Matrix<double, 1, kUnknowns>::Zero();
  H.segment<3>(kTurn) = X.row(2);  // a turn about the vertical turns the field with it
  const double known = (H * P * H.transpose()).value();
  const double weight = trust_of(figures, heading, known + deviation * deviation, T);
  n_judged += 1;
  if (weight < 0.5) n_rejected += 1;
  using Scalar = Eigen::Matrix<double, 1, 1>;
  const double variance = deviation * deviation * kFieldCorrelation / T / std::max(weight, 1e-9);
  correct<1>(H, Scalar(variance), Scalar(-heading));
}

OrientationFilter::OrientationFilter(const OrientationOptions& options) : state_(std::make_unique<State>()) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  state_->options = options;
}
OrientationFilter::~OrientationFilter() = default;
OrientationFilter::OrientationFilter(OrientationFilter&&) noexcept = default;
OrientationFilter& OrientationFilter::operator=(OrientationFilter&&) noexcept = default;

std::optional<Eigen::Quaterniond> OrientationFilter::add(const InertialReading& reading) {
  State& state = *state_;
  if (!(reading.time >= state.time))
    throw InvalidInput(concat("the time of the readings falls from ", state.time, " to ", reading.time,
                              " seconds; readings must come in order"));
  Vector3d field = Vector3d::Constant(InertialReading::kMissing);
  if (state.options.magnetometer && reading.magnetometer.allFinite())
    field = state.options.calibration.magnetometer.apply(reading.magnetometer);
  state.advance(reading, field);
  if (!state.started) return std::nullopt;
  if (state.since.time >= kKnotInterval) state.finish_knot();
  const Eigen::Quaterniond q(Matrix3d(state.X * state.since.R));
  return q.normalized();
}

double OrientationFilter::tilt_deviation() const {
  const State& s = *state_;
  const Matrix3d world = s.X * s.P.block<3, 3>(kTurn, kTurn) * s.X.transpose();
  return std::sqrt(0.5 * (world(0, 0) + world(1, 1)));
}

double OrientationFilter::heading_deviation() const {
  const State& s = *state_;
  return std::sqrt((s.X.row(2) * s.P.block<3, 3>(kTurn, kTurn) * s.X.row(2).transpose()).value());
}

Vector3d OrientationFilter::gyroscope_bias() const {
  return state_->errors.gyroscope_bias;
}
Vector3d OrientationFilter::gyroscope_bias_deviation() const {
  return state_->P.diagonal().segment<3>(kBias).cwiseSqrt();
}
Vector3d OrientationFilter::accelerometer_bias() const {
  return state_->errors.accelerometer_bias;
}
double OrientationFilter::field_strength() const {
  return state_->reference.strength;
}
double OrientationFilter::inclination() const {
  return state_->reference.dip;
}
double OrientationFilter::magnetometer_rejected() const {
  return state_->n_judged > 0 ? state_->n_rejected / state_->n_judged : 0;
}
bool OrientationFilter::has_heading() const {
  return state_->has_field;
}

}  // namespace batten
