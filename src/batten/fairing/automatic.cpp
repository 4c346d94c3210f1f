#include "batten/fairing/automatic.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/neighbours_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using fairing_detail::IndexLists;

/// The parameters of one run. All lengths are in mean edge lengths or mean distances of centroids.
struct Strategy {
  const char* name;
  double spatial;       ///< s, in mean centroid distances
  double range;         ///< r, as a difference of unit normals
  double range_start;   ///< r is larger by this factor of itself in the first rounds, falling like e^(−round/2)
  double fidelity;      ///< λ at the start, where cotangents are 1
  double least_fidelity;
  double target;        ///< ratio of the averaged residual to white noise above which λ grows
  int iterations;
};

// Found on fandisk, cubehole, rocker arm and bunny with noise of 0.1, 0.2 and 0.3 mean edge lengths; see
// docs/fair.md for the figures.
constexpr Strategy kSharp{"sharp", 2.0, 0.35, 0.0, 0.05, 0.02, 1.3, 14};
constexpr Strategy kOrganic{"organic", 1.2, 0.45, 1.0, 0.15, 0.05, 1.0, 10};
constexpr double kMostFidelity = 2.0;
constexpr int kMostNeighbours = 60;

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
  Fairer(const Points& noisy, const Triangles& triangles, bool keep_boundary, const Progress& progress)
      : triangles_(triangles),
        progress_(progress),
        n_(noisy.rows()),
        m_(triangles.rows()),
        around_(fairing_detail::triangles_of_vertices(triangles, n_)),
        neighbours_(fairing_detail::vertex_neighbours(triangles, n_)),
        fixed_(static_cast<std::size_t>(n_), 0) {
    const std::vector<int> opposite = opposite_half_edges(triangles);
    const Points centroids = fairing_detail::triangle_centroids(noisy, triangles);
    centroid_distance_ = fairing_detail::mean_centroid_distance(centroids, opposite);
    for (std::size_t h = 0; h < opposite.size(); ++h)
      if (opposite[h] < 0) {
        closed_ = false;
        if (keep_boundary)
          for (int k = 1; k < 3; ++k)
            fixed_[triangles(static_cast<Eigen::Index>(h) / 3, (static_cast<int>(h % 3) + k) % 3)] = 1;
      }
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
    VectorXd moves;
  };

  /// One run of a strategy. @param deviation of the noise, in the unit of the positions.
  Run run(const Points& noisy, double deviation, const Strategy& strategy, int iterations, double done,
          double share_of_progress) {
    Run result;
    result.positions = noisy;
    result.moves = VectorXd::Zero(n_);
    VectorXd fidelity = VectorXd::Constant(n_, strategy.fidelity);
    const IndexLists& balls = balls_[&strategy == &kSharp ? 0 : 1];
    for (int round = 0; round < iterations; ++round) {
      progress_.report("fairing", done + share_of_progress * round / iterations);
      const double range = strategy.range * (1 + strategy.range_start * std::exp(-0.5 * round));
      filter_normals(result.positions, balls, strategy.spatial * centroid_distance_, range);
      update_directions();
      assemble(noisy, result.positions, fidelity);
      solve(result.moves);
      result.positions = noisy + result.moves.asDiagonal() * directions_;
      if (round >= 2) adapt(result.moves / deviation, strategy, fidelity);
    }
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

  /// The umbrella Laplacian, positive: Σ (x_v − x_u) over the neighbours u.
  VectorXd umbrella(const VectorXd& field) const {
    VectorXd sum(n_);
    for (Eigen::Index v = 0; v < n_; ++v) {
      sum[v] = neighbours_.size(v) * field[v];
      for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i) sum[v] -= field[neighbours_.indices[i]];
    }
    return sum;
  }

 private:
  int slot(int row, int column) const {
    const auto begin = neighbours_.indices.begin();
    return static_cast<int>(std::lower_bound(begin + neighbours_.begin(row), begin + neighbours_.end(row), column) -
                            begin);
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
        sum += static_cast<double>(features_[8 * static_cast<std::size_t>(f) + 6]) * filtered_.row(f).transpose();
      }
      const double length = sum.norm();
      directions_.row(v) = length > 0 ? Vector3d(sum / length) : Vector3d::Zero();
    }
  }

  /// The normal equations of the refit, A moves = right.
  void assemble(const Points& noisy, const Points& current, const VectorXd& fidelity) {
    off_diagonal_.assign(neighbours_.indices.size(), 0.0);
    diagonal_ = fidelity;
    right_ = VectorXd::Zero(n_);
    for (Eigen::Index f = 0; f < m_; ++f) {
      const Vector3d normal = filtered_.row(f);
      double slope[3], height[3];
      Vector3d corner[3];
      for (int k = 0; k < 3; ++k) {
        const int v = triangles_(f, k);
        slope[k] = fixed_[v] ? 0 : normal.dot(directions_.row(v));
        height[k] = normal.dot(noisy.row(v));
        corner[k] = current.row(v);
      }
      const double twice_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
      for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3, i = triangles_(f, a), j = triangles_(f, b);
        const double dot = (corner[a] - corner[k]).dot(corner[b] - corner[k]);
        // Bounded, so that slivers neither decouple nor rule.
        const double weight = twice_area > 0 ? std::clamp(dot / twice_area, 0.1, 3.0) : 0.1;
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

  /// Conjugate gradients with the diagonal as preconditioner: the moves of the round before are a good start
  /// and the system is well conditioned, so that a few iterations do what a factorisation would.
  void solve(VectorXd& moves) const {
    const auto product = [&](const VectorXd& x) {
      VectorXd y(n_);
      for (Eigen::Index v = 0; v < n_; ++v) {
        double sum = diagonal_[v] * x[v];
        for (int i = neighbours_.begin(v); i < neighbours_.end(v); ++i)
          sum += off_diagonal_[i] * x[neighbours_.indices[i]];
        y[v] = sum;
      }
      return y;
    };
    VectorXd residual = right_ - product(moves);
    VectorXd preconditioned = residual.cwiseQuotient(diagonal_), search = preconditioned;
    double energy = residual.dot(preconditioned);
    const double enough = 1e-8 * right_.dot(right_.cwiseQuotient(diagonal_));
    for (int i = 0; i < 100 && energy > enough; ++i) {
      const VectorXd image = product(search);
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
    excess = ring_mean(ring_mean(excess));
    for (Eigen::Index v = 0; v < n_; ++v)
      fidelity[v] = std::clamp(fidelity[v] * std::pow(std::clamp(excess[v] / strategy.target, 0.1, 10.0), 0.3),
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
  Points filtered_, directions_;
  std::vector<double> off_diagonal_;
  VectorXd diagonal_, right_;
};

void check_mesh(const Points& positions, const Triangles& triangles) {
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!positions.row(v).allFinite())
      throw InvalidInput(concat("vertex ", v, " has a coordinate that is not finite; repair the mesh first"));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (triangles(f, k) < 0 || triangles(f, k) >= positions.rows())
        throw InvalidInput(concat("triangle ", f, " names vertex ", triangles(f, k),
                                  ", but the mesh has the vertices 0 to ", positions.rows() - 1));
}

/// Shifts all vertices alike along `directions` until the enclosed volume is that of `positions`.
void keep_volume(const Points& positions, const Triangles& triangles, const Points& directions, Points& moves) {
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
  check_mesh(positions, triangles);
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
  Fairer fairer(positions, triangles, options.keep_boundary, progress);
  if (!(told.significance > 0)) return positions;
  const double deviation = told.noise * edge;

  // The probe of Stein's estimate: random signs along the normals, a tenth of the noise.
  const Eigen::Index n = positions.rows();
  Random random(20);
  VectorXd probe(n);
  for (Eigen::Index v = 0; v < n; ++v) probe[v] = random.uniform() < 0.5 ? -1 : 1;
  const double amplitude = 0.1 * deviation;
  const Points normals = vertex_normals(positions, triangles);
  const Points perturbed = positions + amplitude * (probe.asDiagonal() * normals);
  const VectorXd rough_probe = fairer.umbrella(probe);

  const Strategy* strategies[2] = {&kSharp, &kOrganic};
  Fairer::Run runs[2];
  VectorXd risk[2];
  for (int k = 0; k < 2; ++k) {
    const Strategy& strategy = *strategies[k];
    const int iterations = options.iterations > 0 ? options.iterations : strategy.iterations;
    runs[k] = fairer.run(positions, deviation, strategy, iterations, 0.5 * k, 0.25);
    const Fairer::Run again = fairer.run(perturbed, deviation, strategy, iterations, 0.5 * k + 0.25, 0.25);
    const VectorXd removed =
        (runs[k].positions - positions).cwiseProduct(normals).rowwise().sum() / deviation;
    const VectorXd response =
        (again.positions - runs[k].positions).cwiseProduct(normals).rowwise().sum() / amplitude;
    // ‖removed‖² + 2 trace(response), both measured by the umbrella, which weights errors as normals do.
    risk[k] = removed.cwiseProduct(fairer.umbrella(removed)) + 2 * rough_probe.cwiseProduct(response);
    told.strategies.emplace_back(strategy.name);
    double valences = 0;
    for (Eigen::Index v = 0; v < n; ++v) valences += fairer.neighbours().size(v);
    told.risks.push_back(risk[k].sum() / valences - 1);
  }

  // Which strategy each region takes.
  VectorXd organic = VectorXd::Constant(n, told.risks[1] < told.risks[0] ? 1.0 : 0.0);
  if (options.regional) {
    VectorXd advantage = risk[0] - risk[1];
    for (int pass = 0; pass < 6; ++pass) advantage = fairer.ring_mean(advantage);
    for (Eigen::Index v = 0; v < n; ++v) organic[v] = advantage[v] > 0 ? 1.0 : 0.0;
    for (int pass = 0; pass < 3; ++pass) organic = fairer.ring_mean(organic);
  }
  told.shares = {1 - organic.mean(), organic.mean()};
  const int winner = told.shares[1] > 0.5 ? 1 : 0;
  told.iterations = options.iterations > 0 ? options.iterations : strategies[winner]->iterations;
  Points moves = told.significance * (runs[0].positions - positions +
                                      organic.asDiagonal() * (runs[1].positions - runs[0].positions));
  if (fairer.is_closed())
    keep_volume(positions, triangles, runs[winner].directions, moves);
  told.largest_move = moves.rowwise().norm().maxCoeff();
  return positions + moves;
}

}  // namespace batten
