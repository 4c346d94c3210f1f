#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/parallel.hpp"
#include "batten/fairing/fairer_detail.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten::fairing_detail {

using Eigen::Index;
using Eigen::RowVector3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kMostFidelity = 2.0;
/// λ of the moves across the normals. Where the filtered normals agree with where the vertices lie such moves
/// bring nothing; on edges that noise has bent sideways they straighten them.
constexpr double kSidewaysFidelity = 0.2;
constexpr int kMostNeighbours = 60;
/// Passes of ring means over the residual before it is judged: with fewer, chance looks like shape too often
/// and lets the noise there through; with more, small shapes go unnoticed.
constexpr int kResidualPasses = 8;
/// Relative residuals at which the refits stop: far below what the next round changes.
constexpr double kRefitTolerance = 1e-4, kFreeRefitTolerance = 1e-3;
constexpr int kMostRefitIterations = 100;

/// e^(−x) for x ≥ 0, within 3 % up to x = 4 and zero from 16 on: (1 − x/16)^16, which the compiler can turn
/// into vector instructions.
inline float falling(float x) {
  float y = std::max(0.0F, 1.0F - x * 0.0625F);
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

}  // namespace

Fairer::Fairer(const Points& noisy, const Triangles& triangles, std::vector<char> fixed,
               const Progress& progress)
    : triangles_(triangles),
      n_(noisy.rows()),
      m_(triangles.rows()),
      fields_(triangles, n_),
      fixed_(std::move(fixed)) {
  progress.report("preparation", 0);
  const std::vector<int> opposite = opposite_half_edges(triangles);
  progress.report("preparation", 0.2);
  const Points centroids = triangle_centroids(noisy, triangles);
  centroid_distance_ = mean_centroid_distance(centroids, opposite);
  closed_ = std::none_of(opposite.begin(), opposite.end(), [](int other) { return other < 0; });
  for (int k = 0; k < 2; ++k) {
    const double spatial = k == 0 ? kSharp.spatial : kOrganic.spatial;
    balls_[k] =
        triangle_balls(centroids, triangles, fields_.around(), 1.5 * spatial * centroid_distance_,
                       kMostNeighbours, progress.part("preparation", 0.3 + 0.35 * k, 0.65 + 0.35 * k));
  }
}

FairingRun Fairer::run(const Points& noisy, double deviation, bool refine, const Strategy& strategy,
                       int iterations, const Progress& progress) {
  FairingRun result;
  result.positions = noisy;
  result.moves = VectorXd::Zero(n_);
  VectorXd fidelity = VectorXd::Constant(n_, strategy.fidelity);
  const IndexLists& balls = balls_[strategy.spatial == kSharp.spatial ? 0 : 1];  // what they depend on
  const int rounds = iterations + strategy.free_iterations;
  for (int round = 0; round < rounds; ++round) {
    const Progress part =
        progress.part("fairing", static_cast<double>(round) / rounds, (round + 1.0) / rounds);
    part.report("filter", 0);
    const double range = strategy.range * (1 + strategy.range_start * std::exp(-0.5 * round));
    filter_normals(result.positions, balls, strategy.spatial * centroid_distance_, range);
    part.report("refit", 0.5);
    update_directions();
    if (round >= iterations) {
      result.solves.add(
          refit_freely(noisy, strategy, fidelity, result.positions, part.part("refit", 0.6, 1)));
      continue;
    }
    assemble(noisy, result.positions, strategy, fidelity);
    result.solves.add(solve(result.moves, part.part("refit", 0.6, 0.9)));
    result.positions = noisy + result.moves.asDiagonal() * directions_;
    if (round < 2) continue;
    part.report("residual", 0.9);
    if (refine) deviation = deviation_of(result.moves);
    adapt(result.moves / deviation, strategy, fidelity);
  }
  result.deviation = deviation;
  result.directions = directions_;
  return result;
}

