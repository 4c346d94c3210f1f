#include "commands/check.hpp"

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

namespace {

Json curve_json(const CheckedCurve& curve) {
  Json json = Json::object();
  json["name"] = curve.name;
  json["verdict"] = word_of(curve.verdict);
  json["reasons"] = curve.reasons;
  json["max_normal_jump_deg"] = degrees(curve.figures.max_normal_jump);
  json["mean_normal_jump_deg"] = degrees(curve.figures.mean_normal_jump);
  json["max_gap"] = curve.figures.max_gap;
  json["max_curvature_jump"] = curve.figures.max_curvature_jump;
  json["max_curvature_share"] = curve.max_curvature_share;
  json["max_distance"] = curve.figures.max_distance;
  json["samples"] = curve.figures.n_samples;
  json["samples_one_sided"] = curve.figures.n_one_sided;
  json["samples_not_measured"] = curve.figures.n_unfitted;
  json["worst"] = {curve.worst.x(), curve.worst.y(), curve.worst.z()};
  return json;
}

}  // namespace

CurveCheckOptions options_of(const CheckArguments& arguments) {
  CurveCheckOptions options;
  options.require = parse_choice<ContinuityClass>(arguments.continuity);
  options.tolerance = parse_angle(arguments.tolerance);
  options.gap = arguments.gap / 100;
  options.curvature = arguments.curvature / 100;
  options.distance = arguments.distance / 100;
  if (const auto wrong = options.problem()) throw InvalidInput(*wrong);
  return options;
}

Json figures_of(const CurveCheck& check) {
  Json figures = Json::object();
  figures["diameter"] = check.diameter;
  figures["passes"] = check.passes();
  figures["checked"] = check.n_checked;
  figures["failed"] = check.n_failed;
  figures["curves"] = Json::array();
  for (const CheckedCurve& curve : check.curves) figures["curves"].push_back(curve_json(curve));
  return figures;
}

}  // namespace batten::commands
