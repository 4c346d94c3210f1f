#pragma once
#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/random.hpp"
#include "batten/scan/block_ldlt_detail.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

using FrameLdlt = BlockLdlt<3>;

/// What the gyroscope says of two frames that follow each other in time.
struct JointTurn {
  int before, after;     ///< frames
  Eigen::Vector3d turn;  ///< rotation vector in the axes of the frame before, as read
  double time;           ///< seconds
  int bias;              ///< which block of the bias belongs to that time
  FrameLdlt::Slot own_before = {}, own_after = {}, to_after = {}, bias_before = {}, bias_after = {};
  /// Blocks of the columns of the matrix of scale and alignment with both frames and the bias.
  std::array<FrameLdlt::Slot, 3> matrix_before = {}, matrix_after = {}, matrix_bias = {};
};

/// The turns of a scan with the blocks of unknowns that they share: the bias, one block per some seconds, and
/// three columns of scale and alignment. Empty without a gyroscope.
struct TurnLayout {
  /// @param n_blocks of unknowns so far, the frames first; those of the gyroscope are added behind.
  void find(const SampledScan& scan, const FrameNumbering& frames, int& n_blocks);
  /// Adds the pairs of blocks that meet.
  void join(std::vector<std::pair<int, int>>& list) const;
  void find_slots(const FrameLdlt& system);
  int n_biases() const { return static_cast<int>(bias_times.size()); }

  std::vector<JointTurn> turns;
  std::vector<double> bias_times;                    ///< per block of the bias, since the one before, seconds
  int bias_at = 0, matrix_at = 0;                    ///< first blocks
  std::vector<FrameLdlt::Slot> bias_own, bias_next;  ///< per block; with the next
  std::array<std::array<FrameLdlt::Slot, 3>, 3> matrix_slot;  ///< rows, columns up to the diagonal
};

/// Densities between which that of a gyroscope lies, rad/s/√Hz: no hand-held device keeps to better ones (its
/// axes bend, its readings are rounded), and above nothing is left of what it says.
constexpr double kLeastTurnDensity = 0.0005, kMostTurnDensity = 0.2;
/// Densities are tried in such steps; above this one the turns do not fit the frames: one degree a second.
constexpr double kTurnDensityFactor = 3, kUselessTurnDensity = 0.02;

/// The gyroscope in the joint estimate: residuals log(G_kᵀ X_kᵀ X_{k+1}) of frames that follow each other,
/// G_k = exp((I + M) (g_k − b Δt_k)) with the bias b of that time and the matrix M of scale and alignment,
/// which are estimated as well. Empty without a gyroscope.
class JointTurns {
 public:
  /// @param layout must outlive this.
  JointTurns(const TurnLayout& layout, double density) : layout_(layout), density_(density) { reset(); }

  void reset();
  /// Density of the noise of the turns, rad/s/√Hz.
  double density() const { return density_; }
  void set_density(double density);
  bool empty() const { return layout_.turns.empty(); }
  const Points& biases() const { return biases_; }           ///< per some seconds, n × 3, rad/s
  const Eigen::Matrix3d& matrix() const { return matrix_; }  ///< M

  void linearize(const std::vector<Eigen::Matrix3d>& X);
  /// Adds JᵀWJ and −JᵀWr.
  void assemble(FrameLdlt& system, Eigen::VectorXd& right) const;
  /// Adds JᵀW^½ ε: the right side of residuals that are noise.
  void draw(Random& random, Eigen::VectorXd& right) const;
  /// Σ W|r + J δ|² − 3 log W with the priors of bias and matrix: its part of −2 log likelihood.
  double energy(const Eigen::VectorXd& delta) const;
  void apply(const Eigen::VectorXd& delta);

 private:
  /// Of one turn. The frame before has the derivative −by_frames.
  struct Linear {
    Eigen::Vector3d residual;
    Eigen::Matrix3d by_frames, by_turn;  ///< by the frame after; by (I + M) (g − b Δt)
    Eigen::Vector3d rate;                ///< g − b Δt
    double weight;
  };
  double weight_of(const JointTurn& turn) const;

  const TurnLayout& layout_;
  double density_;
  Points biases_;
  Eigen::Matrix3d matrix_;
  std::vector<Linear> linear_;
};

}  // namespace batten
