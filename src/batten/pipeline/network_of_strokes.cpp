#include "batten/pipeline/network_of_strokes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/strokes/stroke_network.hpp"

namespace batten {

namespace {

/// A length as a fraction of the diameter.
double fraction(const Length& length, double diameter) {
  return length.in_file_units(diameter) / diameter;
}

int count(const std::vector<NetworkFinding>& findings, NetworkDefect defect) {
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [&](const NetworkFinding& f) { return f.defect == defect; }));
}

void add_warnings(const StrokeNetwork& made, std::vector<std::string>& warnings) {
  warnings.insert(warnings.end(), made.strokes.warnings.begin(), made.strokes.warnings.end());
  warnings.insert(warnings.end(), made.estimate.warnings.begin(), made.estimate.warnings.end());
  if (made.estimate.open_curves.empty()) return;
  std::string names;
  for (const int c : made.estimate.open_curves)
    names += (names.empty() ? "" : ", ") + curve_name(made.network, c);
  warnings.push_back(
      concat("the surface was left open at ", names, ", where a patch would fold back onto its neighbours"));
}

}  // namespace

std::optional<std::string> NetworkOfStrokesOptions::problem() const {
  if (weld && !(weld->value > 0)) return concat("weld must be positive, got ", weld->value);
  if (!(reach.value >= 0)) return concat("reach must be at least 0, got ", reach.value);
  if (!(step.value >= 0)) return concat("step must be at least 0, got ", step.value);
  return std::nullopt;
}

NetworkOfStrokes network_of_strokes(const CurveNetwork& strokes, const NetworkOfStrokesOptions& options,
                                    const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const double diameter = bounding_box_diagonal(strokes.positions);
  if (!(diameter > 0) || !std::isfinite(diameter))
    throw InvalidInput("the network has no extent; all its vertices lie at one place");
  StrokeNetworkOptions fractions;
  fractions.weld_tolerance = options.weld ? fraction(*options.weld, diameter) : 0;
  fractions.reach = fraction(options.reach, diameter);
  fractions.step = fraction(options.step, diameter);
  NetworkOfStrokes result;
  StrokeNetwork made;
  {
    const ScopedStage stage(result.times, "sketch");
    made = stroke_network(strokes, fractions, progress);
  }
  const CleanedStrokes& cleaned = made.strokes;
  result.n_strokes = cleaned.n_strokes;
  result.n_dangling_ends = count(cleaned.findings, NetworkDefect::DanglingEnd);
  result.n_near_misses = count(cleaned.findings, NetworkDefect::NearMiss);
  result.n_open_crossings =
      count(cleaned.findings, NetworkDefect::Crossing) + count(cleaned.findings, NetworkDefect::TJunction);
  result.n_overdrawn = cleaned.n_overdrawn;
  result.n_extended_ends = cleaned.n_extended_ends;
  result.n_left_out = cleaned.n_left_out;
  result.weld_tolerance = made.weld_tolerance * diameter;
  result.diameter = diameter;
  result.n_doubtful_places = static_cast<int>(made.estimate.warnings.size());
  result.n_handles = made.estimate.n_handles;
  add_warnings(made, result.warnings);
  result.findings = std::move(made.strokes.findings);
  result.network = std::move(made.network);
  result.cycles = std::move(made.estimate.cycles);
  return result;
}

bool is_notable(const NetworkFinding& finding) {
  return finding.defect != NetworkDefect::Crossing && finding.defect != NetworkDefect::TJunction &&
         finding.defect != NetworkDefect::SeparateParts;
}

}  // namespace batten
