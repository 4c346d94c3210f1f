#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// Which energy is minimised.
enum class RegressionEnergy {
  /// S (3.30): ξ E_N + E_0 + λ E_1 + μ E_2, lengths measured in RegressionOptions::unit.
  Thesis,
  /// h ξ E_N + h E_0 + λ E_1 + μ E_2 with lengths measured in units of the size of the scan: the same weights
  /// smooth as much at every resolution, size and unit (docs/methods.md#regression).
  Scaled,
};
constexpr auto choices_of(RegressionEnergy) {
  return choices<RegressionEnergy>(
      "energy", {{RegressionEnergy::Scaled, "scaled"}, {RegressionEnergy::Thesis, "thesis"}});
}

/// Options of regress_frames().
struct RegressionOptions {
  RegressionEnergy energy = RegressionEnergy::Scaled;
  double lambda = 0;  ///< stretching, ≥ 0: half-power wavelength 2π√(λh) (thesis), 2π√λ (scaled)
  double mu = 0;      ///< bending, ≥ 0: half-power wavelength 2π(μh)^¼ (thesis), 2πμ^¼ (scaled)
  double xi = 10000;  ///< agreement of the normals at nodes, ≥ 0 (S 3.7.2)
  double unit = 1;    ///< the length that counts as 1 in E_1 and E_2, in the unit of the scan, > 0
  /// Geman–McClure loss on E_0 instead of the square: samples far off the curve lose their say. Its scale is
  /// six times the spread of the residuals (median).
  bool robust = false;
  int max_iterations = 100;  ///< ≥ 0
  double tolerance = 1e-10;  ///< stop when no frame turns by more, in radians

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What the regression reached. Energies without their weights, as printed in S (3.27) and (3.29).
struct RegressionReport {
  int iterations = 0;
  bool converged = false;
  double energy = 0;  ///< the weighted sum that was minimised
  double E_N = 0, E_0 = 0, E_1 = 0, E_2 = 0;
  double robust_scale = 0;             ///< radians; 0 without the robust loss
  std::vector<Eigen::VectorXd> trust;  ///< per curve and sample: 1 kept … 0 ignored by the robust loss
  StageTimes times;                    ///< "setup", "assembly", "factorisation", "update"
};

/// Smooths the frames of all curves at once (S 3.5.4), by Newton's method on SO(3)ᴺ, X ← X exp(δ^), with
/// analytic second derivatives; Gauss–Newton where they are indefinite, damping where the energy would rise.
/// Chordal E_0, E_1, skew E_2, with the forms of docs/errata.md#s-3 where steps differ; closed curves with a
/// smooth seam are periodic. With a gyroscope (SampledCurve::turns) the data are not the frames of the scan
/// but those that they and its turns make most probable together, drift and disturbances left out. 4 to 6
/// steps, 8 to 14 with the robust loss; each is linear in the samples.
/// @return `scan` with its frames replaced.
/// @throws InvalidInput when a weight is negative or neighbouring frames differ by a right angle or more
/// (where the skew form of E_2 is not monotone), SolverFailure, Cancelled.
SampledScan regress_frames(const SampledScan& scan, const RegressionOptions& options,
                           RegressionReport* report = nullptr, const Progress& progress = {});

/// regress_frames() kept: pattern and ordering are found once for the samples of a scan.
class FrameRegression {
 public:
  /// @throws InvalidInput as regress_frames() on samples that cannot be used.
  explicit FrameRegression(const SampledScan& scan);
  ~FrameRegression();
  FrameRegression(FrameRegression&&) noexcept;
  FrameRegression& operator=(FrameRegression&&) noexcept;

  /// Takes the frames of a scan with the same curves, parameters and nodes.
  /// @throws InvalidInput when the number of samples differs.
  void set_frames(const SampledScan& scan);
  /// What regress_frames() gives, whatever was solved before.
  SampledScan solve(const RegressionOptions& options, RegressionReport* report = nullptr,
                    const Progress& progress = {});
  /// Where follow() starts, for the first call at other samples.
  /// @param frames at the same samples. @param robust_scale of the report that they came with.
  void start(const SampledScan& frames, double robust_scale);
  /// The same minimum nearly, while weights or frames move: Newton steps from the last frames and the last
  /// scale of the robust loss, until one turns no frame by more than 0.02 radians (its error is then about
  /// the square of that), at most two. Without frames to start from, as solve().
  SampledScan follow(const RegressionOptions& options, RegressionReport* report = nullptr,
                     const Progress& progress = {});

 private:
  struct State;
  void begin(const RegressionOptions& options, StageTimes& times);
  SampledScan finish(bool converged, const StageTimes& times, RegressionReport* report) const;

  SampledScan scan_;
  std::unique_ptr<State> state_;
};

/// The energy of given frames: `frames` against the data `scan`, with the squared loss, or with the robust
/// one at a scale given in radians. For tests and comparisons.
RegressionReport regression_energy(const SampledScan& scan, const SampledScan& frames,
                                   const RegressionOptions& options, double robust_scale = 0);

}  // namespace batten
