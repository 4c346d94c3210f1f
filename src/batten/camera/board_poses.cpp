#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "batten/camera/board_poses_detail.hpp"
#include "batten/core/index.hpp"
#include "batten/rotation/so3.hpp"

namespace batten::detail {

namespace {

/// Moves points to their mean and scales them to a mean distance of √2.
Eigen::Matrix3d normalisation(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  double distance = 0;
  for (const Eigen::Vector2d& p : points) distance += (p - mean).norm() / static_cast<double>(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1;
  Eigen::Matrix3d T;
  T << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return T;
}

/// Corners of the convex hull, counter-clockwise (Andrew's chains [andrew1979]).
std::vector<Eigen::Vector2d> convex_hull(const BoardCorners& corners) {
  std::vector<Eigen::Vector2d> points, hull;
  for (Eigen::Index i = 0; i < corners.rows(); ++i)
    if (corners.row(i).allFinite()) points.emplace_back(corners.row(i).transpose());
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  const auto turns_left = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()) > 0;
  };
  for (int chain = 0; chain < 2; ++chain) {
    const std::size_t first = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= first + 2 && !turns_left(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool is_inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d a = hull[i], edge = hull[(i + 1) % hull.size()] - a;
    if (edge.x() * (p.y() - a.y()) - edge.y() * (p.x() - a.x()) < 0) return false;
  }
  return hull.size() >= 3;
}

}  // namespace

std::optional<Eigen::Matrix3d> homography(const Board& board, const BoardCorners& corners) {
  std::vector<Eigen::Vector2d> from, to;
  for (Eigen::Index i = 0; i < corners.rows(); ++i) {
    if (!corners.row(i).allFinite()) continue;
    from.emplace_back(board.corner(static_cast<int>(i)).head<2>());
    to.emplace_back(corners.row(i).transpose());
  }
  if (from.size() < 4) return {};
  const Eigen::Matrix3d T_from = normalisation(from), T_to = normalisation(to);
  // Normal matrix of the linear system: nine unknowns, two rows per corner.
  Eigen::Matrix<double, 9, 9> N = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = T_from * from[i].homogeneous();
    const Eigen::Vector3d q = T_to * to[i].homogeneous();
    Eigen::Matrix<double, 2, 9> A = Eigen::Matrix<double, 2, 9>::Zero();
    A.block<1, 3>(0, 0) = p.transpose();
    A.block<1, 3>(0, 6) = -q.x() * p.transpose();
    A.block<1, 3>(1, 3) = p.transpose();
    A.block<1, 3>(1, 6) = -q.y() * p.transpose();
    N += A.transpose() * A;
  }
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(N, Eigen::ComputeFullV);
  // Corners on one line leave more than one solution.
  if (!(svd.singularValues()[7] > 1e-6 * svd.singularValues()[0])) return {};
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Eigen::Matrix3d H;
  H << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
  H = T_to.inverse() * H * T_from;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : from) middle += p / static_cast<double>(from.size());
  return H.row(2).dot(middle.homogeneous()) < 0 ? Eigen::Matrix3d(-H) : H;
}

std::optional<double> focal_length(const std::vector<Eigen::Matrix3d>& homographies, int width, int height) {
  // With the principal point at the origin the image of the absolute conic is diag(1/f², 1/f², 1): every
  // homography gives two equations a / f² + b = 0.
  const double unit = width;  // lengths near one
  Eigen::Matrix3d T;
  T << 1 / unit, 0, -width / 2.0 / unit, 0, 1 / unit, -height / 2.0 / unit, 0, 0, 1;
  double ab = 0, aa = 0;
  for (const Eigen::Matrix3d& given : homographies) {
    Eigen::Matrix3d H = T * given;
    H /= H.leftCols<2>().norm();
    const Eigen::Vector3d h = H.col(0), g = H.col(1);
    const double a[2] = {h.head<2>().dot(g.head<2>()), h.head<2>().squaredNorm() - g.head<2>().squaredNorm()};
    const double b[2] = {h.z() * g.z(), h.z() * h.z() - g.z() * g.z()};
    for (int k = 0; k < 2; ++k) {
      ab += a[k] * b[k];
      aa += a[k] * a[k];
    }
  }
  const double f = unit * std::sqrt(-aa / ab);
  if (!(f > 0.1 * width && f < 30.0 * width)) return {};
  return f;
}

BoardPose pose_from_homography(const Camera& camera, const Eigen::Matrix3d& homography) {
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  const Eigen::Matrix3d M = K.inverse() * homography;
  const double scale = 2 / (M.col(0).norm() + M.col(1).norm());
  Eigen::Matrix3d R;
  R.col(0) = scale * M.col(0);
  R.col(1) = scale * M.col(1);
  R.col(2) = R.col(0).cross(R.col(1));
  return {.rotation = nearest_rotation(R), .translation = scale * M.col(2)};
}

double coverage(const std::vector<const BoardCorners*>& views, int width, int height) {
  constexpr int kAcross = 64, kDown = 48;
  std::vector<std::vector<Eigen::Vector2d>> hulls;
  for (const BoardCorners* view : views) hulls.push_back(convex_hull(*view));
  int covered = 0;
  for (int i = 0; i < kAcross; ++i)
    for (int j = 0; j < kDown; ++j) {
      const Eigen::Vector2d p((i + 0.5) * width / kAcross, (j + 0.5) * height / kDown);
      covered +=
          std::any_of(hulls.begin(), hulls.end(), [&](const auto& hull) { return is_inside(hull, p); });
    }
  return covered / static_cast<double>(kAcross * kDown);
}

}  // namespace batten::detail
