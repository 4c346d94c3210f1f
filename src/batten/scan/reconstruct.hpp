#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/core/units.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/scan/convention.hpp"
#include "batten/scan/joint.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/regression.hpp"
#include "batten/scan/scan.hpp"
#include "batten/scan/uncertainty.hpp"

namespace batten {

/// Where λ and μ come from.
enum class WeightChoice {
  /// From the data. With the scaled energy: frames, drift and odometer factors together (estimate_jointly()).
  /// With the thesis energy: the pair whose network closes best (choose_weights()).
  Auto,
  Thesis,  ///< λ = 1, μ = 100 with the unit of the scan as the unit of length (S 3.7.2)
  Given,   ///< ScanOptions::lambda and mu, lengths in sizes of the scan
};

constexpr auto choices_of(WeightChoice) {
  return choices<WeightChoice>(
      "choice of weights",
      {{WeightChoice::Auto, "auto"}, {WeightChoice::Thesis, "thesis"}, {WeightChoice::Given, "given"}});
}

/// How positions are integrated.
enum class IntegrationScheme {
  Midpoint,  ///< turning frames (fourth_order_steps()), first-difference form, O(N)
  Thesis,    ///< S (3.32): tangents at the samples, second-difference form: first order
};
constexpr auto choices_of(IntegrationScheme) {
  return choices<IntegrationScheme>(
      "scheme", {{IntegrationScheme::Midpoint, "midpoint"}, {IntegrationScheme::Thesis, "thesis"}});
}

/// What the distances of the readings are worth.
enum class LengthChoice {
  Measured,  ///< right up to the error of an odometer
  /// From time stamps: right up to a factor for each curve, or one that changes along it, found from closure.
  Estimated,
};
constexpr auto choices_of(LengthChoice) {
  return choices<LengthChoice>(
      "choice of lengths", {{LengthChoice::Measured, "measured"}, {LengthChoice::Estimated, "estimated"}});
}

/// Options of network_from_scan(). The defaults are those of `batten network`.
struct ScanOptions {
  /// Distance between samples; nothing: the samples are the readings themselves.
  std::optional<Length> step = Length{0.016, Length::Kind::Relative};
  WeightChoice weights = WeightChoice::Auto;
  double lambda = 0, mu = 0;  ///< for WeightChoice::Given
  RegressionEnergy energy = RegressionEnergy::Scaled;
  double xi = 10000;   ///< agreement of the normals at nodes (S 3.30)
  bool robust = true;  ///< outliers are removed also in runs, and samples far off the curve lose their say
  IntegrationScheme scheme = IntegrationScheme::Midpoint;
  LengthChoice lengths = LengthChoice::Measured;
  double sigma = 0.35;  ///< radius of the pre-filter as a part of the step, S 3.5.3; (0, 2]
  /// How sure each vertex is, ScanNetwork::uncertainty: needs automatic weights and the scaled energy. Costs
  /// kUncertaintyDraws solves and integrations.
  bool uncertainty = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What the joint estimate found out about the gyroscope of a scan.
struct ScanGyroscope {
  Eigen::Vector3d bias =
      Eigen::Vector3d::Zero();  ///< mean over time, in the axes of the Darboux frame, rad/s
  double bias_range = 0;        ///< how far it wanders from that mean at most, rad/s
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  ///< M: true rate = (I + M)(reading − bias)
  double density = 0;                                ///< of its noise, as used, rad/s/√Hz
};

/// What happened on the way. Lengths in the unit of the scan, angles in radians.
struct ScanReport {
  double size = 0;  ///< twice the greatest distance from the centroid after unfiltered integration
                    ///< (docs/methods.md#conventions)
  double step = 0;  ///< mean distance between samples
  int n_curves = 0, n_nodes = 0, n_segments = 0, n_loops = 0;
  long n_readings = 0, n_samples = 0, n_duplicates = 0;
  std::vector<int> outliers;       ///< per curve: readings removed
  std::vector<double> distrusted;  ///< per curve: share of the samples that the robust loss holds for wrong
  ConventionReport convention;
  double reading_noise = 0;   ///< of one reading, per axis
  double lambda = 0, mu = 0;  ///< as used, or what the noise model stands for; lengths in sizes
  std::string weights_reason;
  std::optional<NoiseModel> noise;         ///< with the joint estimate
  std::optional<ScanGyroscope> gyroscope;  ///< the same, where the scan has the turns of one
  std::vector<double> factors;             ///< per curve: length used over length measured
  std::vector<double> factor_deviations;   ///< their standard deviations; empty without the joint estimate
  std::vector<double> speed_spread;        ///< per curve: variation of the factor along it, root mean square
  std::string lengths;                     ///< with LengthChoice::Estimated: what they turned out to be
  std::vector<std::string> undetermined;   ///< ratios of lengths that closure leaves open, in words
  double closure_misfit_before = 0;        ///< root mean square over segments, unfiltered
  double closure_misfit = 0;               ///< with the frames and lengths found
  RegressionReport regression;             ///< of the plain regression
  int iterations = 0;
  double evidence = 0;  ///< −2 log marginal likelihood of the joint estimate
  std::vector<std::string> warnings;
  StageTimes times;
};

/// A reconstructed network: one curve per curve of the scan in its order; nodes first among the vertices, by
/// increasing number; closed curves repeat their first vertex. The mean of the vertices is the origin.
struct ScanNetwork {
  CurveNetwork network;
  ScanReport report;
  SampledScan samples;  ///< the frames behind it
  /// Where it was asked for. Curves that close exactly are taken as exact: deviations of 0, no draws.
  std::optional<NetworkUncertainty> uncertainty;
};

/// From readings to positions: outliers and duplicates, pre-filter, frames (with drift and odometer factors,
/// or by the plain regression), integration (S 3.5–3.6).
/// @throws InvalidInput with curve, reading or node and the remedy; SolverFailure; Cancelled.
ScanNetwork network_from_scan(const Scan& scan, const ScanOptions& options = {},
                              const Progress& progress = {});

/// network_from_scan() kept for one scan, for sliders: the readings are cleaned once (twice when the robust
/// loss is switched), samples are kept for one step and radius of the pre-filter, pattern and ordering of the
/// regression for one step. What is kept does not grow with the number of calls.
class ReconstructionSolver {
 public:
  /// @throws InvalidInput as network_from_scan() on a scan that cannot be used.
  explicit ReconstructionSolver(Scan scan);
  ~ReconstructionSolver();
  ReconstructionSolver(ReconstructionSolver&&) noexcept;
  ReconstructionSolver& operator=(ReconstructionSolver&&) noexcept;

