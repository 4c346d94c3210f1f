#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "batten/camera/rig_adjustment_detail.hpp"
#include "batten/core/index.hpp"
#include "batten/rotation/so3.hpp"

namespace batten::detail {

namespace {

constexpr int kCamera = 9;  // numbers of a camera
constexpr int kPose = 6;
constexpr int kMostSteps = 100;

double* number_of(Camera& camera, int index) {
  double* const numbers[kCamera] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &camera.k1,
                                    &camera.k2, &camera.k3, &camera.p1, &camera.p2};
  return numbers[index];
}

/// Whether a number of a camera is estimated.
bool is_estimated(int index, LensModel lens) {
  if (index == 6) return lens == LensModel::Full;    // k3
  if (index >= 7) return lens != LensModel::Radial;  // p1, p2
  return true;
}

/// ∂(u, v) by the nine numbers of the camera.
Eigen::Matrix<double, 2, kCamera> camera_jacobian(const Camera& camera, const Eigen::Vector3d& point,
                                                  LensModel lens) {
  const Eigen::Vector2d n = point.head<2>() / point.z();
  const Eigen::Vector2d d = distort(camera, n);
  const double x = n.x(), y = n.y(), s = n.squaredNorm();
  Eigen::Matrix<double, 2, kCamera> J;
  J.row(0) << d.x(), 0, 1, 0, x * s, x * s * s, x * s * s * s, 2 * x * y, s + 2 * x * x;
  J.row(1) << 0, d.y(), 0, 1, y * s, y * s * s, y * s * s * s, s + 2 * y * y, 2 * x * y;
  J.row(0).tail<5>() *= camera.fx;
  J.row(1).tail<5>() *= camera.fy;
  for (int i = 0; i < kCamera; ++i)
    if (!is_estimated(i, lens)) J.col(i).setZero();
  return J;
}

Eigen::Vector3d in_camera(const Board& board, const RigState& state, const Sighting& sighting) {
  const BoardPose& pose = state.poses[at(sighting.pair)];
  const Eigen::Vector3d left = pose.rotation * board.corner(sighting.corner) + pose.translation;
  return sighting.right ? Eigen::Vector3d(state.rig.rotation * left + state.rig.translation) : left;
}

double huber_cost(double distance, double huber) {
  return distance <= huber ? distance * distance : huber * (2 * distance - huber);
}

double cost_of(const Board& board, const std::vector<Sighting>& sightings, const RigState& state,
               double huber) {
  double cost = 0;
  for (const Sighting& sighting : sightings) cost += huber_cost(residual_of(board, state, sighting), huber);
  return cost;
}

/// Gauss–Newton's normal equations: A of the rig, one block per pose, and what couples them.
struct Normal {
  Eigen::Matrix<double, kRigParameters, kRigParameters> A;
  Eigen::Matrix<double, kRigParameters, 1> a;
  std::vector<Eigen::Matrix<double, kPose, kPose>> B;
  std::vector<Eigen::Matrix<double, kPose, 1>> b;
  std::vector<Eigen::Matrix<double, kRigParameters, kPose>> C;
  double weights = 0;  ///< sum over the residuals, two per sighting
};

Normal normal_equations(const Board& board, const std::vector<Sighting>& sightings, const RigState& state,
                        LensModel lens, double huber) {
  Normal normal;
  normal.A.setZero();
  normal.a.setZero();
  normal.B.assign(state.poses.size(), Eigen::Matrix<double, kPose, kPose>::Zero());
  normal.b.assign(state.poses.size(), Eigen::Matrix<double, kPose, 1>::Zero());
  normal.C.assign(state.poses.size(), Eigen::Matrix<double, kRigParameters, kPose>::Zero());
  for (const Sighting& sighting : sightings) {
    const Camera& camera = sighting.right ? state.rig.right : state.rig.left;
    const BoardPose& pose = state.poses[at(sighting.pair)];
    const Eigen::Vector3d turned = pose.rotation * board.corner(sighting.corner);
    const Eigen::Vector3d point = in_camera(board, state, sighting);
    Eigen::Matrix<double, 2, 3> by_point;
    const Eigen::Vector2d r = project(camera, point, &by_point) - sighting.pixel;
    const double distance = r.norm();
    const double weight = distance <= huber ? 1 : huber / distance;

    Eigen::Matrix<double, 2, kRigParameters> J = Eigen::Matrix<double, 2, kRigParameters>::Zero();
    J.middleCols<kCamera>(sighting.right ? kCamera : 0) = camera_jacobian(camera, point, lens);
    Eigen::Matrix<double, 2, 3> by_left = by_point;
    if (sighting.right) {
      J.middleCols<3>(2 * kCamera) = -by_point * hat(point - state.rig.translation);
      J.rightCols<3>() = by_point;
      by_left = by_point * state.rig.rotation;
    }
    Eigen::Matrix<double, 2, kPose> P;
    P << -by_left * hat(turned), by_left;

    const std::size_t k = at(sighting.pair);
    normal.A.noalias() += weight * J.transpose() * J;
    normal.a.noalias() += weight * J.transpose() * r;
    normal.B[k].noalias() += weight * P.transpose() * P;
    normal.b[k].noalias() += weight * P.transpose() * r;
    normal.C[k].noalias() += weight * J.transpose() * P;
    normal.weights += 2 * weight;
  }
  // What is not estimated has a row of zeros: it gets a one, and does not move.
  for (int i = 0; i < kRigParameters; ++i)
    if (normal.A(i, i) == 0) normal.A(i, i) = 1;
  return normal;
}

RigState moved(const RigState& state, const Eigen::VectorXd& rig_step,
               const std::vector<Eigen::Matrix<double, kPose, 1>>& pose_steps) {
  RigState next = state;
  for (int i = 0; i < kCamera; ++i) {
    *number_of(next.rig.left, i) += rig_step[i];
    *number_of(next.rig.right, i) += rig_step[kCamera + i];
  }
  next.rig.rotation = so3_exp(rig_step.segment<3>(2 * kCamera)) * state.rig.rotation;
  next.rig.translation += rig_step.tail<3>();
  for (std::size_t k = 0; k < next.poses.size(); ++k) {
    next.poses[k].rotation = so3_exp(pose_steps[k].head<3>()) * state.poses[k].rotation;
    next.poses[k].translation += pose_steps[k].tail<3>();
  }
  return next;
}

/// The state after a damped step: poses eliminated block by block.
RigState stepped(const RigState& state, const Normal& normal, double damping) {
  Eigen::MatrixXd S = normal.A;
  S.diagonal() += damping * normal.A.diagonal();
  Eigen::VectorXd s = normal.a;
  std::vector<Eigen::LDLT<Eigen::Matrix<double, kPose, kPose>>> factors;
  for (std::size_t k = 0; k < state.poses.size(); ++k) {
    Eigen::Matrix<double, kPose, kPose> B = normal.B[k];
    B.diagonal() *= 1 + damping;
    factors.emplace_back(B);
    S.noalias() -= normal.C[k] * factors[k].solve(normal.C[k].transpose());
    s.noalias() -= normal.C[k] * factors[k].solve(normal.b[k]);
  }
  const Eigen::VectorXd rig_step = -S.ldlt().solve(s);
  std::vector<Eigen::Matrix<double, kPose, 1>> pose_steps;
  for (std::size_t k = 0; k < state.poses.size(); ++k)
    pose_steps.emplace_back(-factors[k].solve(normal.b[k] + normal.C[k].transpose() * rig_step));
  return moved(state, rig_step, pose_steps);
}

}  // namespace

