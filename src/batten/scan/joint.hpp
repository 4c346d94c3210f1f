#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// Standard deviations and lengths of the model behind estimate_jointly(). Lengths are in sizes of the scan.
struct NoiseModel {
  double white = 0;         ///< of one reading, per axis, radians: independent from reading to reading
  double drift = 0;         ///< of the slow drift of the frames, per axis, radians
  double drift_length = 0;  ///< over which the drift forgets itself (to 1/e)
  double scale = 0;         ///< of the logarithm of the odometer factor of a curve
  /// The shape, as the inverse weights of ∫|ω|², ∫|ω'|² and ∫|ω''|² along the curves, ω the rate of turn of
  /// the frame: rad²/size, rad²/size³, rad²/size⁵. Together they say how smooth the object is and on which
  /// scale: bending is small on spheres, jerk on gently waving objects, both are large where there are
  /// features.
  double stretch = 0, bending = 0, jerk = 0;

  /// The first figure that is not above 0, in words, or nothing: what is given to estimate_jointly() must
  /// have them all.
  std::optional<std::string> problem() const;
};

/// Options of estimate_jointly().
struct JointOptions {
  double size = 1;           ///< of the scan (docs/methods.md#conventions), in its unit; > 0
  double reading_noise = 0;  ///< radians, from reading_noise(): where the search for the noise starts
  /// Standard deviation of the logarithm of the length factor of each curve where it is known beforehand
  /// (lengths that are only estimated); 0: found from the data.
  double scale_deviation = 0;
  /// Lengths come from time stamps: how unevenly the hand goes, as the standard deviation of the change of
  /// the log factor over a piece of one size, a random walk along each curve; 0: one factor per curve.
  /// Needs a scale_deviation.
  double speed_deviation = 0;
  /// The noise where it is known; found from the data where not.
  std::optional<NoiseModel> noise;
  /// Density of the noise of the gyroscope's turns, where the scan has any, rad/s/√Hz; nothing: found.
  std::optional<double> turn_density;
  double xi = 10000;   ///< agreement of the normals at nodes relative to the data, as in S (3.30)
  bool robust = true;  ///< samples far from the curve lose their say
  /// Draws from the posterior to be made, JointEstimate::draws; one solve each, at least 0.
  int n_draws = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A draw from the posterior of the joint estimate: what may be true instead of it.
struct JointDraw {
  std::vector<Points> turns;  ///< per curve, n_samples × 3, radians: the frames are exp(turn) · those found
  std::vector<Eigen::VectorXd> log_factors;  ///< per curve, of each step, beyond those found
};

/// Frames, drift, length factors and positions that explain a scan best.
struct JointEstimate {
  SampledScan scan;                    ///< the frames; parameters multiplied by the length factors
  std::vector<Points> drift;           ///< per curve, n_samples × 3 rotation vectors in the world, radians
  Eigen::VectorXd log_factors;         ///< per curve: true length = exp(·) × measured length
  Eigen::VectorXd speed_spread;        ///< per curve: root mean square of the log factor about its mean
  Eigen::VectorXd factor_deviation;    ///< their posterior standard deviations about the mean of all curves
  NoiseModel noise;                    ///< as found
  std::vector<Eigen::VectorXd> trust;  ///< per curve and sample: 1 kept … 0 ignored by the robust loss
  bool has_turns = false;              ///< of a gyroscope; the figures below are 0 without
  double turn_density = 0;             ///< of their noise, rad/s/√Hz
  Points gyroscope_bias;               ///< per some seconds, in the axes of the frames, rad/s
  Eigen::Matrix3d gyroscope_matrix = Eigen::Matrix3d::Zero();  ///< M: true rate = (I + M)(reading − bias)
  std::vector<JointDraw> draws;                                ///< as many as asked for
  double evidence = 0;     ///< −2 log marginal likelihood, up to a constant
  double cost = 0;         ///< the same with what the samples cost that are not trusted: to compare estimates
  int iterations = 0;      ///< Gauss–Newton steps
  bool converged = false;  ///< the last of them was below 1e-6 radians, or within rounding
  int evaluations = 0;     ///< noise models tried
};

/// Estimates frames, slow drift of the frames, and odometer factors at once, so that the network closes.
///
/// Model, beyond the thesis: a reading is exp(white + b(s)) X(s) with b an Ornstein–Uhlenbeck process along
/// the curve; the rate of turn of X is a Wiener process (the E_2 of S 3.26 as a prior); the steps integrate
/// to positions that meet at the nodes when each curve's length is multiplied by its factor; normals agree at
/// nodes (E_N). The frames, b, positions and factors are the maximum a posteriori, by Gauss–Newton on one
/// sparse system; the figures of NoiseModel maximise the marginal likelihood (Laplace's approximation)
/// under weak priors, by a quasi-Newton search with exact derivatives from the selected inverse
/// (docs/methods.md#regression). So closure, agreement of normals and smoothness all speak about the noise,
/// and networks without loops need no other rule. With a gyroscope (SampledCurve::turns) neighbouring frames
/// are joined by its turns, log(Gᵀ X_kᵀ X_{k+1}) with G = exp((I + M)(g − b Δt)); the bias b, which may walk,
/// the matrix M of scale and alignment and the density of the noise are found as well. What comes and goes
/// without a turn of the device (drift, magnets) is then told from shape. Linear in the samples of a network;
/// some fifty factorisations where the noise is to be found, some ten where it is given.
/// @throws InvalidInput, SolverFailure, Cancelled.
JointEstimate estimate_jointly(const SampledScan& scan, const JointOptions& options,
                               const Progress& progress = {});

}  // namespace batten
