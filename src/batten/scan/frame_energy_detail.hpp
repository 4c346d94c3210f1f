#pragma once
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/scan/regression.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// A symmetric system of 3 × 3 blocks, one per frame, on a pattern found once, with its right-hand side.
class BlockSystem {
 public:
  /// @param joined pairs of frames whose off-diagonal block may differ from 0, in any order and repetition.
  BlockSystem(int n_frames, const std::vector<std::pair<int, int>>& joined);

  /// The number of the block that couples a and b (one for both orders). @pre the pair was joined, or a = b.
  int block(int a, int b) const;
  void clear();
  /// Adds to the half gradient of frame a.
  void add_gradient(int a, const Eigen::Vector3d& g) { gradient_.segment<3>(3 * a) += g; }
  /// Adds K to block (a, a).
  void add_diagonal(int a, const Eigen::Matrix3d& K) { add(first_block_[a], K); }
  /// Adds δᵀ K ε of frames a and b to the quadratic form δᵀHδ, halved: block (a, b) gains K, (b, a) Kᵀ.
  void add_cross(int block, int a, int b, const Eigen::Matrix3d& K);

  /// Solves (H + damping · diag H) δ = −gradient. @return false when that matrix is not positive definite.
  /// @throws Cancelled.
  bool solve(double damping, Eigen::VectorXd& delta, const Progress& progress = {});
  const Eigen::VectorXd& gradient() const { return gradient_; }

 private:
  void add(int block, const Eigen::Matrix3d& K);

  SparseMatrix H_;
  Eigen::VectorXd gradient_;
  std::vector<int> first_block_, rows_, columns_;
  SparseCholesky solver_;
};

/// How an energy is approximated around the present frames.
enum class Curvature {
  Exact,        ///< all second derivatives: Newton's method
  GaussNewton,  ///< without those of the residuals, the robust loss as its majorant: never indefinite
};

using Frames = std::vector<Eigen::Matrix3d>;

/// The energy of RegressionOptions over the unknown frames of a scan. Terms and couplings depend on the scan
/// alone; set_weights() fills in the rest.
class FrameEnergy {
 public:
  explicit FrameEnergy(const SampledScan& scan);

  /// Takes the frames of another scan with the same samples as data.
  void set_data(const SampledScan& scan);
  void set_weights(const RegressionOptions& options);

  const FrameNumbering& numbering() const { return numbering_; }
  /// Frames of a scan with the same samples, one per unknown.
  Frames frames_of(const SampledScan& scan) const;
  /// Pairs of frames that share a term.
  std::vector<std::pair<int, int>> couplings() const;
  /// Looks up the blocks of every term once.
  void bind(const BlockSystem& system);

  /// Energies of S (3.27, 3.29) and their weighted sum; `robust_scale` in radians, 0 for squares.
  RegressionReport energies(const Frames& X, double robust_scale) const;
  /// Half the gradient and half the Hessian of the weighted sum for X exp(δ^), into a cleared system.
  void assemble(const Frames& X, double robust_scale, Curvature curvature, BlockSystem& system) const;
  /// Median angle between frames and data, radians.
  double median_residual(const Frames& X) const;
  /// Per curve and sample: 1 kept … 0 ignored by the robust loss.
  std::vector<Eigen::VectorXd> trust(const Frames& X, double robust_scale) const;

 private:
  struct Data {
    int frame, curve, sample;
    double length;  ///< that the sample stands for, in the unit of the scan
    Eigen::Matrix3d A;
    double weight;
  };
  struct Pair {
    int a, b, block;
    double length, weight;  ///< weight 1/h, lengths in the unit
  };
  struct Triple {
    int before, at, after;
    int block_before, block_after, block_across;
    double length_before, length_after;  ///< in the unit of the scan
    double h_before, h_after, weight;    ///< in units; weight 2/(h_before + h_after)
  };
  struct Normals {
    int a, b, block;
  };

  void add_data(const Frames& X, double robust_scale, Curvature curvature, BlockSystem& system) const;
  void add_stretch(const Frames& X, Curvature curvature, BlockSystem& system) const;
  void add_bend(const Frames& X, Curvature curvature, BlockSystem& system) const;
  void add_normals(const Frames& X, Curvature curvature, BlockSystem& system) const;

  FrameNumbering numbering_;
  std::vector<Data> data_;
  std::vector<Pair> stretch_;
  std::vector<Triple> bend_;
  std::vector<Normals> normals_;
  std::vector<int> samples_;  ///< per curve
  double mean_step_ = 0;      ///< in the unit of the scan
  double normal_weight_ = 0, lambda_ = 0, mu_ = 0;
};

}  // namespace batten
