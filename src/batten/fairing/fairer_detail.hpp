#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/fairing/automatic.hpp"
#include "batten/fairing/fields_detail.hpp"
#include "batten/linalg/iterative.hpp"

namespace batten::fairing_detail {

/// The parameters of one run. All lengths are in mean edge lengths or mean distances of centroids.
struct Strategy {
  FairingStrategy kind;
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
inline constexpr Strategy kSharp{FairingStrategy::Sharp, 2.0, 0.35, 0.5, 0.05, 0.02, 1.2, 0.3, 1.5, 12, 2};
inline constexpr Strategy kOrganic{
    FairingStrategy::Organic, 1.2, 0.45, 1.0, 0.15, 0.05, 1.0, 0.1, 3.0, 10, 0};

/// One run of a strategy from start to end; see fair_automatically() for its rounds.
struct FairingRun {
  Points positions, directions;
  Eigen::VectorXd moves;  ///< along the directions, before the free rounds
  double deviation = 0;   ///< of the noise, as used at the end
  SolveQuality solves;
};

/// The mesh and everything else that all runs share.
class Fairer {
 public:
  /// @param fixed per vertex: 1 for those that stay.
  Fairer(const Points& noisy, const Triangles& triangles, std::vector<char> fixed, const Progress& progress);

  bool is_closed() const { return closed_; }
  const MeshFields& fields() const { return fields_; }

  /// @param deviation of the noise, in the unit of the positions. @param refine the deviation is a first
  /// guess: measure it again on what is removed.
  FairingRun run(const Points& noisy, double deviation, bool refine, const Strategy& strategy, int iterations,
                 const Progress& progress);

  /// Turns back triangles that noise along the surface has folded over: no move along the normals can. Their
  /// vertices slide towards the middle of their neighbours, within the surface, where that unfolds more than
  /// it folds. The sum of the area vectors around a triangle tells which way it should face, folds or not.
  void unfold(Points& positions, const Progress& progress) const;

  /// Sets up tilt(): W with x · W x = Σ_f (turn of the normal of triangle f)² for small moves x along the
  /// normals, that is Σ_k cot_k (x_i − x_j)² / 2A_f. Triangles smaller than the square of the deviation of
  /// the noise are counted as that large: their normals point anywhere.
  void measure_tilts(const Points& positions, double deviation);
  /// W field; measure_tilts() comes first.
  Eigen::VectorXd tilt(const Eigen::VectorXd& field) const;
  const Eigen::VectorXd& tilt_diagonal() const { return tilts_.diagonal; }

 private:
  /// One pass over the triangles of unfold(). @return whether a vertex was moved.
  bool unfold_once(Points& positions) const;
  /// Standard deviation of the white noise that `moves` holds, from its bi-umbrella (I − P)² (see
  /// estimate_noise()): the shape that was removed by mistake hardly shows in it.
  double deviation_of(const Eigen::VectorXd& moves);
  void filter_normals(const Points& positions, const IndexLists& balls, double spatial, double range);
  /// Along which the vertices move: the filtered normals around them, weighted by area.
  void update_directions();
  /// The normal equations of the refit, A moves = right.
  void assemble(const Points& noisy, const Points& current, const Strategy& strategy,
                const Eigen::VectorXd& fidelity);
  /// The refit with all three coordinates free: the same energy, and kSidewaysFidelity for moves across
  /// the directions.
  IterativeReport refit_freely(const Points& noisy, const Strategy& strategy, const Eigen::VectorXd& fidelity,
                               Points& positions, const Progress& progress);
  /// Solves for the moves: those of the round before are a good start and the system is well conditioned, so
  /// that a few iterations do what a factorisation would.
  IterativeReport solve(Eigen::VectorXd& moves, const Progress& progress) const;
  /// Step 3: λ where shape was removed rises, elsewhere it falls.
  /// @param moves in standard deviations of the noise.
  void adapt(const Eigen::VectorXd& moves, const Strategy& strategy, Eigen::VectorXd& fidelity) const;
  /// Cotangents of the three angles, within the bounds of the strategy.
  Eigen::RowVector3d bounded_cotangents(const Points& positions, Eigen::Index f,
                                        const Strategy& strategy) const;

  const Triangles& triangles_;
  Eigen::Index n_, m_;
  MeshFields fields_;
  IndexLists balls_[2];
  std::vector<char> fixed_;
  bool closed_ = true;
  double centroid_distance_ = 0;
  std::vector<float> features_;
  Points filtered_, directions_;
  /// Per triangle, of assemble(): cotangents, slopes and heights of its corners.
  Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> corners_;
  Points edge_weights_, pulls_;  ///< per triangle, of refit_freely()
  EdgeMatrix refit_, tilts_;
  Eigen::VectorXd right_, gains_;
};

}  // namespace batten::fairing_detail
