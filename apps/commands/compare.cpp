#include "commands/compare.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/units.hpp"

namespace batten::commands {

namespace {

Json distance_json(const DistanceFigures& figures, double divisor) {
  Json json = Json::object();
  json["max"] = figures.max / divisor;
  json["mean"] = figures.mean / divisor;
  json["rms"] = figures.rms / divisor;
  return json;
}

/// The figures to quote first, then those they come from.
Json directed_json(const DirectedComparison& side, double divisor) {
  Json json = distance_json(side.samples, divisor);
  json["max"] = std::max(side.vertices.max, side.samples.max) / divisor;
  json["vertices"] = distance_json(side.vertices, divisor);
  json["samples"] = distance_json(side.samples, divisor);
  return json;
}

/// Null where one of the shapes is a network.
Json normals_json(const DistanceFigures& angles) {
  if (angles.count == 0) return nullptr;
  return {
      {"max_deg", degrees(angles.max)}, {"mean_deg", degrees(angles.mean)}, {"rms_deg", degrees(angles.rms)}};
}

/// Null where one of the shapes is no oriented manifold.
Json variation_json(const std::optional<MeshVariation>& variation) {
  if (!variation) return nullptr;
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"mean_curvature", known(variation->mean_curvature)},
          {"edge_variance", known(variation->edge_variance)},
          {"area_variance", known(variation->area_variance)},
          {"curvature_variance", known(variation->curvature_variance)}};
}

Json registration_json(const std::string& kind, const Registration& registration) {
  const SimilarityTransform& transform = registration.transform;
  Json json = Json::object();
  json["kind"] = kind;
  json["scale"] = transform.scale;
  json["rotation"] = Json::array();
  for (int i = 0; i < 3; ++i)
    json["rotation"].push_back(
        {transform.rotation(i, 0), transform.rotation(i, 1), transform.rotation(i, 2)});
  json["translation"] = {transform.translation.x(), transform.translation.y(), transform.translation.z()};
  json["angle_deg"] = degrees(transform.angle());
  json["rms"] = registration.rms;
  json["iterations"] = registration.iterations;
  json["converged"] = registration.converged;
  return json;
}

}  // namespace

CompareOptions options_of(const CompareArguments& arguments) {
  CompareOptions options;
  options.seed = arguments.seed;
  options.samples = arguments.samples;
  options.registration = parse_choice<RegistrationKind>(arguments.registration);
  return options;
}

Json figures_of(const CompareArguments& arguments, const ShapeComparison& compared) {
  const Comparison& found = compared.distances;
  Json figures = Json::object();
  figures["diameter"] = found.diameter;
  figures["registration"] = registration_json(arguments.registration, found.registration);
  figures["a_to_b"] = directed_json(found.a_to_b, 1);
  figures["b_to_a"] = directed_json(found.b_to_a, 1);
  figures["relative"] = {{"a_to_b", directed_json(found.a_to_b, found.diameter)},
                         {"b_to_a", directed_json(found.b_to_a, found.diameter)}};
  figures["hausdorff"] = compared.hausdorff;
  figures["normals"] = {{"a_to_b", normals_json(found.a_to_b.normal_angles)},
                        {"b_to_a", normals_json(found.b_to_a.normal_angles)}};
  figures["variation"] = variation_json(compared.variation);
  figures["samples"] = arguments.samples;
  return figures;
}

Json figures_of(const TruthErrors& errors) {
  return {{"max", errors.figures.max}, {"mean", errors.figures.mean}, {"rms", errors.figures.rms}};
}

}  // namespace batten::commands
