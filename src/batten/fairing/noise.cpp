#include "batten/fairing/noise.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/random.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/neighbours_detail.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

namespace {

/// The deviation in the calmest regions, from the variance that every vertex shows by itself, whose local
/// means are squares of an expected 1 where there is white noise of deviation 1 alone.
double floor_of(Eigen::VectorXd variances, const fairing_detail::IndexLists& neighbours) {
  // Four means over the one-ring see some thirty vertices; two in a hundred of such regions of pure white
  // noise show less than 0.68 of it (0.66–0.70 on the meshes of docs/fair.md).
  constexpr int kPasses = 4;
  constexpr double kQuantile = 0.02, kShown = 0.68;
  const Eigen::Index n = variances.size();
  for (int pass = 0; pass < kPasses; ++pass) {
    Eigen::VectorXd means(n);
    parallel_for(n, 4096, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index v = begin; v < end; ++v) {
        double sum = variances[v];
        for (int i = neighbours.begin(v); i < neighbours.end(v); ++i) sum += variances[neighbours.indices[i]];
        means[v] = sum / (1 + neighbours.size(v));
      }
    });
    variances.swap(means);
  }
  const auto calm = variances.data() + static_cast<Eigen::Index>(kQuantile * static_cast<double>(n));
  std::nth_element(variances.data(), calm, variances.data() + n);
  return std::sqrt(*calm) / kShown;
}

void check_level(const char* name, double level) {
  if (!(level >= 0) || !std::isfinite(level))
    throw InvalidInput(concat("the noise ", name, " must be finite and at least 0, got ", level));
}

}  // namespace

double mean_edge_length(const Points& positions, const Triangles& triangles) {
  const fairing_detail::IndexLists neighbours =
      fairing_detail::vertex_neighbours(triangles, positions.rows());
  double sum = 0;
  Eigen::Index count = 0;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    for (int i = neighbours.begin(v); i < neighbours.end(v); ++i)
      if (const int u = neighbours.indices[i]; u > v) {
        sum += (positions.row(u) - positions.row(v)).norm();
        ++count;
      }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

Points add_gaussian_noise(const Points& positions, const Triangles& triangles, double level,
                          std::uint64_t seed) {
  check_level("level", level);
  const double deviation = level * mean_edge_length(positions, triangles);
  const Points normals = vertex_normals(positions, triangles);
  Random random(seed);
  Points noisy = positions;
  for (Eigen::Index v = 0; v < noisy.rows(); ++v)
    noisy.row(v) += deviation * random.normal() * normals.row(v);
  return noisy;
}

Points add_impulsive_noise(const Points& positions, const Triangles& triangles, double share, double level,
                           ImpulseKind kind, std::uint64_t seed) {
  check_level("level", level);
  if (!(share >= 0 && share <= 1))
    throw InvalidInput(concat("the share of vertices with noise must lie in 0 to 1, got ", share));
  const double length = level * mean_edge_length(positions, triangles);
  const Points normals = vertex_normals(positions, triangles);
  // Three streams: which vertices are hit does not depend on how they are moved.
  Random hits(seed, 0), amounts(seed, 1), directions(seed, 2);
  Points noisy = positions;
  for (Eigen::Index v = 0; v < noisy.rows(); ++v) {
    const bool hit = hits.uniform() < share;
    const double amount = kind == ImpulseKind::NormalGaussian ? amounts.normal()
                          : amounts.uniform() < 0.5           ? -1.0
                                                              : 1.0;
    const Eigen::Vector3d direction = directions.direction();
    if (!hit) continue;
    if (kind == ImpulseKind::RandomDirection)
      noisy.row(v) += length * direction.transpose();
    else
      noisy.row(v) += length * amount * normals.row(v);
  }
  return noisy;
}

Points add_thesis_noise(const Points& positions, const Triangles& triangles, double normal_level,
                        double random_level, std::uint64_t seed) {
  check_level("level along the normals", normal_level);
  check_level("level in random directions", random_level);
  const double edge = mean_edge_length(positions, triangles);
  const Points normals = vertex_normals(positions, triangles);
  Random random(seed);
  Points noisy = positions;
  for (Eigen::Index v = 0; v < noisy.rows(); ++v) {
    const double c1 = random.uniform(-normal_level, normal_level);
    const double c2 = random.uniform(-random_level, random_level);
    noisy.row(v) += edge * (c1 * normals.row(v) + c2 * random.direction().transpose());
  }
  return noisy;
}

double noise_significance(double level, double doubt) {
  const double ramp = std::clamp((level - 0.05 - 0.1 * std::max(0.0, doubt)) / 0.03, 0.0, 1.0);
  return ramp * ramp * (3 - 2 * ramp);
}

NoiseEstimate estimate_noise(const Points& positions, const Triangles& triangles, const Progress& progress) {
  NoiseEstimate estimate;
  const Eigen::Index n = positions.rows();
  progress.report("noise", 0);
  const double edge = mean_edge_length(positions, triangles);
  if (!(edge > 0)) return estimate;
  const fairing_detail::IndexLists neighbours = fairing_detail::vertex_neighbours(triangles, n);
  const auto mean_of_neighbours = [&](const Points& field) {
    Points mean = Points::Zero(n, 3);
    parallel_for(n, 4096, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index v = begin; v < end; ++v) {
        for (int i = neighbours.begin(v); i < neighbours.end(v); ++i)
          mean.row(v) += field.row(neighbours.indices[i]);
        if (neighbours.size(v) > 0) mean.row(v) /= neighbours.size(v);
      }
    });
    return mean;
  };
  progress.report("noise", 0.4);
  // Noise tilts the normals, which would hide a part of it: smooth them twice.
  Points normals = vertex_normals(positions, triangles);
  for (int pass = 0; pass < 2; ++pass) normals += mean_of_neighbours(normals);
  const Points umbrella = positions - mean_of_neighbours(positions);
  const Points bi_umbrella = umbrella - mean_of_neighbours(umbrella);

  progress.report("noise", 0.6);
  const Eigen::VectorXd gains = fairing_detail::bi_umbrella_gains(neighbours);
  progress.report("noise", 0.8);
  std::vector<double> deviations;
  deviations.reserve(static_cast<std::size_t>(n));
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(n);
  for (Eigen::Index v = 0; v < n; ++v)
    if (const double length = normals.row(v).norm(); gains[v] > 0 && length > 0) {
      deviations.push_back(std::abs(bi_umbrella.row(v).dot(normals.row(v))) / (length * std::sqrt(gains[v])));
      variances[v] = deviations.back() * deviations.back();
    }
  if (deviations.empty()) return estimate;
  constexpr double kMedianOfHalfNormal = 0.67448975;
  estimate.level = upper_median(deviations) / kMedianOfHalfNormal / edge;
  estimate.significance = noise_significance(estimate.level, 0);
  estimate.floor = floor_of(std::move(variances), neighbours) / edge;
  return estimate;
}

}  // namespace batten