double Fairer::deviation_of(const VectorXd& moves) {
  if (gains_.size() == 0) gains_ = bi_umbrella_gains(fields_.neighbours());
  const VectorXd rough = fields_.without_mean(fields_.without_mean(moves));
  double sum = 0;
  Index count = 0;
  for (Index v = 0; v < n_; ++v)
    if (gains_[v] > 0 && !fixed_[v]) {
      sum += rough[v] * rough[v] / gains_[v];
      ++count;
    }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

void Fairer::unfold(Points& positions, const Progress& progress) const {
  constexpr int kMostPasses = 10;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    progress.report("unfolding", static_cast<double>(pass) / kMostPasses);
    if (!unfold_once(positions)) return;
  }
}

bool Fairer::unfold_once(Points& positions) const {
  const IndexLists &around = fields_.around(), &neighbours = fields_.neighbours();
  const auto area_vector = [&](Index f) {
    const Vector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                   c = positions.row(triangles_(f, 2));
    return Vector3d((b - a).cross(c - a));
  };
  Points around_vertex = Points::Zero(n_, 3), facing(m_, 3);
  parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
    fields_.visit_corners(begin, end,
                          [&](Index v, Index f, int) { around_vertex.row(v) += area_vector(f).transpose(); });
  });
  std::vector<char> folded(static_cast<std::size_t>(m_));
  parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) {
      facing.row(f) = around_vertex.row(triangles_(f, 0)) + around_vertex.row(triangles_(f, 1)) +
                      around_vertex.row(triangles_(f, 2));
      folded[f] = facing.row(f).dot(area_vector(f)) < 0 ? 1 : 0;
    }
  });
  const auto update_folds_at = [&](int v) {
    int count = 0;
    for (int i = around.begin(v); i < around.end(v); ++i) {
      const int f = around.indices[i];
      folded[f] = facing.row(f).dot(area_vector(f)) < 0 ? 1 : 0;
      count += folded[f];
    }
    return count;
  };
  bool is_better = false;
  for (Index f = 0; f < m_; ++f)
    for (int k = 0; k < 3 && folded[f] != 0; ++k) {
      const int v = triangles_(f, k);
      const RowVector3d normal = around_vertex.row(v).normalized(), start = positions.row(v);
      if (fixed_[v]) continue;
      RowVector3d slide = -start * neighbours.size(v);
      for (int i = neighbours.begin(v); i < neighbours.end(v); ++i)
        slide += positions.row(neighbours.indices[i]);
      slide /= neighbours.size(v);
      slide -= slide.dot(normal) * normal;
      const int before = update_folds_at(v);
      int after = before;
      for (const double part : {1.0, 0.5, 0.25}) {
        positions.row(v) = start + part * slide;
        after = update_folds_at(v);
        if (after < before) break;
      }
      if (after < before) {
        is_better = true;
      } else {
        positions.row(v) = start;
        update_folds_at(v);
      }
    }
  return is_better;
}

void Fairer::measure_tilts(const Points& positions, double deviation) {
  tilts_.off_diagonal.assign(fields_.neighbours().indices.size(), 0.0);
  tilts_.diagonal = VectorXd::Zero(n_);
  Points weights(m_, 3);
  parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) {
      const RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                        c = positions.row(triangles_(f, 2));
      weights.row(f) =
          bounded_cotangents(positions, f, kOrganic) / ((b - a).cross(c - a).norm() + deviation * deviation);
    }
  });
  parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
    fields_.visit_corners(begin, end, [&](Index v, Index f, int corner) {
      for (int k = 0; k < 3; ++k) {
        if (k == corner) continue;
        tilts_.diagonal[v] += weights(f, k);
        tilts_.off_diagonal[fields_.slot(f, k, (k + 2) % 3 == corner)] -= weights(f, k);
      }
    });
  });
}

VectorXd Fairer::tilt(const VectorXd& field) const {
  VectorXd image;
  fields_.multiply(tilts_, field, image);
  return image;
}

