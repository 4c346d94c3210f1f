#pragma once
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/random.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/joint_layout_detail.hpp"
#include "batten/scan/joint_turns_detail.hpp"
#include "batten/scan/noise_model_detail.hpp"

namespace batten {

/// Relative slip of the odometer that no factor explains, as a random walk: 1e-4 sizes over one size. It also
/// takes up the error of the steps between samples.
constexpr double kSlip = 1e-4;
/// Variance of the total length, as a part of itself: that of a length known to 10⁻⁵. The scale that all
/// curves share is not observable, yet a network that shrinks as a whole closes ever better.
constexpr double kMeanFactorVariance = 1e-10;

/// Where the joint estimate is: what its steps change.
struct JointState {
  std::vector<Eigen::Matrix3d> X;  ///< frames
  Points drift;                    ///< per sample, rotation vectors, radians
  Points nodes;                    ///< positions of the nodes, in sizes
  Eigen::VectorXd log_factors;     ///< of lengths, per knot of the layout: one per curve, or more
  Eigen::VectorXd trust;           ///< per sample, of the robust loss
};

/// A noise model held against the linearised problem.
struct NoiseEvaluation {
  double evidence = 0;             ///< −2 log of the posterior density of the noise model, up to a constant
  NoisePrior::Coordinates slope;   ///< its derivatives by the coordinates of NoisePrior; where asked for
  NoisePrior::Coordinates weight;  ///< its second derivatives, about, diagonal alone, positive
  Eigen::VectorXd step;            ///< to the optimum of frames, drift, positions and factors
};

/// The problem behind estimate_jointly(), linearised at a state, for many noise models.
///
/// Residuals: readings, drift, shape, agreement of the normals, sums of steps of the segments, factors. In
/// place of the positions between nodes a segment has one multiplier, so that the system is quasi-definite;
/// its determinant is that of the definite one up to a constant. O(samples) for networks that are not sheets.
class JointModel {
 public:
  /// @param scan must outlive the model. @throws Cancelled.
  JointModel(const SampledScan& scan, const JointOptions& options, const Progress& progress = {});

  const JointLayout& layout() const { return layout_; }
  JointState& state() { return state_; }
  const JointState& state() const { return state_; }
  /// Back to where it was made: a state for any start.
  void reset();
  const NoisePrior& prior() const { return prior_; }

  /// The deviation of normals at a node, from the noise of the readings that it starts with.
  void set_normal_deviation(double white);
  /// Residuals and derivatives at the present state. @param follow the changes of the rates of turn as well;
  /// otherwise those of the last time stay.
  void linearize(const Progress& progress, bool follow = true);
  /// @throws SolverFailure, Cancelled.
  NoiseEvaluation evaluate(const NoiseModel& noise, bool with_slope, const Progress& progress);
  /// Moves the state. @return the largest turn of a frame, radians.
  double apply(const Eigen::VectorXd& step);
  /// Weights of the robust loss: 1 up to four standard deviations, then falling as the fourth power of the
  /// residual. Below one degree nothing is distrusted: with exact data that would be the error of the steps.
  void update_trust(double white);
  /// What the robust loss adds to the evidence for the samples that are not trusted: each costs twice the
  /// square of what is trusted, however far it lies, so that a state that ignores samples can be held against
  /// one that does not. @pre update_trust(white) has been called for the state.
  double distrust_cost(double white) const;
  JointTurns& turns() { return turns_; }
  const JointTurns& turns() const { return turns_; }
  /// The log factor of a step: straight between the knots.
  double log_factor(const JointStep& step) const {
    const double here = state_.log_factors[step.knot];
    return step.beyond > 0 ? here + step.beyond * (state_.log_factors[step.knot + 1] - here) : here;
  }
  /// Posterior deviations of the factors of the curves about their mean. @pre evaluate() has succeeded.
  Eigen::VectorXd factor_deviation(const Progress& progress);
  /// A draw of the deviations of all unknowns from their posterior (Laplace's approximation): the solution
  /// for residuals that are noise. The place of the whole is left where it is. One solve.
  /// @pre evaluate() has succeeded with `noise`.
  Eigen::VectorXd draw(const NoiseModel& noise, Random& random) const;
  /// Variance of the mean log factor of all curves, weighted by their lengths, where each has that deviation.
  double mean_factor_variance(double scale) const;

