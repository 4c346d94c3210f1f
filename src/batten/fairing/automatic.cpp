#include "batten/fairing/automatic.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/neighbours_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using fairing_detail::IndexLists;

/// The parameters of one run. All lengths are in mean edge lengths or mean distances of centroids.
struct Strategy {
  const char* name;
  double spatial;  ///< s, in mean centroid distances
  double range;    ///< r, as a difference of unit normals
  double
      range_start;  ///< r is larger by this factor of itself in the first rounds, falling like e^(−round/2)
  double fidelity;  ///< λ at the start, where cotangents are 1
  double least_fidelity;
  double target;  ///< ratio of the averaged residual to white noise above which λ grows
  /// Cotangents in the refit are held within these bounds, so that slivers neither decouple nor rule. Tight
  /// bounds make it less dependent on angles that strong noise has made up, wide ones on how the surface was
  /// cut.
  double least_cotangent, most_cotangent;
  int iterations;
  int free_iterations;  ///< further rounds in which vertices may leave their normals
};

// Found on fandisk, cubehole, rocker arm and bunny with noise of 0.1, 0.2 and 0.3 mean edge lengths, the
// sharp one checked on mechpart, wingnut and casting; see docs/fair.md for the figures.
constexpr Strategy kSharp{"sharp", 2.0, 0.35, 0.5, 0.05, 0.02, 1.2, 0.3, 1.5, 12, 2};
constexpr Strategy kOrganic{"organic", 1.2, 0.45, 1.0, 0.15, 0.05, 1.0, 0.1, 3.0, 10, 0};
constexpr double kMostFidelity = 2.0;
/// λ of the moves across the normals. Where the filtered normals agree with where the vertices lie such moves
/// bring nothing; on edges that noise has bent sideways they straighten them.
constexpr double kSidewaysFidelity = 0.2;
constexpr int kMostNeighbours = 60;
/// Passes of ring means over the residual before it is judged: with fewer, chance looks like shape too often
/// and lets the noise there through; with more, small shapes go unnoticed.
constexpr int kResidualPasses = 8;
/// Robust standard deviations, of a distribution with long tails, by which a region's risk must speak against
/// the strategy of the whole mesh.
constexpr double kDoubt = 8;