void Fairer::filter_normals(const Points& positions, const IndexLists& balls, double spatial, double range) {
  features_.resize(8 * static_cast<std::size_t>(m_));
  filtered_.resize(m_, 3);
  // Single precision is enough for weights; the centre keeps it so wherever the mesh lies.
  const RowVector3d centre = positions.colwise().mean();
  const double scale = 1 / (std::sqrt(2.0) * spatial), normal_scale = 1 / (std::sqrt(2.0) * range);
  parallel_for(m_, 8192, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) {
      const RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                        c = positions.row(triangles_(f, 2));
      const RowVector3d normal = (b - a).cross(c - a), centroid = (a + b + c) / 3 - centre;
      const double length = normal.norm();
      float* feature = features_.data() + 8 * f;
      for (int k = 0; k < 3; ++k) {
        feature[k] = static_cast<float>(centroid[k] * scale);
        feature[3 + k] = length > 0 ? static_cast<float>(normal[k] / length * normal_scale) : 0.0F;
      }
      feature[6] = static_cast<float>(length * scale * scale);
    }
  });
  parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) {
      const float* own = features_.data() + 8 * f;
      float sum[3] = {0, 0, 0};
      for (int i = balls.begin(f); i < balls.end(f); ++i) {
        const float* other = features_.data() + 8 * static_cast<std::size_t>(balls.indices[i]);
        float exponent = 0;
        for (int k = 0; k < 6; ++k) {
          const float difference = own[k] - other[k];
          exponent += difference * difference;
        }
        const float weight = other[6] * falling(exponent);
        for (int k = 0; k < 3; ++k) sum[k] += weight * other[3 + k];
      }
      const Vector3d normal(sum[0], sum[1], sum[2]);
      const double length = normal.norm();
      filtered_.row(f) = length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
    }
  });
}

void Fairer::update_directions() {
  directions_.resize(n_, 3);
  const IndexLists& around = fields_.around();
  parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Vector3d sum = Vector3d::Zero();
      for (int i = around.begin(v); i < around.end(v); ++i) {
        const int f = around.indices[i];
        sum += static_cast<double>(features_[8 * static_cast<std::size_t>(f) + 6]) *
               filtered_.row(f).transpose();
      }
      const double length = sum.norm();
      directions_.row(v) = length > 0 ? Vector3d(sum / length) : Vector3d::Zero();
    }
  });
}

void Fairer::assemble(const Points& noisy, const Points& current, const Strategy& strategy,
                      const VectorXd& fidelity) {
  corners_.resize(m_, 9);
  parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) {
      const Vector3d normal = filtered_.row(f);
      corners_.block<1, 3>(f, 0) = bounded_cotangents(current, f, strategy);
      for (int k = 0; k < 3; ++k) {
        const int v = triangles_(f, k);
        corners_(f, 3 + k) = fixed_[v] ? 0 : normal.dot(directions_.row(v));
        corners_(f, 6 + k) = normal.dot(noisy.row(v));
      }
    }
  });
  refit_.off_diagonal.assign(fields_.neighbours().indices.size(), 0.0);
  refit_.diagonal = fidelity;
  right_ = VectorXd::Zero(n_);
  parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
    fields_.visit_corners(begin, end, [&](Index v, Index f, int corner) {
      const double *weights = corners_.data() + 9 * f, *slope = weights + 3, *height = weights + 6;
      for (int k = 0; k < 3; ++k) {
        if (k == corner) continue;
        const int a = (k + 1) % 3, b = (k + 2) % 3;  // the edge opposite corner k
        const double weight = weights[k], difference = height[a] - height[b];
        refit_.diagonal[v] += weight * slope[corner] * slope[corner];
        refit_.off_diagonal[fields_.slot(f, k, corner == b)] -= weight * slope[a] * slope[b];
        if (corner == a)
          right_[v] -= weight * slope[a] * difference;
        else
          right_[v] += weight * slope[b] * difference;
      }
    });
  });
}

IterativeReport Fairer::solve(VectorXd& moves, const Progress& progress) const {
  const LinearOperator product = [&](const VectorXd& x, VectorXd& y) { fields_.multiply(refit_, x, y); };
  IterativeOptions options;
  options.tolerance = kRefitTolerance;
  options.max_iterations = kMostRefitIterations;
  return solve_conjugate_gradients(product, refit_.diagonal, right_, moves, "refit to filtered normals",
                                   options, progress);
}

