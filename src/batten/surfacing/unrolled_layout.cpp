#include <cmath>
#include <map>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/surfacing/layout_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::RowVector3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Newton steps towards a closed outline; some five are needed.
constexpr int kClosingSteps = 60;
/// The outline is closed when its ends lie within this part of its length.
constexpr double kClosed = 1e-12;

/// Edge i runs from vertex i to the next; turn i is the angle to the left at vertex i.
struct Outline {
  std::vector<double> lengths, turns;
};

/// Angle from `in` to `out`, seen against the normal.
double turning_angle(const RowVector3d& in, const RowVector3d& out, const RowVector3d& normal) {
  const RowVector3d a = in - in.dot(normal) * normal, b = out - out.dot(normal) * normal;
  return std::atan2(a.cross(b).dot(normal), a.dot(b));
}

/// The same outline walked the other way, as its mirror image shows it: the interior stays to the left.
Outline reversed(const Outline& outline) {
  const std::size_t n = outline.lengths.size();
  Outline mirror = outline;
  for (std::size_t i = 0; i < n; ++i) {
    mirror.lengths[i] = outline.lengths[n - 1 - i];
    mirror.turns[i] = outline.turns[(n - i) % n];
  }
  return mirror;
}

bool runs_before(const Outline& a, const Outline& b) {
  for (std::size_t i = 0; i < a.lengths.size(); ++i) {
    const auto difference = [](double x, double y) {
      return std::llround(x / kGrid) - std::llround(y / kGrid);
    };
    if (const long long d = difference(a.lengths[i], b.lengths[i]); d != 0) return d < 0;
    if (const long long d = difference(a.turns[i], b.turns[i]); d != 0) return d < 0;
  }
  return false;
}

/// Corners of the outline from the origin along x; the last entry closes it.
std::vector<Vector2d> corners_of(const Outline& outline, const Eigen::VectorXd& changes) {
  std::vector<Vector2d> corners = {Vector2d::Zero()};
  double direction = 0;
  for (std::size_t i = 0; i < outline.lengths.size(); ++i) {
    if (i > 0) direction += outline.turns[i] + changes[static_cast<Eigen::Index>(i)];
    corners.push_back(corners.back() +
                      outline.lengths[i] * Vector2d(std::cos(direction), std::sin(direction)));
  }
  return corners;
}

/// The changes of the turns with the least Σ δ² / s that close the outline (three conditions): Gauss–Newton
/// on the conditions, halving steps that lead away.
std::optional<std::vector<Vector2d>> closed_corners(const Outline& outline) {
  const auto n = static_cast<Eigen::Index>(outline.lengths.size());
  Eigen::VectorXd weights(n), changes = Eigen::VectorXd::Zero(n);
  double length = 0, turn = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    weights[i] = 0.5 * (outline.lengths[at(i)] + outline.lengths[at(i == 0 ? n - 1 : i - 1)]);
    length += outline.lengths[at(i)];
    turn += outline.turns[at(i)];
  }
  changes = weights * ((2 * kPi - turn) / weights.sum());
  std::vector<Vector2d> corners = corners_of(outline, changes);
  const auto missed = [&](const std::vector<Vector2d>& x, const Eigen::VectorXd& d) {
    return Vector3d(length * (turn + d.sum() - 2 * kPi), x.back().x(), x.back().y());
  };
  Vector3d gap = missed(corners, changes);
  for (int step = 0; step < kClosingSteps && gap.norm() > kClosed * length; ++step) {
    Eigen::Matrix3Xd J(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Vector2d rest = i == 0 ? Vector2d(0, 0) : Vector2d(corners.back() - corners[at(i)]);
      J.col(i) = Vector3d(length, -rest.y(), rest.x());
    }
    const Eigen::Matrix3d normal = J * weights.asDiagonal() * J.transpose();
    const Vector3d multipliers = normal.ldlt().solve(J * changes - gap);
    if (!multipliers.allFinite()) return std::nullopt;
    const Eigen::VectorXd way = weights.asDiagonal() * (J.transpose() * multipliers) - changes;
    double part = 1;
    for (; part > 1e-3; part *= 0.5) {
      const Eigen::VectorXd tried = changes + part * way;
      const std::vector<Vector2d> x = corners_of(outline, tried);
      if (missed(x, tried).norm() >= gap.norm()) continue;
      changes = tried;
      corners = x;
      gap = missed(corners, changes);
      break;
    }
    if (part <= 1e-3) break;
  }
  if (!(gap.norm() <= 1e-8 * length)) return std::nullopt;
  return corners;
}

}  // namespace

