#include "batten/fairing/automatic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/fairer_detail.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {

namespace {

using Eigen::VectorXd;
using fairing_detail::Fairer;
using fairing_detail::FairingRun;
using fairing_detail::kOrganic;
using fairing_detail::kSharp;
using fairing_detail::Strategy;

/// Robust standard deviations, of a distribution with long tails, by which a region's risk must speak against
/// the strategy of the whole mesh.
constexpr double kDoubt = 8;

/// Level of the calmest regions, in mean edges, up to which a mesh is clean without a trial: the normals of
/// half as much noise turn by a degree.
constexpr double kLeastFloor = 0.01;

/// The part of an estimated noise level that is surely noise, from the level measured again on what was
/// removed, where shape hardly shows: all of it where the two agree within the factor 0.6 (on the meshes of
/// docs/fair.md, 0.7 and more), nothing below 0.5. There the first was the shape of a mesh of so few
/// triangles that most of its vertices lie on edges (0.26 to 0.47 on a part of 115 vertices, clean or noisy).
double agreement_of(double estimated, double removed) {
  return std::clamp((removed / estimated - 0.5) / 0.1, 0.0, 1.0);
}

/// The part of a noise level too faint for noise_significance() that is surely noise. Noise is as large
/// everywhere and shape is not, so the level of the calmest regions must agree with what was removed, a mean
/// over the mesh: within 1.25 (up to 1.15 under noise of 0.02 to 0.05, 1.35 to 2.1 on clean scans). And what
/// the strategies would remove must be noise: both leave little of its error by Stein's estimate, or, where
/// the calmest regions are as rough as the typical ones (within 1.06; clean shapes 1.2 to 2.9), at least one
/// does.
double faint_significance(const NoiseEstimate& estimate, const AutomaticFairingReport& told) {
  if (!(estimate.floor > kLeastFloor)) return 0;
  const auto ramp = [](double value, double full, double none) {
    return std::clamp((none - value) / (none - full), 0.0, 1.0);
  };
  const auto [least, most] = std::minmax(told.risks[0], told.risks[1]);
  const double alike = ramp(estimate.level / estimate.floor, 1.06, 1.12);
  const double removable = std::max(ramp(most, 0.4, 0.6), std::min(alike, ramp(least, 0.5, 0.8)));
  return std::min(
      {removable, agreement_of(estimate.floor, told.noise), ramp(told.noise / estimate.floor, 1.25, 1.4)});
}

/// The values keep their places, which upper_median() would change.
double median_of(VectorXd values) {
  return upper_median({values.data(), static_cast<std::size_t>(values.size())});
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
void take_back_intersections(const Points& positions, const Triangles& triangles, Points& moves,
                             const Progress& progress) {
  constexpr std::size_t kMost = 100000;
  constexpr int kMostPasses = 12;
  std::size_t allowed = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const Progress part =
        progress.part("end", static_cast<double>(pass) / kMostPasses, (pass + 1.0) / kMostPasses);
    const auto pairs = self_intersections(positions + moves, triangles, kMost, part);
    if (pass == 0 && !pairs.empty()) allowed = self_intersections(positions, triangles, kMost, part).size();
    if (pairs.size() <= allowed) return;
    std::vector<char> marked(static_cast<std::size_t>(positions.rows()), 0);
    for (const auto& pair : pairs)
      for (const int f : {pair.first, pair.second})
        for (int k = 0; k < 3; ++k) marked[triangles(f, k)] = 1;
    for (Eigen::Index v = 0; v < moves.rows(); ++v)
      if (marked[v]) moves.row(v) *= 0.5;
  }
}

/// Runs of both strategies, and where which of them leaves the smaller error.
struct Trials {
  const Strategy* strategies[2] = {&kSharp, &kOrganic};
  FairingRun runs[2];
  VectorXd risk[2];      ///< Stein's, per vertex
  double deviation = 0;  ///< of the noise, measured on what the first run removed where that was asked for
};

/// Runs every strategy twice, the second time on slightly perturbed input, and estimates its error.
Trials try_strategies(Fairer& fairer, const Points& positions, const Triangles& triangles, double deviation,
                      const AutomaticFairingOptions& options, AutomaticFairingReport& told,
                      const Progress& progress) {
  // The probe of Stein's estimate: random signs along the normals, a tenth of the noise.
  const Eigen::Index n = positions.rows();
  Random random(20);
  VectorXd probe(n);
  for (Eigen::Index v = 0; v < n; ++v) probe[v] = random.uniform() < 0.5 ? -1 : 1;
  const double amplitude = 0.1 * deviation;
  const Points normals = vertex_normals(positions, triangles);
  const Points perturbed = positions + amplitude * (probe.asDiagonal() * normals);

  Trials trials;
  trials.deviation = deviation;
  for (int k = 0; k < 2; ++k) {
    const Strategy& strategy = *trials.strategies[k];
    const int iterations = options.iterations > 0 ? options.iterations : strategy.iterations;
    FairingRun& run = trials.runs[k];
    run = fairer.run(positions, trials.deviation, options.noise < 0 && k == 0, strategy, iterations,
                     progress.part("fairing", 0.5 * k, 0.5 * k + 0.25));
    if (k == 0) {
      trials.deviation = run.deviation;
      fairer.measure_tilts(positions, trials.deviation);
    }
    const FairingRun again = fairer.run(perturbed, trials.deviation, false, strategy, iterations,
                                        progress.part("fairing", 0.5 * k + 0.25, 0.5 * k + 0.5));
    const VectorXd removed =
        (run.positions - positions).cwiseProduct(normals).rowwise().sum() / trials.deviation;
    const VectorXd response =
        (again.positions - run.positions).cwiseProduct(normals).rowwise().sum() / amplitude;
    // ‖removed‖² + 2 trace(response), in the norm that counts turned normals: what is said to be better is
    // then better in the normals, also where triangles differ much in size.
    trials.risk[k] =
        removed.cwiseProduct(fairer.tilt(removed)) + 2 * fairer.tilt(probe).cwiseProduct(response);
    told.strategies.push_back(strategy.kind);
    told.risks.push_back(trials.risk[k].sum() / fairer.tilt_diagonal().sum() - 1);
    told.solves.add(run.solves);
    told.solves.add(again.solves);
  }
  return trials;
}

/// Which strategy the whole mesh takes, and per vertex the share of the other.
struct Selection {
  int winner = 0;
  VectorXd other;
};

/// A region of some hundred triangles tells the strategies apart only where they differ much; so the whole
/// mesh takes what is better at most places, but for the regions where the other is better beyond doubt.
Selection choose(const Fairer& fairer, const VectorXd (&risk)[2]) {
  VectorXd advantage = risk[0] - risk[1], regional;
  for (int pass = 0; pass < 48; ++pass) {
    advantage = fairer.fields().ring_mean(advantage);
    if (pass == 11) regional = advantage;
  }
  Selection choice;
  choice.winner = median_of(advantage) > 0 ? 1 : 0;
  const double typical = median_of(regional);
  const double doubt = kDoubt * kMadToDeviation * median_of((regional.array() - typical).abs().matrix());
  choice.other.resize(regional.size());
  for (Eigen::Index v = 0; v < regional.size(); ++v) {
    const double lead = choice.winner == 0 ? regional[v] : -regional[v];
    choice.other[v] = lead > doubt ? 1 : 0;
  }
  for (int pass = 0; pass < 3; ++pass) choice.other = fairer.fields().ring_mean(choice.other);
  return choice;
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
  progress.report("preparation", 0);
  std::vector<char> fixed =
      fairing_detail::fixed_vertices(positions, triangles, options.keep_boundary);  // checks the mesh
  AutomaticFairingReport own;
  AutomaticFairingReport& told = report != nullptr ? *report : own;
  told = {};
  progress.report("preparation", 0.05);
  const double edge = mean_edge_length(positions, triangles);
  if (!(edge > 0)) return positions;
  const bool refine = options.noise < 0;
  NoiseEstimate estimate;
  if (refine) {
    estimate = estimate_noise(positions, triangles, progress.part("preparation", 0.1, 0.3));
    told.noise = estimate.level;
    // Of noise too faint for the first rule the fit decides.
    told.significance = estimate.floor > kLeastFloor ? 1 : estimate.significance;
  } else {
    told.noise = options.noise;
    told.significance = options.noise > 0 ? 1 : 0;
  }
  if (!(told.significance > 0)) return positions;
  const bool faint = refine && estimate.significance < 1 && estimate.floor > kLeastFloor;
  const double estimated = faint ? estimate.floor : told.noise;
  progress.report("preparation", 0.3);
  Fairer fairer(positions, triangles, std::move(fixed), progress.part("preparation", 0.3, 1));
  Trials trials = try_strategies(fairer, positions, triangles, estimated * edge, options, told, progress);
  progress.report("choice", 0);
  const Selection choice = choose(fairer, trials.risk);
  told.noise = trials.deviation / edge;
  // Where even the better strategy leaves more than a fifth of the noise's own error, what was measured is
  // partly the shape of a coarse mesh.
  if (refine) {
    const double loud =
        std::min({estimate.significance, noise_significance(estimate.level, told.risks[choice.winner] - 0.2),
                  agreement_of(estimate.level, told.noise)});
    told.significance = std::max(loud, faint_significance(estimate, told));
  }
  if (!(told.significance > 0)) return positions;
  const Strategy& taken = *trials.strategies[choice.winner];
  const FairingRun &run = trials.runs[choice.winner], &other = trials.runs[1 - choice.winner];
  told.exceptions = choice.other.mean();
  told.strategy = taken.kind;
  told.iterations = options.iterations > 0 ? options.iterations : taken.iterations;
  Points moves = told.significance *
                 (run.positions - positions + choice.other.asDiagonal() * (other.positions - run.positions));
  Points unfolded = positions + moves;
  fairer.unfold(unfolded, progress.part("end", 0, 0.3));
  moves = unfolded - positions;
  progress.report("end", 0.3);
  if (fairer.is_closed()) keep_volume(positions, triangles, run.directions, moves);
  take_back_intersections(positions, triangles, moves, progress.part("end", 0.4, 1));
  told.largest_move = moves.rowwise().norm().maxCoeff();
  return positions + moves;
}

}  // namespace batten