double residual_of(const Board& board, const RigState& state, const Sighting& sighting) {
  const Eigen::Vector3d point = in_camera(board, state, sighting);
  if (!(point.z() > 0)) return std::numeric_limits<double>::infinity();
  const Camera& camera = sighting.right ? state.rig.right : state.rig.left;
  const double distance = (project(camera, point) - sighting.pixel).norm();
  return std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
}

Adjustment adjust(const Board& board, const std::vector<Sighting>& sightings, const RigState& start,
                  LensModel lens, double huber) {
  Adjustment result;
  result.state = start;
  for (Camera* camera : {&result.state.rig.left, &result.state.rig.right})
    for (int i = 0; i < kCamera; ++i)
      if (!is_estimated(i, lens)) *number_of(*camera, i) = 0;
  result.cost = cost_of(board, sightings, result.state, huber);
  double damping = 1e-3;
  while (result.iterations < kMostSteps && !result.converged) {
    ++result.iterations;
    const Normal normal = normal_equations(board, sightings, result.state, lens, huber);
    bool better = false;
    for (; damping < 1e12; damping *= 10) {
      RigState next = stepped(result.state, normal, damping);
      const double cost = cost_of(board, sightings, next, huber);
      if (!(cost < result.cost)) continue;
      better = true;
      // Sums of thousands of squares are exact to some 1e-13 of themselves; below that steps are rounding.
      result.converged = result.cost - cost < 1e-12 * result.cost;
      result.state = std::move(next);
      result.cost = cost;
      damping = std::max(damping / 10, 1e-12);
      break;
    }
    if (!better) result.converged = true;
  }
  return result;
}

Eigen::MatrixXd covariance(const Board& board, const std::vector<Sighting>& sightings, const RigState& state,
                           LensModel lens, double huber) {
  const Normal normal = normal_equations(board, sightings, state, lens, huber);
  Eigen::MatrixXd S = normal.A;
  for (std::size_t k = 0; k < state.poses.size(); ++k)
    S -= normal.C[k] * normal.B[k].ldlt().solve(normal.C[k].transpose());
  int unknowns = static_cast<int>(state.poses.size()) * kPose;
  // Numbers of very different size: the inverse is taken of a matrix with ones on its diagonal.
  const Eigen::VectorXd scale = S.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd C = scale.asDiagonal() *
                      Eigen::MatrixXd(scale.asDiagonal() * S * scale.asDiagonal())
                          .ldlt()
                          .solve(Eigen::MatrixXd::Identity(kRigParameters, kRigParameters)) *
                      scale.asDiagonal();
  for (int i = 0; i < kRigParameters; ++i) {
    if (i >= 2 * kCamera || is_estimated(i % kCamera, lens)) {
      ++unknowns;
      continue;
    }
    C.row(i).setZero();
    C.col(i).setZero();
  }
  double squares = 0;
  for (const Sighting& sighting : sightings) {
    const double distance = residual_of(board, state, sighting);
    squares += distance * std::min(distance, huber);  // weight × square
  }
  return C * (squares / std::max(1.0, normal.weights - unknowns));
}

}  // namespace batten::detail