/// e^(−x) for x ≥ 0, within 3 % up to x = 4 and zero from 16 on: (1 − x/16)^16, which the compiler can turn
/// into vector instructions.
inline float falling(float x) {
  float y = std::max(0.0F, 1.0F - x * 0.0625F);
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

/// The connectivity of a mesh and everything else that all runs share.
class Fairer {
 public:
  Fairer(const Points& noisy, const Triangles& triangles, std::vector<char> fixed, const Progress& progress)
      : triangles_(triangles),
        progress_(progress),
        n_(noisy.rows()),
        m_(triangles.rows()),
        around_(fairing_detail::triangles_of_vertices(triangles, n_)),
        neighbours_(fairing_detail::vertex_neighbours(triangles, n_)),
        fixed_(std::move(fixed)) {
    const std::vector<int> opposite = opposite_half_edges(triangles);
    const Points centroids = fairing_detail::triangle_centroids(noisy, triangles);
    centroid_distance_ = fairing_detail::mean_centroid_distance(centroids, opposite);
    closed_ = std::none_of(opposite.begin(), opposite.end(), [](int other) { return other < 0; });
    for (int k = 0; k < 2; ++k) {
      const double spatial = k == 0 ? kSharp.spatial : kOrganic.spatial;
      balls_[k] = fairing_detail::triangle_balls(centroids, triangles, around_,
                                                 1.5 * spatial * centroid_distance_, kMostNeighbours);
    }
    // The place of each directed edge (corner a → corner b of a triangle) in the lists of neighbours.
    slots_.resize(6 * static_cast<std::size_t>(m_));
    for (Eigen::Index f = 0; f < m_; ++f)
      for (int k = 0; k < 3; ++k) {
        const int i = triangles(f, (k + 1) % 3), j = triangles(f, (k + 2) % 3);
        slots_[6 * f + 2 * k] = slot(i, j);
        slots_[6 * f + 2 * k + 1] = slot(j, i);
      }
  }

  bool is_closed() const { return closed_; }
  const IndexLists& neighbours() const { return neighbours_; }

  struct Run {
    Points positions, directions;
    VectorXd moves;        ///< along the directions, before the free rounds
    double deviation = 0;  ///< of the noise, as used at the end
  };

  /// One run of a strategy. @param deviation of the noise, in the unit of the positions.
  /// @param refine the deviation is a first guess: measure it again on what is removed.
  Run run(const Points& noisy, double deviation, bool refine, const Strategy& strategy, int iterations,
          double done, double share_of_progress) {
    Run result;
    result.positions = noisy;
    result.moves = VectorXd::Zero(n_);
    VectorXd fidelity = VectorXd::Constant(n_, strategy.fidelity);
    const IndexLists& balls = balls_[&strategy == &kSharp ? 0 : 1];
    const int rounds = iterations + strategy.free_iterations;
    for (int round = 0; round < rounds; ++round) {
      progress_.report("fairing", done + share_of_progress * round / rounds);
      const double range = strategy.range * (1 + strategy.range_start * std::exp(-0.5 * round));
      filter_normals(result.positions, balls, strategy.spatial * centroid_distance_, range);
      update_directions();
      if (round >= iterations) {
        refit_freely(noisy, strategy, fidelity, result.positions);
        continue;
      }
      assemble(noisy, result.positions, strategy, fidelity);
      solve(result.moves);
      result.positions = noisy + result.moves.asDiagonal() * directions_;
      if (round < 2) continue;
      if (refine) deviation = deviation_of(result.moves);
      adapt(result.moves / deviation, strategy, fidelity);
    }
    result.deviation = deviation;
    result.directions = directions_;
    return result;
  }

  /// The mean over each vertex and its neighbours.
  VectorXd ring_mean(const VectorXd& field) const {
    VectorXd mean(n_);
    for (Eigen::Index v = 0; v < n_; ++v) {
      double sum = field[v];
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i) sum += field[neighbours_.indices[i]];
      mean[v] = sum / (1 + neighbours_.size(v));
    }
    return mean;
  }

  /// Standard deviation of the white noise that `moves` holds, from its bi-umbrella (I − P)² (see
  /// estimate_noise()): the shape that was removed by mistake hardly shows in it.
  double deviation_of(const VectorXd& moves) {
    if (gains_.size() == 0) gains_ = fairing_detail::bi_umbrella_gains(neighbours_);
    const VectorXd rough = without_mean(without_mean(moves));
    double sum = 0;
    Eigen::Index count = 0;
    for (Eigen::Index v = 0; v < n_; ++v)
      if (gains_[v] > 0 && !fixed_[v]) {
        sum += rough[v] * rough[v] / gains_[v];
        ++count;
      }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  }

  /// Turns back triangles that noise along the surface has folded over: no move along the normals can. Their
  /// vertices slide towards the middle of their neighbours, within the surface, where that unfolds more than
  /// it folds. The sum of the area vectors around a triangle tells which way it should face, folds or not.
  void unfold(Points& positions) const {
    constexpr int kMostPasses = 10;
    const auto area_vector = [&](Eigen::Index f) {
      const Vector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                     c = positions.row(triangles_(f, 2));
      return Vector3d((b - a).cross(c - a));
    };
    for (int pass = 0; pass < kMostPasses; ++pass) {
      Points around_vertex = Points::Zero(n_, 3), facing(m_, 3);
      for (Eigen::Index f = 0; f < m_; ++f)
        for (int k = 0; k < 3; ++k) around_vertex.row(triangles_(f, k)) += area_vector(f).transpose();
      for (Eigen::Index f = 0; f < m_; ++f)
        facing.row(f) = around_vertex.row(triangles_(f, 0)) + around_vertex.row(triangles_(f, 1)) +
                        around_vertex.row(triangles_(f, 2));
      const auto is_folded = [&](Eigen::Index f) { return facing.row(f).dot(area_vector(f)) < 0; };
      const auto folds_at = [&](int v) {
        int count = 0;
        for (int i = around_.begin(v); i < around_.end(v); ++i)
          count += is_folded(around_.indices[i]) ? 1 : 0;
        return count;
      };
      bool is_better = false;
      for (Eigen::Index f = 0; f < m_; ++f) {
        for (int k = 0; k < 3 && is_folded(f); ++k) {
          const int v = triangles_(f, k);
          const Eigen::RowVector3d normal = around_vertex.row(v).normalized(), start = positions.row(v);
          if (fixed_[v]) continue;
          Eigen::RowVector3d slide = -start * neighbours_.size(v);
          for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
            slide += positions.row(neighbours_.indices[i]);
          slide /= neighbours_.size(v);
          slide -= slide.dot(normal) * normal;
          const int before = folds_at(v);
          int after = before;
          for (const double part : {1.0, 0.5, 0.25}) {
            positions.row(v) = start + part * slide;
            after = folds_at(v);
            if (after < before) break;
          }
          if (after < before)
            is_better = true;
          else
            positions.row(v) = start;
        }
      }
      if (!is_better) return;
    }
  }

  /// Sets up tilt(): W with x · W x = Σ_f (turn of the normal of triangle f)² for small moves x along the
  /// normals, that is Σ_k cot_k (x_i − x_j)² / 2A_f. Triangles smaller than the square of the deviation of
  /// the noise are counted as that large: their normals point anywhere.
  void measure_tilts(const Points& positions, double deviation) {
    tilt_off_diagonal_.assign(neighbours_.indices.size(), 0.0);
    tilt_diagonal_ = VectorXd::Zero(n_);
    for (Eigen::Index f = 0; f < m_; ++f) {
      const Eigen::RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                               c = positions.row(triangles_(f, 2));
      const Eigen::RowVector3d weights =
          bounded_cotangents(positions, f, kOrganic) / ((b - a).cross(c - a).norm() + deviation * deviation);
      for (int k = 0; k < 3; ++k) {
        tilt_diagonal_[triangles_(f, (k + 1) % 3)] += weights[k];
        tilt_diagonal_[triangles_(f, (k + 2) % 3)] += weights[k];
        tilt_off_diagonal_[slots_[6 * f + 2 * k]] -= weights[k];
        tilt_off_diagonal_[slots_[6 * f + 2 * k + 1]] -= weights[k];
      }
    }
  }
  /// W field; measure_tilts() comes first.
  VectorXd tilt(const VectorXd& field) const { return product(tilt_diagonal_, tilt_off_diagonal_, field); }
  const VectorXd& tilt_diagonal() const { return tilt_diagonal_; }

 private:
  int slot(int row, int column) const {
    const auto begin = neighbours_.indices.begin();
    return static_cast<int>(
        std::lower_bound(begin + neighbours_.begin(row), begin + neighbours_.end(row), column) - begin);
  }

  /// (I − P) field, with P the mean of the neighbours alone.
  VectorXd without_mean(const VectorXd& field) const {
    VectorXd rest = VectorXd::Zero(n_);
    for (Eigen::Index v = 0; v < n_; ++v) {
      if (neighbours_.size(v) == 0) continue;
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
        rest[v] += field[v] - field[neighbours_.indices[i]];
      rest[v] /= neighbours_.size(v);
    }
    return rest;
  }

  /// A x for the symmetric matrix A with these entries, the off-diagonal ones in the order of the neighbours.
  VectorXd product(const VectorXd& diagonal, const std::vector<double>& off_diagonal,
                   const VectorXd& x) const {
    VectorXd y(n_);
    for (Eigen::Index v = 0; v < n_; ++v) {
      double sum = diagonal[v] * x[v];
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
        sum += off_diagonal[i] * x[neighbours_.indices[i]];
      y[v] = sum;
    }
    return y;
  }

  void filter_normals(const Points& positions, const IndexLists& balls, double spatial, double range) {
    features_.resize(8 * static_cast<std::size_t>(m_));
    filtered_.resize(m_, 3);
    // Single precision is enough for weights; the centre keeps it so wherever the mesh lies.
    const Eigen::RowVector3d centre = positions.colwise().mean();
    const double scale = 1 / (std::sqrt(2.0) * spatial), normal_scale = 1 / (std::sqrt(2.0) * range);
    parallel_for(m_, 8192, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index f = begin; f < end; ++f) {
        const Eigen::RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                                 c = positions.row(triangles_(f, 2));
        const Eigen::RowVector3d normal = (b - a).cross(c - a), centroid = (a + b + c) / 3 - centre;
        const double length = normal.norm();
        float* feature = features_.data() + 8 * f;
        for (int k = 0; k < 3; ++k) {
          feature[k] = static_cast<float>(centroid[k] * scale);
          feature[3 + k] = length > 0 ? static_cast<float>(normal[k] / length * normal_scale) : 0.0F;
        }
        feature[6] = static_cast<float>(length * scale * scale);
      }
    });
    parallel_for(m_, 2048, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index f = begin; f < end; ++f) {
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

  /// Along which the vertices move: the filtered normals around them, weighted by area.
  void update_directions() {
    directions_.resize(n_, 3);
    for (Eigen::Index v = 0; v < n_; ++v) {
      Vector3d sum = Vector3d::Zero();
      for (int i = around_.begin(v); i < around_.end(v); ++i) {
        const int f = around_.indices[i];
        sum += static_cast<double>(features_[8 * static_cast<std::size_t>(f) + 6]) *
               filtered_.row(f).transpose();
      }
      const double length = sum.norm();
      directions_.row(v) = length > 0 ? Vector3d(sum / length) : Vector3d::Zero();
    }
  }

  /// The normal equations of the refit, A moves = right.
  void assemble(const Points& noisy, const Points& current, const Strategy& strategy,
                const VectorXd& fidelity) {
    off_diagonal_.assign(neighbours_.indices.size(), 0.0);
    diagonal_ = fidelity;
    right_ = VectorXd::Zero(n_);
    for (Eigen::Index f = 0; f < m_; ++f) {
      const Vector3d normal = filtered_.row(f);
      double slope[3], height[3];
      for (int k = 0; k < 3; ++k) {
        const int v = triangles_(f, k);
        slope[k] = fixed_[v] ? 0 : normal.dot(directions_.row(v));
        height[k] = normal.dot(noisy.row(v));
      }
      const Eigen::RowVector3d weights = bounded_cotangents(current, f, strategy);
      for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3, i = triangles_(f, a), j = triangles_(f, b);
        const double weight = weights[k];
        const double difference = height[a] - height[b];
        diagonal_[i] += weight * slope[a] * slope[a];
        diagonal_[j] += weight * slope[b] * slope[b];
        const double product = weight * slope[a] * slope[b];
        off_diagonal_[slots_[6 * f + 2 * k]] -= product;
        off_diagonal_[slots_[6 * f + 2 * k + 1]] -= product;
        right_[i] -= weight * slope[a] * difference;
        right_[j] += weight * slope[b] * difference;
      }
    }
  }

  /// The refit with all three coordinates free: the same energy, and kSidewaysFidelity for moves across
  /// the directions.
  void refit_freely(const Points& noisy, const Strategy& strategy, const VectorXd& fidelity,
                    Points& positions) {
    edge_weights_.resize(m_, 3);
    for (Eigen::Index f = 0; f < m_; ++f) edge_weights_.row(f) = bounded_cotangents(positions, f, strategy);
    const auto slopes = [&](const Points& x) {
      Points y = Points::Zero(n_, 3);
      for (Eigen::Index f = 0; f < m_; ++f) {
        const Eigen::RowVector3d normal = filtered_.row(f);
        double height[3];
        for (int k = 0; k < 3; ++k) height[k] = normal.dot(x.row(triangles_(f, k)));
        for (int k = 0; k < 3; ++k) {
          const int a = (k + 1) % 3, b = (k + 2) % 3;
          const double pull = edge_weights_(f, k) * (height[a] - height[b]);
          y.row(triangles_(f, a)) += pull * normal;
          y.row(triangles_(f, b)) -= pull * normal;
        }
      }
      return y;
    };
    const auto product = [&](const Points& x) {
      Points y = slopes(x);
      for (Eigen::Index v = 0; v < n_; ++v) {
        const double along = x.row(v).dot(directions_.row(v));
        y.row(v) +=
            kSidewaysFidelity * x.row(v) + (fidelity[v] - kSidewaysFidelity) * along * directions_.row(v);
        if (fixed_[v]) y.row(v).setZero();
      }
      return y;
    };
    Points right = -slopes(noisy);
    for (Eigen::Index v = 0; v < n_; ++v)
      if (fixed_[v]) right.row(v).setZero();
    Points moves = positions - noisy;
    Points residual = right - product(moves), search = residual;
    double energy = residual.squaredNorm();
    const double enough = 1e-6 * right.squaredNorm();
    for (int i = 0; i < 100 && energy > enough; ++i) {
      const Points image = product(search);
      const double step = energy / search.cwiseProduct(image).sum();
      moves += step * search;
      residual -= step * image;
      const double next = residual.squaredNorm();
      search = residual + (next / energy) * search;
      energy = next;
    }
    positions = noisy + moves;
  }

  /// Cotangents of the three angles, within the bounds of the strategy.
  Eigen::RowVector3d bounded_cotangents(const Points& positions, Eigen::Index f,
                                        const Strategy& strategy) const {
    const Eigen::RowVector3d a = positions.row(triangles_(f, 0)), b = positions.row(triangles_(f, 1)),
                             c = positions.row(triangles_(f, 2));
    const double twice_area = (b - a).cross(c - a).norm();
    if (!(twice_area > 0)) return Eigen::RowVector3d::Constant(strategy.least_cotangent);
    return (Eigen::RowVector3d((b - a).dot(c - a), (c - b).dot(a - b), (a - c).dot(b - c)) / twice_area)
        .cwiseMax(strategy.least_cotangent)
        .cwiseMin(strategy.most_cotangent);
  }

  /// Conjugate gradients with the diagonal as preconditioner: the moves of the round before are a good start
  /// and the system is well conditioned, so that a few iterations do what a factorisation would.
  void solve(VectorXd& moves) const {
    VectorXd residual = right_ - product(diagonal_, off_diagonal_, moves);
    VectorXd preconditioned = residual.cwiseQuotient(diagonal_), search = preconditioned;
    double energy = residual.dot(preconditioned);
    const double enough = 1e-8 * right_.dot(right_.cwiseQuotient(diagonal_));
    for (int i = 0; i < 100 && energy > enough; ++i) {
      const VectorXd image = product(diagonal_, off_diagonal_, search);
      const double step = energy / search.dot(image);
      moves += step * search;
      residual -= step * image;
      preconditioned = residual.cwiseQuotient(diagonal_);
      const double next = residual.dot(preconditioned);
      search = preconditioned + (next / energy) * search;
      energy = next;
    }
  }

  /// Step 3: λ where shape was removed rises, elsewhere it falls.
  /// @param moves in standard deviations of the noise.
  void adapt(const VectorXd& moves, const Strategy& strategy, VectorXd& fidelity) const {
    VectorXd excess = ring_mean(moves).cwiseAbs2();
    for (Eigen::Index v = 0; v < n_; ++v) excess[v] *= 1 + neighbours_.size(v);  // 1 for white noise
    for (int pass = 0; pass < kResidualPasses; ++pass) excess = ring_mean(excess);
    for (Eigen::Index v = 0; v < n_; ++v)
      fidelity[v] =
          std::clamp(fidelity[v] * std::pow(std::clamp(excess[v] / strategy.target, 0.1, 10.0), 0.3),
                     strategy.least_fidelity, kMostFidelity);
  }

  const Triangles& triangles_;
  const Progress& progress_;
  Eigen::Index n_, m_;
  IndexLists around_, neighbours_, balls_[2];
  std::vector<char> fixed_;
  bool closed_ = true;
  double centroid_distance_ = 0;
  std::vector<int> slots_;
  std::vector<float> features_;
  Points filtered_, directions_, edge_weights_;
  std::vector<double> off_diagonal_, tilt_off_diagonal_;
  VectorXd diagonal_, right_, gains_, tilt_diagonal_;
};