 private:
  /// A reading: residual log(A Xᵀ) − b and its derivative by the frame, −J.
  struct Datum {
    Eigen::Vector3d residual;
    Eigen::Matrix3d J;
    double readings;  ///< how many stand behind it, times their trust
  };
  /// Weights of the residuals, per kind.
  struct Weights {
    double white, scale;
    std::array<double, 3> shape;
    double drift;  ///< at the start of a curve
    /// Per step: φ, its derivative by log ℓ, and 1 / innovation.
    std::vector<double> drift_decay, drift_decay_slope, drift_precision;
  };
  /// Sums of squares of residuals per kind; those of the drift with its weights, and their derivative by log
  /// ℓ.
  struct Moments {
    double white = 0, drift = 0, drift_length = 0;
    std::array<double, 3> shape{};
  };

  Weights weights_of_noise(const NoiseModel& noise) const;
  void assemble(const Weights& weights, const Progress& progress);
  void assemble_curve(int c, const Weights& weights);
  void assemble_nodes();
  void assemble_factors(const Weights& weights);
  /// What the log factors add to −2 log likelihood at the optimum, and the mean of their squares at both ends
  /// of each curve, summed: what stands behind NoiseModel::scale.
  double factor_energy(const Weights& weights, const Eigen::VectorXd& delta, double& squares) const;
  /// Precision of the change of the log factor from a knot of the curve to the next.
  double chain_precision(int curve) const;
  void add_drift_step(int s, const Weights& weights, double s00, double s01, double s11, Moments& m) const;
  void draw_curve(int c, const Weights& weights, Random& random, Eigen::VectorXd& right) const;
  void draw_factors(const Weights& weights, Random& random, Eigen::VectorXd& right) const;
  void draw_shape(Random& random, Eigen::VectorXd& right) const;
  Moments squares_of_curve(int c, const Weights& weights, const Eigen::VectorXd& delta) const;
  Moments traces_of_curve(int c, const Weights& weights) const;
  template <typename OfCurve>
  Moments sum_over_curves(const OfCurve& of_curve) const;
  double constraint_energy(const Eigen::VectorXd& delta) const;
  double log_determinant_of_shape(const Weights& weights, bool with_traces, std::array<double, 3>& traces,
                                  const Progress& progress);
  double trusted_angle(int curve, int k, double white) const;
  Eigen::Vector3d reading_residual(int curve, int k) const;
  void find_rates(int c, bool follow);
  void linearize_curve(int c, bool follow);
  void add_pair(const StepPair& pair, const Eigen::Matrix3d& block);

  const SampledScan& scan_;
  JointOptions options_;
  NoisePrior prior_;
  JointLayout layout_;
  JointState state_;
  JointTurns turns_;
  double normal_precision_ = 0;

  std::vector<Datum> data_;             ///< per sample
  std::vector<Eigen::Vector3d> omega_;  ///< per step, rate of turn
  /// Per sample, from the frames of the last linearisation: its change, and the turn that the pre-filter
  /// makes of it. Both are small and hardly move from step to step, so that they have no derivatives.
  std::vector<Eigen::Vector3d> rate_change_, lag_;
  std::vector<Eigen::Matrix3d> omega_by_;  ///< its derivative by the turn of the frame after less that before
  std::vector<Eigen::Matrix3d> gram_;      ///< per pair of steps
  std::vector<Eigen::Vector3d> misfit_;    ///< per segment
  std::vector<std::vector<Eigen::Vector3d>> reach_;  ///< per segment and knot, its share of the sum of steps
  std::vector<std::vector<Eigen::Matrix3d>> misfit_by_;  ///< per segment and frame
  Eigen::VectorXd right_;
  int n_data_ = 0;
};

/// Draws from the posterior of frames and factors, and of the deviation of the factors, of which a few curves
/// say little. Some ten factorisations and a solve for each draw. @pre the model is at its optimum for
/// `noise`.
std::vector<JointDraw> posterior_draws(JointModel& model, const NoiseModel& noise, int n_draws,
                                       const Progress& progress);

}  // namespace batten