  /// The network at rest: the same bits as network_from_scan(), whatever was asked before. The robust loss
  /// has more than one minimum, so the way to it starts from the data each time.
  /// @throws as network_from_scan(); the next call is not affected.
  ScanNetwork solve(const ScanOptions& options, const Progress& progress = {});
  /// The network while something moves: one or two steps from the last frames and trust,
  /// FrameRegression::follow(). With automatic weights and the scaled energy nothing is kept but the
  /// readings: as solve().
  ScanNetwork follow(const ScanOptions& options, const Progress& progress = {});

 private:
  struct Readings;
  struct Sampling;
  struct Last {
    SampledScan frames;
    double robust_scale;
  };
  ScanNetwork reconstruct(const ScanOptions& options, bool moving, const Progress& progress);
  void regress(const Readings& readings, const PrefilterOptions& prefilter, const ScanOptions& options,
               bool exact, bool moving, ScanNetwork& result, const Progress& progress);
  Sampling& sampling(const Readings& readings, const PrefilterOptions& prefilter, const Progress& progress);

  Scan scan_;
  std::array<std::unique_ptr<Readings>, 2> readings_;  ///< without and with robust cleaning
  std::unique_ptr<Sampling> sampling_;
  std::optional<Last> last_;
};

}  // namespace batten