/// The part of an estimated noise level that is surely noise, from the level measured again on what was
/// removed, where shape hardly shows: all of it where the two agree within the factor 0.6 (on the meshes of
/// docs/fair.md, 0.7 and more), nothing below 0.5. There the first was the shape of a mesh of so few
/// triangles that most of its vertices lie on edges (0.26 to 0.47 on a part of 115 vertices, clean or noisy).
double agreement_of(double estimated, double removed) {
  return std::clamp((removed / estimated - 0.5) / 0.1, 0.0, 1.0);
}

double median(VectorXd values) {
  double* const middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

/// Shifts all vertices alike along `directions` until the enclosed volume is that of `positions`.
void keep_volume(const Points& positions, const Triangles& triangles, const Points& directions,
                 Points& moves) {
  const double volume = enclosed_volume(positions, triangles);
  for (int pass = 0; pass < 3; ++pass) {
    const Points moved = positions + moves;
    // The derivative of the volume: a third of the area vectors around each vertex, along its direction.
    double derivative = 0;
    for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
      const Eigen::RowVector3d a = moved.row(triangles(f, 0)), b = moved.row(triangles(f, 1)),
                               c = moved.row(triangles(f, 2));
      const Eigen::RowVector3d normal = (b - a).cross(c - a);
      for (int k = 0; k < 3; ++k) derivative += normal.dot(directions.row(triangles(f, k))) / 6;
    }
    if (!(derivative > 0)) return;
    moves += (volume - enclosed_volume(moved, triangles)) / derivative * directions;
  }
}