double on_grid(double x) {
  return std::round(x / kGrid) * kGrid;
}

std::size_t intrinsic_start(const ScaledNetwork& network, const std::vector<int>& loop,
                            const RowVector3d& centre, double unit) {
  const auto n = static_cast<std::ptrdiff_t>(loop.size());
  const auto key = [&](std::ptrdiff_t i, std::ptrdiff_t reach) {
    const auto distance = [&](std::ptrdiff_t j) {
      return (network.positions.row(loop[static_cast<std::size_t>(((j % n) + n) % n)]) - centre).norm();
    };
    // In units that a rotation keeps (the scale of the network is that of its box): near ties, frequent on
    // symmetric networks with rounded coordinates, then stay as they were.
    return std::llround((distance(i - reach) + distance(i + reach)) / (unit * kGrid));
  };
  std::ptrdiff_t best = 0;
  for (std::ptrdiff_t i = 1; i < n; ++i)
    for (const std::ptrdiff_t reach :
         {std::ptrdiff_t{0}, std::ptrdiff_t{1}, std::ptrdiff_t{2}, n / 5, n / 3}) {
      const long long a = key(i, reach), b = key(best, reach);
      if (a > b) best = i;
      if (a != b) break;
    }
  return static_cast<std::size_t>(best);
}

std::optional<LaidOut> lay_out_unrolled(const ScaledNetwork& network, const NetworkCycle& cycle,
                                        double unit) {
  const std::vector<int>& loop = cycle.loops.front().vertices;
  const std::size_t n = loop.size();
  RowVector3d centre = RowVector3d::Zero();
  for (const int v : loop) centre += network.positions.row(v) / static_cast<double>(n);
  const std::size_t start = intrinsic_start(network, loop, centre, unit);
  const auto position = [&](std::size_t i) -> RowVector3d {
    return network.positions.row(loop[(start + i) % n]);
  };
  Outline outline;
  for (std::size_t i = 0; i < n; ++i) {
    const RowVector3d in = position(i) - position(i + n - 1), out = position(i + 1) - position(i);
    outline.lengths.push_back(out.norm() / unit);
    outline.turns.push_back(turning_angle(in, out, network.normals.row(loop[(start + i) % n])));
  }
  LaidOut laid_out;
  const Outline mirror = reversed(outline);
  laid_out.mirrored = runs_before(mirror, outline);
  const auto corners = closed_corners(laid_out.mirrored ? mirror : outline);
  if (!corners) return std::nullopt;
  std::map<int, int> local;
  laid_out.region.corners.resize(static_cast<Eigen::Index>(n), 2);
  laid_out.region.loops.emplace_back();
  for (std::size_t i = 0; i < n; ++i) {
    const int v = loop[(start + (laid_out.mirrored ? n - i : i)) % n];
    const auto [place, is_new] = local.emplace(v, static_cast<int>(local.size()));
    if (is_new) laid_out.network_vertices.push_back(v);
    laid_out.vertex_of_corner.push_back(place->second);
    laid_out.region.loops.back().push_back(static_cast<int>(i));
    laid_out.region.corners.row(static_cast<Eigen::Index>(i)) << on_grid((*corners)[i].x()),
        on_grid((*corners)[i].y());
  }
  return laid_out;
}

}  // namespace batten::detail
