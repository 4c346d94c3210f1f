#include "batten/scan/reconstruct.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/joint_turns_detail.hpp"
#include "batten/scan/length_model_detail.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/rate_change_detail.hpp"
#include "batten/scan/weights.hpp"

namespace batten {

namespace {

/// Above this many samples the noise model is searched for on fewer, whose step is twice that of the samples
/// or, while they are more, at most so large a part of the size: its figures do not depend on the step, and
/// the search solves some fifty systems.
constexpr int kSearchSamples = 400;
constexpr double kSearchStep = 0.032;

/// The distance between readings on average, for "none".
double mean_step(const SampledScan& scan) {
  long n = 0;
  for (const SampledCurve& curve : scan.curves) n += curve.n_samples() - 1;
  return scan.length() / static_cast<double>(std::max(n, 1L));
}

/// @throws InvalidInput where a step would give more samples than anybody has memory for.
void require_possible_step(const Scan& scan, double step) {
  constexpr double kMostSamples = 1e8;
  double length = 0;
  for (const ScanCurve& curve : scan.curves)
    if (curve.n_readings() > 0) length += curve.distances[curve.n_readings() - 1] - curve.distances[0];
  if (length / step > kMostSamples)
    throw InvalidInput(concat("a step of ", step, " gives about ", length / step, " samples, more than ",
                              kMostSamples, "; use a longer one"));
}

/// The share of the samples of each curve that the robust loss holds for wrong. @param trust per curve.
std::vector<double> distrusted_shares(const std::vector<Eigen::VectorXd>& trust) {
  std::vector<double> shares;
  for (const Eigen::VectorXd& of_curve : trust)
    shares.push_back(static_cast<double>((of_curve.array() < 0.25).count()) /
                     static_cast<double>(of_curve.size()));
  return shares;
}

/// How positions are integrated, as integrate_steps() wants it.
struct Integration {
  StepRule rule;
  ClosureForm form;
};
Integration integration_of(IntegrationScheme scheme) {
  return scheme == IntegrationScheme::Thesis
             ? Integration{StepRule::Tangent, ClosureForm::SecondDifference}
             : Integration{StepRule::ConstantRate, ClosureForm::FirstDifference};
}

std::vector<Points> network_steps(const SampledScan& frames, IntegrationScheme scheme) {
  return scheme == IntegrationScheme::Thesis ? frame_steps(frames, StepRule::Tangent)
                                             : fourth_order_steps(frames);
}

ScanGyroscope gyroscope_of(const JointEstimate& estimate) {
  ScanGyroscope gyroscope;
  gyroscope.bias = estimate.gyroscope_bias.colwise().mean();
  gyroscope.bias_range =
      (estimate.gyroscope_bias.rowwise() - gyroscope.bias.transpose()).rowwise().norm().maxCoeff();
  gyroscope.matrix = estimate.gyroscope_matrix;
  gyroscope.density = estimate.turn_density;
  return gyroscope;
}

void leave_out_turns(SampledScan& scan) {
  for (SampledCurve& curve : scan.curves) {
    curve.turns.resize(0, 3);
    curve.turn_times.resize(0);
  }
}

/// estimate_jointly(), without the gyroscope where its turns do not fit the frames.
JointEstimate estimate_with_turns(SampledScan& samples, const JointOptions& joint, ScanReport& report,
                                  const Progress& progress) {
  JointEstimate estimate = estimate_jointly(samples, joint, progress);
  if (!estimate.has_turns || estimate.turn_density <= kUselessTurnDensity) return estimate;
  report.warnings.emplace_back(
      "the turns of the gyroscope do not fit the orientations and are left out; check its unit (rad/s), its "
      "axes and its times");
  leave_out_turns(samples);
  return estimate_jointly(samples, joint, progress);
}

JointEstimate jointly(const Scan& scan, const std::vector<CleanCurve>& clean,
                      const PrefilterOptions& prefilter, const ScanOptions& options, ScanReport& report,
                      const Progress& progress) {
  PrefilterOptions sampling = prefilter;
  sampling.wrap = false;  // the drift at the start of a closed curve is not the drift at its end
  SampledScan samples = resample(scan, clean, sampling, progress);
  JointOptions joint;
  joint.size = report.size;
  joint.reading_noise = report.reading_noise;
  joint.xi = options.xi;
  joint.robust = options.robust;
  const bool is_estimated = options.lengths == LengthChoice::Estimated;
  if (is_estimated || samples.n_samples() > kSearchSamples) {
    PrefilterOptions coarse = sampling;
    const double step = sampling.step > 0 ? sampling.step : mean_step(samples);
    const double thinning = static_cast<double>(samples.n_samples()) / kSearchSamples;
    coarse.step = std::max(2 * step, std::min(kSearchStep * report.size, thinning * step));
    // Of readings that lie closer only a share is taken: each sample is worth as many as at twice the step.
    const double share = 2 * step / coarse.step;
    coarse.sigma *= share;
    SampledScan fewer = resample(scan, clean, coarse, progress);
    for (SampledCurve& curve : fewer.curves) curve.weights *= share;
    JointEstimate search;
    if (is_estimated) {
      LengthModel lengths = choose_length_model(fewer, joint, progress);
      joint.scale_deviation = lengths.scale_deviation;
      joint.speed_deviation = lengths.speed_deviation;
      report.lengths = lengths.words;
      search = std::move(lengths.estimate);
    } else {
      search = estimate_with_turns(fewer, joint, report, progress);
    }
    joint.noise = search.noise;
    joint.turn_density = search.turn_density;
    if (!search.has_turns) leave_out_turns(samples);
  }
  if (options.uncertainty) joint.n_draws = kUncertaintyDraws;
  JointEstimate estimate = estimate_with_turns(samples, joint, report, progress);
  if (!estimate.converged)
    report.warnings.push_back(concat("the joint estimate of frames and positions had not converged after ",
                                     estimate.iterations, " steps"));
  report.noise = estimate.noise;
  if (estimate.has_turns) report.gyroscope = gyroscope_of(estimate);
  report.iterations = estimate.iterations;
  report.evidence = estimate.evidence;
  double readings = 0;
  for (const CleanCurve& curve : clean) readings += curve.counts.sum();
  const RegressionWeights weights = weights_of(estimate.noise, readings / samples.n_samples());
  report.lambda = weights.lambda;
  report.mu = weights.mu;
  report.weights_reason =
      concat("noise model of greatest marginal likelihood: white ", degrees(estimate.noise.white),
             "°, drift ", degrees(estimate.noise.drift), "° over ", 100 * estimate.noise.drift_length,
             " % of the size, odometer ", 100 * estimate.noise.scale, " %");
  for (size_t c = 0; c < samples.curves.size(); ++c) {
    report.factors.push_back(std::exp(estimate.log_factors[static_cast<Eigen::Index>(c)]));
    report.factor_deviations.push_back(estimate.factor_deviation[static_cast<Eigen::Index>(c)]);
    report.speed_spread.push_back(estimate.speed_spread[static_cast<Eigen::Index>(c)]);
  }
  report.distrusted = distrusted_shares(estimate.trust);
  return estimate;
}

void place_jointly(const Scan& scan, const std::vector<CleanCurve>& clean, const PrefilterOptions& prefilter,
                   const ScanOptions& options, ScanNetwork& result, const Progress& progress) {
  JointEstimate estimate = jointly(scan, clean, prefilter, options, result.report, progress);
  if (options.uncertainty) result.uncertainty = network_uncertainty(estimate, progress);
  result.samples = std::move(estimate.scan);
}

/// Options of the plain regression of samples, with weights as the options say.
RegressionOptions regression_options(const SampledScan& samples, const ScanOptions& options,
                                     ScanReport& report, const Progress& progress) {
  const auto [rule, form] = integration_of(options.scheme);
  const double step = mean_step(samples) / report.size;
  RegressionOptions regression;
  regression.energy = options.energy;
  regression.xi = options.xi;
  regression.robust = options.robust;
  regression.unit = report.size;
  if (options.weights == WeightChoice::Auto) {
    // The noise model, for networks whose closure says nothing.
    NoiseModel noise;
    JointOptions joint;
    joint.size = report.size;
    joint.reading_noise = report.reading_noise;
    joint.robust = options.robust;
    if (integrate_steps(samples, frame_steps(samples, rule), form).n_loops == 0)
      noise = estimate_jointly(samples, joint, progress).noise;
    const RegressionWeights weights =
        choose_weights(samples, report.size, regression, rule, form, &noise, progress);
    regression.lambda = weights.lambda;
    regression.mu = weights.mu;
    report.weights_reason = weights.reason;
  } else if (options.weights == WeightChoice::Thesis) {
    report.weights_reason = "lambda = 1, mu = 100 in the unit of the scan, as the thesis uses them";
    regression.lambda = 1 / report.size;
    regression.mu = 100 / std::pow(report.size, 3);
    if (options.energy == RegressionEnergy::Scaled) {
      regression.lambda = scaled_weight(regression.lambda, step);
      regression.mu = scaled_weight(regression.mu, step);
    }
  } else {
    report.weights_reason = "given";
    regression.lambda = options.lambda;
    regression.mu = options.mu;
  }
  report.lambda = regression.lambda;
  report.mu = regression.mu;
  return regression;
}

/// Loops that close this well, relative to the length of a curve, were drawn or computed, not measured.
constexpr double kExactClosure = 1e-5;

/// The steps of a scan whose tangents point to the next reading: the chords themselves.
std::vector<Points> chord_steps(const Scan& scan) {
  std::vector<Points> steps;
  for (const ScanCurve& curve : scan.curves) {
    std::vector<Eigen::RowVector3d> chords;
    for (Eigen::Index i = 0; i + 1 < curve.n_readings(); ++i) {
      const double h = curve.distances[i + 1] - curve.distances[i];
      if (h > 0) chords.push_back(h * curve.tangents.row(i).normalized());
    }
    Points rows(static_cast<Eigen::Index>(chords.size()), 3);
    for (size_t k = 0; k < chords.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = chords[k];
    steps.push_back(std::move(rows));
  }
  return steps;
}

/// Curves whose factors closure cannot tell: their deviation is still about what was assumed beforehand.
void note_undetermined(const Scan& scan, ScanReport& report) {
  if (report.factor_deviations.size() < 2) return;
  std::vector<int> open;
  // About the mean of n independent factors the prior deviation is s √(1 − 1/n).
  const double n = static_cast<double>(report.factor_deviations.size());
  const double prior = kEstimatedLengths * std::sqrt(1 - 1 / n);
  for (size_t c = 0; c < report.factor_deviations.size(); ++c)
    if (report.factor_deviations[c] > 0.3 * prior) open.push_back(static_cast<int>(c));
  for (const int c : open) {
    std::string sentence = concat(
        "the length of ", curve_label(scan, c), " against the other curves is not determined by closure (",
        100 * report.factor_deviations[c], " % deviation left); measure this curve");
    report.undetermined.push_back(sentence);
    report.warnings.push_back(sentence);
  }
}

CurveNetwork assemble(const Scan& scan, const SampledScan& samples, const Points& positions) {
  const VertexNumbering numbering = number_vertices(samples);
  CurveNetwork network;
  network.unit = scan.unit;
  network.positions = positions.rowwise() - positions.colwise().mean();
  network.normals = Points::Zero(numbering.n_vertices, 3);
  for (size_t c = 0; c < samples.curves.size(); ++c) {
    const SampledCurve& curve = samples.curves[c];
    NetworkCurve out;
    out.name = curve.name;
    out.boundary = curve.boundary;
    out.sharp = curve.sharp;
    out.vertices = numbering.vertices[c];
    network.curves.push_back(std::move(out));
    for (int k = 0; k < curve.n_samples(); ++k)
      network.normals.row(numbering.vertices[c][k]) += curve.frames[k].col(1).transpose();
    for (const int sample : curve.node_samples) network.tagged_nodes.push_back(numbering.vertices[c][sample]);
  }
  for (int v = 0; v < numbering.n_vertices; ++v) network.normals.row(v).normalize();
  std::sort(network.tagged_nodes.begin(), network.tagged_nodes.end());
  network.tagged_nodes.erase(std::unique(network.tagged_nodes.begin(), network.tagged_nodes.end()),
                             network.tagged_nodes.end());
  return network;
}

}  // namespace

std::optional<std::string> ScanOptions::problem() const {
  const auto negative = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (step && !(step->value > 0)) return concat("step must be > 0, got ", step->value);
  if (negative(lambda)) return concat("lambda must be >= 0, got ", lambda);
  if (negative(mu)) return concat("mu must be >= 0, got ", mu);
  if (negative(xi)) return concat("xi must be >= 0, got ", xi);
  if (!(sigma > 0 && sigma <= 2)) return concat("sigma must be in (0, 2], got ", sigma);
  if (lengths == LengthChoice::Estimated &&
      (weights != WeightChoice::Auto || energy == RegressionEnergy::Thesis))
    return "lengths can only be estimated with weights auto and the scaled energy";
  if (uncertainty && (weights != WeightChoice::Auto || energy == RegressionEnergy::Thesis))
    return "the uncertainty can only be told with weights auto and the scaled energy";
  return std::nullopt;
}

namespace {

/// Variations of the speed along a curve, root mean square, of which it is told.
constexpr double kUnevenSpeed = 0.05;

void warn_of_curves(const Scan& scan, ScanReport& report) {
  for (int c = 0; c < report.n_curves; ++c) {
    const double share =
        static_cast<double>(report.outliers[c]) / static_cast<double>(scan.curves[c].n_readings());
    if (share > 0.2)
      report.warnings.push_back(concat(curve_label(scan, c), ": ", report.outliers[c], " of ",
                                       scan.curves[c].n_readings(),
                                       " readings were outliers; record it again"));
    if (!report.speed_spread.empty() && report.speed_spread[c] > kUnevenSpeed)
      report.warnings.push_back(concat(curve_label(scan, c), ": drawn with a speed that varies by ",
                                       100 * report.speed_spread[c],
                                       " % along it; closure told so much and no more, draw it evenly"));
    if (report.distrusted[c] > 0.03)
      report.warnings.push_back(concat(curve_label(scan, c), ": ", 100 * report.distrusted[c],
                                       " % of its samples contradict the rest and were ignored (a magnetic "
                                       "disturbance?); check it or record it again"));
  }
}

/// The frames of `smooth` at the parameters of `samples`, on the shortest turns between neighbours.
SampledScan at_samples(const SampledScan& smooth, SampledScan samples) {
  for (size_t c = 0; c < samples.curves.size(); ++c) {
    const SampledCurve& from = smooth.curves[c];
    int k = 0;
    for (int i = 0; i < samples.curves[c].n_samples(); ++i) {
      const double s = samples.curves[c].parameters[i];
      while (k + 2 < from.n_samples() && from.parameters[k + 1] < s) ++k;
      const double u = std::clamp((s - from.parameters[k]) / from.step(k), 0.0, 1.0);
      const Eigen::Matrix3d& X = from.frames[k];
      samples.curves[c].frames[i] = X * so3_exp(u * so3_log(X.transpose() * from.frames[k + 1]));
    }
  }
  return samples;
}

}  // namespace

/// What does not depend on weights, step and radius: the readings cleaned, and what the report says of them.
struct ReconstructionSolver::Readings {
  Readings(const Scan& given, bool robust, const Progress& progress);