/// Takes back the moves, half by half, of triangles that intersect others, until there are no more such pairs
/// than in the input. At high noise some ten small triangles in a mesh fold over otherwise.
void take_back_intersections(const Points& positions, const Triangles& triangles, Points& moves) {
  constexpr std::size_t kMost = 100000;
  std::size_t allowed = 0;
  for (int pass = 0; pass < 12; ++pass) {
    const auto pairs = self_intersections(positions + moves, triangles, kMost);
    if (pass == 0 && !pairs.empty()) allowed = self_intersections(positions, triangles, kMost).size();
    if (pairs.size() <= allowed) return;
    std::vector<char> marked(static_cast<std::size_t>(positions.rows()), 0);
    for (const auto& pair : pairs)
      for (const int f : {pair.first, pair.second})
        for (int k = 0; k < 3; ++k) marked[triangles(f, k)] = 1;
    for (Eigen::Index v = 0; v < moves.rows(); ++v)
      if (marked[v]) moves.row(v) *= 0.5;
  }
}

}  // namespace

std::string AutomaticFairingOptions::problem() const {
  if (!std::isfinite(noise)) return concat("noise must be finite, got ", noise);
  if (iterations < 0) return concat("iterations must be at least 0, got ", iterations);
  return {};
}

Points fair_automatically(const Points& positions, const Triangles& triangles,
                          const AutomaticFairingOptions& options, AutomaticFairingReport* report,
                          const Progress& progress) {
  if (const std::string problem = options.problem(); !problem.empty()) throw InvalidInput(problem);
  std::vector<char> fixed =
      fairing_detail::fixed_vertices(positions, triangles, options.keep_boundary);  // checks the mesh
  AutomaticFairingReport own;
  AutomaticFairingReport& told = report != nullptr ? *report : own;
  told = {};
  const double edge = mean_edge_length(positions, triangles);
  if (!(edge > 0)) return positions;
  if (options.noise >= 0) {
    told.noise = options.noise;
    told.significance = options.noise > 0 ? 1 : 0;
  } else {
    const NoiseEstimate estimate = estimate_noise(positions, triangles);
    told.noise = estimate.level;
    told.significance = estimate.significance;
  }
  Fairer fairer(positions, triangles, std::move(fixed), progress);
  if (!(told.significance > 0)) return positions;
  const double estimated = told.noise;
  double deviation = estimated * edge;
  const bool refine = options.noise < 0;

  // The probe of Stein's estimate: random signs along the normals, a tenth of the noise.
  const Eigen::Index n = positions.rows();
  Random random(20);
  VectorXd probe(n);
  for (Eigen::Index v = 0; v < n; ++v) probe[v] = random.uniform() < 0.5 ? -1 : 1;
  const double amplitude = 0.1 * deviation;
  const Points normals = vertex_normals(positions, triangles);
  const Points perturbed = positions + amplitude * (probe.asDiagonal() * normals);

  const Strategy* strategies[2] = {&kSharp, &kOrganic};
  Fairer::Run runs[2];
  VectorXd risk[2];
  for (int k = 0; k < 2; ++k) {
    const Strategy& strategy = *strategies[k];
    const int iterations = options.iterations > 0 ? options.iterations : strategy.iterations;
    runs[k] = fairer.run(positions, deviation, refine && k == 0, strategy, iterations, 0.5 * k, 0.25);
    if (k == 0) {
      deviation = runs[0].deviation;
      fairer.measure_tilts(positions, deviation);
    }
    const Fairer::Run again =
        fairer.run(perturbed, deviation, false, strategy, iterations, 0.5 * k + 0.25, 0.25);
    const VectorXd removed =
        (runs[k].positions - positions).cwiseProduct(normals).rowwise().sum() / deviation;
    const VectorXd response =
        (again.positions - runs[k].positions).cwiseProduct(normals).rowwise().sum() / amplitude;
    // ‖removed‖² + 2 trace(response), in the norm that counts turned normals: what is said to be better is
    // then better in the normals, also where triangles differ much in size.
    risk[k] = removed.cwiseProduct(fairer.tilt(removed)) + 2 * fairer.tilt(probe).cwiseProduct(response);
    told.strategies.emplace_back(strategy.name);
    told.risks.push_back(risk[k].sum() / fairer.tilt_diagonal().sum() - 1);
  }

  // A region of some hundred triangles tells the strategies apart only where they differ much; so the whole
  // mesh takes what is better at most places, but for the regions where the other is better beyond doubt.
  VectorXd advantage = risk[0] - risk[1], regional;
  for (int pass = 0; pass < 48; ++pass) {
    advantage = fairer.ring_mean(advantage);
    if (pass == 11) regional = advantage;
  }
  const int winner = median(advantage) > 0 ? 1 : 0;
  const double typical = median(regional);
  const double doubt = kDoubt * 1.4826 * median((regional.array() - typical).abs().matrix());
  VectorXd other(n);  // share of the strategy that did not win
  for (Eigen::Index v = 0; v < n; ++v) {
    const double lead = winner == 0 ? regional[v] : -regional[v];
    other[v] = lead > doubt ? 1 : 0;
  }
  for (int pass = 0; pass < 3; ++pass) other = fairer.ring_mean(other);
  told.noise = deviation / edge;
  // Where even the better strategy leaves more than a fifth of the noise's own error, what was measured is
  // partly the shape of a coarse mesh.
  if (refine)
    told.significance = std::min({told.significance, noise_significance(estimated, told.risks[winner] - 0.2),
                                  agreement_of(estimated, deviation / edge)});
  if (!(told.significance > 0)) return positions;
  told.exceptions = other.mean();
  told.strategy = strategies[winner]->name;
  told.iterations = options.iterations > 0 ? options.iterations : strategies[winner]->iterations;
  Points moves =
      told.significance * (runs[winner].positions - positions +
                           other.asDiagonal() * (runs[1 - winner].positions - runs[winner].positions));
  Points unfolded = positions + moves;
  fairer.unfold(unfolded);
  moves = unfolded - positions;
  if (fairer.is_closed()) keep_volume(positions, triangles, runs[winner].directions, moves);
  take_back_intersections(positions, triangles, moves);
  told.largest_move = moves.rowwise().norm().maxCoeff();
  return positions + moves;
}

}  // namespace batten
