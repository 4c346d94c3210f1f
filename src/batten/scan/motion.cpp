#include "batten/rotation/so3.hpp"
#include "batten/scan/motion_detail.hpp"

namespace batten {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Eigen::Matrix<double, InertialErrors::kCount, 1> InertialErrors::vector() const {
  Eigen::Matrix<double, kCount, 1> all;
  all << gyroscope_bias, gyroscope_matrix.reshaped(), accelerometer_bias;
  return all;
}

Motion Motion::corrected(const Eigen::Matrix<double, InertialErrors::kCount, 1>& difference) const {
  Motion other = *this;
  other.R = R * so3_exp(R_by * difference);
  other.v += v_by * difference;
  other.p += p_by * difference;
  return other;
}

void Motion::append_gap(double dt) {
  time += dt;
  turn_known = force_known = false;
}

void Motion::append_turn(double dt, const Vector3d& rate_before, const Vector3d& rate_after,
                         const InertialErrors& errors) {
  const Vector3d none = errors.accelerometer_bias;
  append(dt, rate_before, rate_after, none, none, errors);
  force_known = false;
}

void Motion::append(double dt, const Vector3d& rate_before, const Vector3d& rate_after,
                    const Vector3d& force_before, const Vector3d& force_after, const InertialErrors& errors) {
  constexpr int kBias = InertialErrors::kBias, kMatrix = InertialErrors::kMatrix,
                kForce = InertialErrors::kForce;
  const Matrix3d scale = Matrix3d::Identity() + errors.gyroscope_matrix;
  const Vector3d reading = 0.5 * (rate_before + rate_after) - errors.gyroscope_bias;
  const Vector3d u = dt * (scale * reading);
  const Matrix3d E = so3_exp(u), J = so3_right_jacobian(u);
  const Vector3d a = force_before - errors.accelerometer_bias, b = force_after - errors.accelerometer_bias;
  // ΔR a at the start, with its derivative −ΔR a^ R_by.
  const Vector3d f0 = R * a;
  Derivative f0_by = -(R * hat(a)) * R_by;
  f0_by.middleCols<3>(kForce) -= R;

  Derivative u_by = Derivative::Zero();
  u_by.middleCols<3>(kBias) = -dt * scale;
  for (int column = 0; column < 3; ++column)
    u_by.middleCols<3>(kMatrix + 3 * column) = (dt * reading[column]) * Matrix3d::Identity();
  R_by = E.transpose() * R_by + J * u_by;
  R *= E;

  const Vector3d f1 = R * b;
  Derivative f1_by = -(R * hat(b)) * R_by;
  f1_by.middleCols<3>(kForce) -= R;
  p += dt * v + dt * dt / 6 * (2 * f0 + f1);
  p_by += dt * v_by + dt * dt / 6 * (2 * f0_by + f1_by);
  v += dt / 2 * (f0 + f1);
  v_by += dt / 2 * (f0_by + f1_by);
  turned += u.norm();
  time += dt;
}

SensorStream filled_stream(const Points& readings, const Eigen::VectorXd& time, double longest_gap) {
  const Eigen::Index n = time.size();
  SensorStream stream{Points::Zero(n, 3), std::vector<char>(static_cast<size_t>(n), 0)};
  const auto take = [&](Eigen::Index row, const Eigen::RowVector3d& value) {
    stream.values.row(row) = value;
    stream.known[static_cast<size_t>(row)] = 1;
  };
  Eigen::Index last = -1;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!readings.row(i).allFinite()) continue;
    take(i, readings.row(i));
    const Eigen::Index from = last < 0 ? 0 : last + 1;
    for (Eigen::Index k = from; k < i; ++k) {
      // Before the first reading there is that one alone.
      const double gap = last < 0 ? time[i] - time[k] : time[i] - time[last];
      if (gap > longest_gap) continue;
      const double s = last < 0 || gap <= 0 ? 1 : (time[k] - time[last]) / gap;
      take(k, last < 0 ? Eigen::RowVector3d(readings.row(i))
                       : Eigen::RowVector3d((1 - s) * readings.row(last) + s * readings.row(i)));
    }
    last = i;
  }
  if (last < 0) return stream;
  for (Eigen::Index k = last + 1; k < n && time[k] - time[last] <= longest_gap; ++k)
    take(k, readings.row(last));
  return stream;
}

}  // namespace batten
