#include "batten/strokes/stroke_network.hpp"

#include <array>

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
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
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

}  // namespace batten
