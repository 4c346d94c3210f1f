#include "batten/implicit/slope_search.hpp"

#include <cmath>
#include <vector>

#include "batten/core/random.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

constexpr int kAngles = 32;      // tried at a site before the best is made exact
constexpr int kNewtonSteps = 4;  // that make it exact
constexpr int kMostSweeps = 120;
constexpr double kLeastGain = 1e-5;  // of the energy, in a sweep that is not the last
constexpr int kSmoothStarts = 3;
constexpr int kPowerSteps = 40;

/// The angle a that makes u = (cos a, sin a) least in uᵀ D u + 2 hᵀ u.
double best_angle(const Eigen::Matrix2d& D, const Eigen::Vector2d& h) {
  double best = 0, least = 0;
  for (int k = 0; k < kAngles; ++k) {
    const double a = 2 * kPi * k / kAngles;
    const Eigen::Vector2d u(std::cos(a), std::sin(a));
    const double e = u.dot(D * u) + 2 * h.dot(u);
    if (k == 0 || e < least) {
      least = e;
      best = a;
    }
  }
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Eigen::Vector2d u(std::cos(best), std::sin(best)), t(-u[1], u[0]);
    const double first = 2 * t.dot(D * u + h);
    const double second = 2 * (t.dot(D * t) - u.dot(D * u + h));
    if (!(second > 0)) break;
    best -= first / second;
  }
  return best;
}

/// Pairs scaled to length 1; pairs without length point along the first direction.
Eigen::VectorXd unit_pairs(const Eigen::VectorXd& pairs) {
  Eigen::VectorXd units = pairs;
  for (Eigen::Index j = 0; j + 1 < units.size(); j += 2) {
    const double length = units.segment<2>(j).norm();
    if (length > 0)
      units.segment<2>(j) /= length;
    else
      units.segment<2>(j) = Eigen::Vector2d(1, 0);
  }
  return units;
}

/// The smoothest slopes, as the eigenvectors of the largest eigenvalues of H⁻¹, by powers of it.
std::vector<Eigen::VectorXd> smoothest_slopes(const Eigen::MatrixXd& inverse) {
  Random random(1);
  Eigen::MatrixXd V(inverse.rows(), kSmoothStarts);
  for (Eigen::Index j = 0; j < V.cols(); ++j)
    for (Eigen::Index i = 0; i < V.rows(); ++i) V(i, j) = random.normal();
  for (int step = 0; step < kPowerSteps; ++step) {
    V = (inverse * V).eval();
    for (Eigen::Index j = 0; j < V.cols(); ++j) {
      for (Eigen::Index k = 0; k < j; ++k) V.col(j) -= V.col(k).dot(V.col(j)) * V.col(k);
      V.col(j).normalize();
    }
  }
  std::vector<Eigen::VectorXd> starts;
  for (Eigen::Index j = 0; j < V.cols(); ++j) starts.emplace_back(V.col(j));
  return starts;
}

}  // namespace

FoundSlopes descended_slopes(const SlopeEnergy& energy, const Eigen::VectorXd& start) {
  const Eigen::MatrixXd& H = energy.hessian();
  FoundSlopes found;
  found.starts = 1;
  found.slopes = unit_pairs(start);
  Eigen::VectorXd half_gradient = H * found.slopes + energy.pull();
  const auto energy_now = [&] { return found.slopes.dot(half_gradient + energy.pull()); };
  found.energy = energy_now();
  for (; found.sweeps < kMostSweeps; ++found.sweeps) {
    for (Eigen::Index j = 0; j + 1 < H.rows(); j += 2) {
      const Eigen::Matrix2d D = H.block<2, 2>(j, j);
      const Eigen::Vector2d u = found.slopes.segment<2>(j);
      const Eigen::Vector2d h = half_gradient.segment<2>(j) - D * u;
      const double a = best_angle(D, h);
      const Eigen::Vector2d change = Eigen::Vector2d(std::cos(a), std::sin(a)) - u;
      half_gradient.noalias() += H.middleCols<2>(j) * change;
      found.slopes.segment<2>(j) += change;
    }
    const double now = energy_now();
    const bool is_last = !(found.energy - now > kLeastGain * std::abs(now));
    found.energy = now;
    if (is_last) break;
  }
  return found;
}

FoundSlopes find_slopes(const SlopeEnergy& energy, const Progress& progress) {
  FoundSlopes best;
  if (energy.n_slopes() == 0) return best;
  std::vector<Eigen::VectorXd> starts;
  const bool has_sides = energy.pull().squaredNorm() > 0;
  if (has_sides) starts.push_back(energy.slopes_of_values());
  for (const Eigen::VectorXd& smooth : smoothest_slopes(energy.inverse())) {
    starts.push_back(smooth);
    if (has_sides) starts.push_back(-smooth);
  }
  for (std::size_t k = 0; k < starts.size(); ++k) {
    progress.report("normals", static_cast<double>(k) / static_cast<double>(starts.size()));
    FoundSlopes found = descended_slopes(energy, starts[k]);
    if (k == 0 || found.energy < best.energy) best = std::move(found);
  }
  best.starts = static_cast<int>(starts.size());
  return best;
}

}  // namespace batten