IterativeReport Fairer::refit_freely(const Points& noisy, const Strategy& strategy, const VectorXd& fidelity,
                                     Points& positions, const Progress& progress) {
  edge_weights_.resize(m_, 3);
  pulls_.resize(m_, 3);
  parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f) edge_weights_.row(f) = bounded_cotangents(positions, f, strategy);
  });
  using Rows = Eigen::Map<Points>;
  using ConstRows = Eigen::Map<const Points>;
  // Adds up what the triangles pull at vertex v.
  const auto pull_at = [&](Index v) {
    RowVector3d sum = RowVector3d::Zero();
    fields_.visit_corners(v, v + 1, [&](Index, Index f, int corner) {
      for (int k = 0; k < 3; ++k) {
        if (k == corner) continue;
        if ((k + 1) % 3 == corner)
          sum += pulls_(f, k) * filtered_.row(f);
        else
          sum -= pulls_(f, k) * filtered_.row(f);
      }
    });
    return sum;
  };
  const auto measure_pulls = [&](const auto& x) {
    parallel_for(m_, kTriangleGrain, [&](Index begin, Index end) {
      for (Index f = begin; f < end; ++f) {
        double height[3];
        for (int k = 0; k < 3; ++k) height[k] = filtered_.row(f).dot(x.row(triangles_(f, k)));
        for (int k = 0; k < 3; ++k)
          pulls_(f, k) = edge_weights_(f, k) * (height[(k + 1) % 3] - height[(k + 2) % 3]);
      }
    });
  };
  const LinearOperator product = [&](const VectorXd& entries, VectorXd& image) {
    const ConstRows x(entries.data(), n_, 3);
    Rows y(image.data(), n_, 3);
    measure_pulls(x);
    parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        if (fixed_[v]) {
          y.row(v).setZero();
          continue;
        }
        const double along = x.row(v).dot(directions_.row(v));
        y.row(v) = pull_at(v) + kSidewaysFidelity * x.row(v) +
                   (fidelity[v] - kSidewaysFidelity) * along * directions_.row(v);
      }
    });
  };
  VectorXd right = VectorXd::Zero(3 * n_), moves(3 * n_);
  measure_pulls(noisy);
  for (Index v = 0; v < n_; ++v)
    if (!fixed_[v]) right.segment<3>(3 * v) = -pull_at(v).transpose();
  Rows(moves.data(), n_, 3) = positions - noisy;
  IterativeOptions options;
  options.tolerance = kFreeRefitTolerance;
  options.max_iterations = kMostRefitIterations;
  const IterativeReport report = solve_conjugate_gradients(
      product, VectorXd::Ones(3 * n_), right, moves, "free refit to filtered normals", options, progress);
  positions = noisy + ConstRows(moves.data(), n_, 3);
  return report;
}

RowVector3d Fairer::bounded_cotangents(const Points& positions, Index f, const Strategy& strategy) const {
  const RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                    c = positions.row(triangles_(f, 2));
  const double twice_area = (b - a).cross(c - a).norm();
  if (!(twice_area > 0)) return RowVector3d::Constant(strategy.least_cotangent);
  return (RowVector3d((b - a).dot(c - a), (c - b).dot(a - b), (a - c).dot(b - c)) / twice_area)
      .cwiseMax(strategy.least_cotangent)
      .cwiseMin(strategy.most_cotangent);
}

void Fairer::adapt(const VectorXd& moves, const Strategy& strategy, VectorXd& fidelity) const {
  VectorXd excess = fields_.ring_mean(moves).cwiseAbs2();
  for (Index v = 0; v < n_; ++v) excess[v] *= 1 + fields_.neighbours().size(v);  // 1 for white noise
  for (int pass = 0; pass < kResidualPasses; ++pass) excess = fields_.ring_mean(excess);
  parallel_for(n_, kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v)
      fidelity[v] =
          std::clamp(fidelity[v] * std::pow(std::clamp(excess[v] / strategy.target, 0.1, 10.0), 0.3),
                     strategy.least_fidelity, kMostFidelity);
  });
}

}  // namespace batten::fairing_detail
