#include "batten/strokes/stroke_network.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/resample.hpp"

namespace batten {

namespace {

/// Weld tolerances that are tried. Drawing programs miss by 0.1 to 0.5 % of the diameter, hands by up to 1.5
/// %.
constexpr std::array<double, 5> kTolerances{0.005, 0.0075, 0.01, 0.0125, 0.015};

StrokeNetwork attempt(const CurveNetwork& strokes, const StrokeNetworkOptions& options, double tolerance,
                      const Progress& progress) {
  StrokeNetwork result;
  result.weld_tolerance = tolerance;
  StrokeCleaningOptions cleaning;
  cleaning.weld_tolerance = tolerance;
  cleaning.reach = options.reach;
  cleaning.shortest_side = 1.6 * options.step;  // below 1.5 steps a curve has no sample inside
  result.strokes = clean_strokes(strokes, cleaning);
  if (result.strokes.network.curves.empty())
    throw InvalidInput(concat("the ", result.strokes.n_strokes,
                              " strokes form no closed cycle once what ends in nothing is left out; connect "
                              "their ends, or let them reach farther"));
  const double diameter = bounding_box_diagonal(result.strokes.network.positions);
  result.network =
      options.step > 0 ? resampled(result.strokes.network, options.step * diameter) : result.strokes.network;
  result.estimate = estimate_cycles(result.network, progress);
  result.network.normals = result.estimate.normals;
  return result;
}

/// What speaks against an attempt, for each of its patches: a part more or a handle more is a place that did
/// not meet. Without the patches as measure, welding all of a dense network into one node would look best.
double blemishes(const StrokeNetwork& attempt) {
  const int count = network_topology(attempt.network).n_components - 1 + attempt.estimate.n_handles +
                    attempt.estimate.n_one_sided + attempt.strokes.n_left_out +
                    static_cast<int>(attempt.estimate.warnings.size());
  return static_cast<double>(count) / static_cast<double>(attempt.estimate.cycles.size());
}

/// The attempt at the given tolerance, or the best of several.
StrokeNetwork best_attempt(const CurveNetwork& strokes, const StrokeNetworkOptions& options,
                           const Progress& progress) {
  if (options.weld_tolerance > 0) return attempt(strokes, options, options.weld_tolerance, progress);
  std::optional<StrokeNetwork> best;
  std::optional<InvalidInput> refusal;
  for (const double tolerance : kTolerances) {
    try {
      StrokeNetwork next = attempt(strokes, options, tolerance, progress);
      if (!best || blemishes(next) < blemishes(*best)) best = std::move(next);
      if (blemishes(*best) == 0) break;
    } catch (const InvalidInput& problem) {
      if (!refusal) refusal = problem;
    }
  }
  if (!best) throw InvalidInput(*refusal);
  return std::move(*best);
}

std::vector<std::string> warnings_of(const StrokeNetwork& made) {
  std::vector<std::string> warnings = made.strokes.warnings;
  warnings.insert(warnings.end(), made.estimate.warnings.begin(), made.estimate.warnings.end());
  if (made.estimate.open_curves.empty()) return warnings;
  std::string names;
  for (const int c : made.estimate.open_curves)
    names += (names.empty() ? "" : ", ") + curve_name(made.network, c);
  warnings.push_back(
      concat("the surface was left open at ", names, ", where a patch would fold back onto its neighbours"));
  return warnings;
}

}  // namespace

std::optional<std::string> StrokeNetworkOptions::problem() const {
  if (weld_tolerance != 0) {
    StrokeCleaningOptions cleaning;
    cleaning.weld_tolerance = weld_tolerance;
    if (auto problem = cleaning.problem()) return problem;
  }
  StrokeCleaningOptions cleaning;
  cleaning.reach = reach;
  if (auto problem = cleaning.problem()) return problem;
  if (!(step >= 0) || !(step < 0.5)) return concat("step must be from 0 to 0.5 of the diameter, got ", step);
  return std::nullopt;
}

StrokeNetwork stroke_network(const CurveNetwork& strokes, const StrokeNetworkOptions& options,
                             const Progress& progress) {
  const double diameter = bounding_box_diagonal(strokes.positions);
  if (!(diameter > 0) || !std::isfinite(diameter))  // first: fractions of it mean nothing then
    throw InvalidInput("the network has no extent; all its vertices lie at one place");
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  StageTimes times;
  StrokeNetwork result;
  {
    const ScopedStage stage(times, "sketch");
    result = best_attempt(strokes, options, progress);
  }
  result.diameter = diameter;
  result.warnings = warnings_of(result);
  result.times = std::move(times);
  return result;
}

bool is_notable(const NetworkFinding& finding) {
  return finding.defect != NetworkDefect::Crossing && finding.defect != NetworkDefect::TJunction &&
         finding.defect != NetworkDefect::SeparateParts;
}

}  // namespace batten