  std::optional<Scan> converted;  ///< to frames at the readings
  std::vector<CleanCurve> clean;
  ScanReport report;
};

ReconstructionSolver::Readings::Readings(const Scan& given, bool robust, const Progress& progress) {
  const ScopedStage stage(report.times, "prefilter");
  progress.report("prefilter", 0);
  check_scan(given);
  report.convention = tangent_convention(given);
  if (report.convention.uncertain)
    report.warnings.push_back("it is not certain what the tangents mean: " + report.convention.reason +
                              "; state it in the file if this is wrong");
  CleanOptions cleaning;
  cleaning.robust = robust;
  if (report.convention.convention == TangentConvention::ToNext) {
    converted = frames_at_samples(given);
    // Tangents to the next reading come from drawn curves: every one is needed to follow the others.
    cleaning = {0, false};
  }
  const Scan& scan = converted ? *converted : given;
  progress.report("prefilter", 0);
  clean = clean_readings(scan, cleaning, report.warnings, progress);
  for (const CleanCurve& curve : clean) {
    report.outliers.push_back(curve.n_outliers);
    report.n_duplicates += curve.n_duplicates;
  }
  for (const ScanCurve& curve : scan.curves) report.n_readings += curve.n_readings();
  report.reading_noise = reading_noise(clean);
  const SampledScan samples = resample(scan, clean, PrefilterOptions{}, progress);
  progress.report("prefilter", 1);
  const IntegrationResult raw =
      integrate_steps(samples, frame_steps(samples, StepRule::ConstantRate), ClosureForm::FirstDifference);
  report.size = scan_size(raw.positions);
  report.closure_misfit_before = raw.closure_misfit;
  report.n_loops = raw.n_loops;
  if (!(report.size > 0)) throw InvalidInput("the scan has no size: all its points fall together");
}

/// The samples of one step and radius with their regression.
struct ReconstructionSolver::Sampling {
  const Readings* readings;
  double step, sigma;
  SampledScan samples;
  FrameRegression regression;
};

ReconstructionSolver::ReconstructionSolver(Scan scan) : scan_(std::move(scan)) {}
ReconstructionSolver::~ReconstructionSolver() = default;
ReconstructionSolver::ReconstructionSolver(ReconstructionSolver&&) noexcept = default;
ReconstructionSolver& ReconstructionSolver::operator=(ReconstructionSolver&&) noexcept = default;

ReconstructionSolver::Sampling& ReconstructionSolver::sampling(const Readings& readings,
                                                               const PrefilterOptions& prefilter,
                                                               const Progress& progress) {
  if (sampling_ && sampling_->readings == &readings && sampling_->step == prefilter.step &&
      sampling_->sigma == prefilter.sigma)
    return *sampling_;
  SampledScan samples =
      resample(readings.converted ? *readings.converted : scan_, readings.clean, prefilter, progress);
  const bool same_places = sampling_ && sampling_->readings == &readings && sampling_->step == prefilter.step;
  if (same_places) {
    sampling_->regression.set_frames(samples);
    sampling_->sigma = prefilter.sigma;
    sampling_->samples = std::move(samples);
    return *sampling_;
  }
  progress.report("regression", 0);
  FrameRegression regression(samples);
  if (last_) regression.start(at_samples(last_->frames, samples), last_->robust_scale);
  sampling_ = std::make_unique<Sampling>(
      Sampling{&readings, prefilter.step, prefilter.sigma, std::move(samples), std::move(regression)});
  return *sampling_;
}

ScanNetwork ReconstructionSolver::solve(const ScanOptions& options, const Progress& progress) {
  return reconstruct(options, false, progress);
}

ScanNetwork ReconstructionSolver::follow(const ScanOptions& options, const Progress& progress) {
  return reconstruct(options, true, progress);
}

void ReconstructionSolver::regress(const Readings& readings, const PrefilterOptions& prefilter,
                                   const ScanOptions& options, bool exact, bool moving, ScanNetwork& result,
                                   const Progress& progress) {
  ScanReport& report = result.report;
  Sampling& kept = sampling(readings, prefilter, progress);
  RegressionOptions regression;
  regression.unit = report.size;
  regression.xi = options.xi;
  if (exact)
    report.weights_reason =
        concat("the tangents lead round the loops to within ", report.convention.forward_misfit,
               " of a curve's length: taken as exact, nothing to smooth");
  else
    regression = regression_options(kept.samples, options, report, progress);
  RegressionReport done;
  result.samples = moving ? kept.regression.follow(regression, &done, progress)
                          : kept.regression.solve(regression, &done, progress);
  if (!moving && !done.converged)
    report.warnings.push_back(
        concat("the regression of the frames had not converged after ", done.iterations, " steps"));
  report.regression = done;
  report.iterations = done.iterations;
  report.distrusted = distrusted_shares(done.trust);
  report.factors.assign(kept.samples.curves.size(), 1.0);
  last_ = Last{result.samples, done.robust_scale};
  if (options.scheme == IntegrationScheme::Midpoint) remove_lag(result.samples);
}

ScanNetwork ReconstructionSolver::reconstruct(const ScanOptions& options, bool moving,
                                              const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  std::unique_ptr<Readings>& slot = readings_[options.robust ? 1 : 0];
  ScanNetwork result;
  ScanReport& report = result.report;
  if (!slot) {
    slot = std::make_unique<Readings>(scan_, options.robust, progress);
    report = slot->report;
  } else {
    report = slot->report;
    report.times = {};
  }
  const Readings& readings = *slot;
  const Scan& scan = readings.converted ? *readings.converted : scan_;
  PrefilterOptions prefilter;
  prefilter.sigma = options.sigma;
  if (options.step) prefilter.step = options.step->in_file_units(report.size);
  if (options.step) require_possible_step(scan, prefilter.step);
  if (options.step && prefilter.step > 0.5 * report.size)
    throw InvalidInput(concat("the step ", prefilter.step, " is more than half the size of the scan, ",
                              report.size, "; take a smaller one"));
  const ClosureForm form = integration_of(options.scheme).form;
  // Drawn curves: the chords close exactly, so there is no noise to take off them; only the normals at nodes
  // are made to agree. At their own samples the chords are the steps.
  const bool exact = report.convention.convention == TangentConvention::ToNext &&
                     report.convention.forward_misfit >= 0 &&
                     report.convention.forward_misfit < kExactClosure &&
                     options.weights == WeightChoice::Auto && options.lengths == LengthChoice::Measured;
  const bool exact_chords = exact && !options.step;
  {
    const ScopedStage stage(report.times, "regression");
    if (!exact && options.weights == WeightChoice::Auto && options.energy == RegressionEnergy::Scaled)
      place_jointly(scan, readings.clean, prefilter, options, result, progress);
    else
      regress(readings, prefilter, options, exact, moving, result, progress);
  }
  {
    const ScopedStage stage(report.times, "integration");
    progress.report("integration", 0);
    const IntegrationResult placed = integrate_steps(
        result.samples, exact_chords ? chord_steps(scan_) : network_steps(result.samples, options.scheme),
        form);
    report.closure_misfit = placed.closure_misfit;
    result.network = assemble(scan, result.samples, placed.positions);
    if (options.uncertainty && !result.uncertainty)
      result.uncertainty = NetworkUncertainty{Eigen::VectorXd::Zero(placed.positions.rows()), {}};
  }
  report.step = mean_step(result.samples);
  report.n_samples = result.samples.n_samples();
  const NetworkTopology topology = network_topology(result.network);
  report.n_curves = static_cast<int>(result.network.curves.size());
  report.n_nodes = static_cast<int>(topology.nodes.size());
  report.n_segments = static_cast<int>(topology.segments.size());
  if (options.lengths == LengthChoice::Estimated) note_undetermined(scan, report);
  warn_of_curves(scan, report);
  return result;
}

ScanNetwork network_from_scan(const Scan& scan, const ScanOptions& options, const Progress& progress) {
  return ReconstructionSolver(scan).solve(options, progress);
}

}  // namespace batten
