#include "commands/surface.hpp"

#include "commands/words.hpp"

#include <cmath>
#include <utility>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/pipeline/shape_comparison.hpp"
#include "batten/strokes/mended_network.hpp"

namespace batten::commands {

namespace {

Json finding_json(const NetworkFinding& finding) {
  Json entry = {{"defect", defect_name(finding.defect)}, {"sentence", finding.sentence}};
  if (finding.curve >= 0) entry["stroke"] = finding.curve;
  if (finding.other_curve >= 0) entry["other_stroke"] = finding.other_curve;
  entry["position"] = {finding.position.x(), finding.position.y(), finding.position.z()};
  entry["distance"] = finding.distance;
  return entry;
}

}  // namespace

int parse_rebuilds(const std::string& text) {
  long value = 0;
  if (text == "auto") return -1;
  if (!parse_integer(text, value) || value < 0 || value > 20)
    throw InvalidInput("--rebuilds takes auto or 0 to 20, got " + text);
  return static_cast<int>(value);
}

NetworkSurfaceOptions options_of(const SurfaceArguments& arguments) {
  NetworkSurfaceOptions options;
  options.surface.rebuilds = parse_rebuilds(arguments.rebuilds);
  options.surface.method = parse_choice<SurfaceMethod>(arguments.method);
  options.surface.map = parse_choice<PatchMap>(arguments.map);
  options.surface.soft_constraints = is_first_word(arguments.constraints, "--constraints", "soft", "hard");
  options.surface.soft_weight = arguments.soft_weight;
  options.surface.base_order = arguments.base_order;
  options.surface.max_triangles = arguments.max_triangles;
  if (arguments.edge_length != "auto") options.edge_length = parse_length(arguments.edge_length);
  options.flatten_crossings = is_first_word(arguments.crossings, "--crossings", "flatten", "keep");
  return options;
}

StrokeNetworkOptions options_of(const StrokeArguments& arguments, double diameter) {
  const auto fraction = [&](const std::string& text, const char* none) {
    return text == none ? 0 : parse_length(text).in_file_units(diameter) / diameter;
  };
  StrokeNetworkOptions options;
  options.weld_tolerance = fraction(arguments.weld, "auto");
  options.reach = fraction(arguments.reach, "none");
  options.step = fraction(arguments.step, "none");
  parse_choice<StrokeTopology>(arguments.topology);
  parse_choice<StrokeClosure>(arguments.closed);
  parse_choice<StrokeSymmetry>(arguments.symmetry);
  return options;
}

CurveNetwork mended(const StrokeArguments& arguments, const CurveNetwork& curves, Json& figures,
                    std::vector<std::string>& warnings) {
  const double diameter = bounding_box_diagonal(curves.positions);
  NetworkMendingOptions options;
  options.weld_tolerance = options_of(arguments, diameter).weld_tolerance;
  if (arguments.weld != "auto" && options.weld_tolerance == 0) return curves;
  MendedNetwork made = mended_network(curves, options);
  figures["welded_vertices"] = made.weld.n_merged_vertices + made.weld.n_inserted_nodes;
  figures["overdrawn"] = made.n_doubled;
  figures["left_out"] = made.n_left_out;
  figures["weld_tolerance"] = made.weld_tolerance * diameter;
  warnings.insert(warnings.end(), made.warnings.begin(), made.warnings.end());
  return std::move(made.network);
}

StrokeSurfaceOptions options_of(const StrokeArguments& arguments, const NetworkSurfaceOptions& surface,
                                double diameter) {
  if (!(diameter > 0) || !std::isfinite(diameter))
    throw InvalidInput("the sketch has no extent, or a coordinate that is not a number");
  StrokeSurfaceOptions options;
  options.topology = parse_choice<StrokeTopology>(arguments.topology);
  options.closed = parse_choice<StrokeClosure>(arguments.closed);
  options.symmetry = parse_choice<StrokeSymmetry>(arguments.symmetry);
  options.strokes = options_of(arguments, diameter);
  options.surface = surface;
  if (arguments.weld != "auto" && options.strokes.weld_tolerance == 0)
    throw InvalidInput(
        "--weld 0 takes networks with normals as they are; strokes without normals must be welded");
  return options;
}

Json figures_of(const StrokeSurface& made) {
  Json figures = Json::object();
  figures["topology"] = word_of(made.implicit ? StrokeTopology::Implicit : StrokeTopology::Cycles);
  figures["cycles_area"] = made.implicit ? 0 : 1;
  if (!made.doubt.empty()) figures["doubt"] = made.doubt;
  if (made.mirror)
    figures["mirror"] = {{"axis", std::string(1, "xyz"[made.mirror->axis])},
                         {"position", made.mirror->position}};
  if (made.implicit) {
    Json unsure = Json::array();
    for (const UnsurePlace& place : made.implicit->unsure)
      unsure.push_back({{"position", {place.position.x(), place.position.y(), place.position.z()}},
                        {"area", place.area},
                        {"distance", place.distance}});
    figures["unsure"] = unsure;
    figures["sites"] = made.implicit->field.n_sites;
    figures["smoothing"] = made.implicit->field.smoothing;
    figures["stroke_distance_p95"] = made.implicit->stroke_distance_p95;
    figures["stroke_distance_max"] = made.implicit->stroke_distance_max;
  }
  return figures;
}

std::string warning_of(const StrokeSurface& made) {
  if (!made.implicit || made.doubt.empty()) return {};
  return concat(
      "the strokes do not part the surface into patches that are sure (", made.doubt,
      "); it is the smoothest closed surface through all of them, without patches; --topology cycles "
      "shows the patches");
}

Json figures_of(const StrokeNetwork& made) {
  const CleanedStrokes& strokes = made.strokes;
  Json figures = Json::object();
  figures["strokes"] = strokes.n_strokes;
  figures["dangling_ends"] = count_findings(strokes.findings, NetworkDefect::DanglingEnd);
  figures["near_misses"] = count_findings(strokes.findings, NetworkDefect::NearMiss);
  figures["open_crossings"] = count_findings(strokes.findings, NetworkDefect::Crossing) +
                              count_findings(strokes.findings, NetworkDefect::TJunction);
  figures["overdrawn"] = strokes.n_overdrawn;
  figures["extended_ends"] = strokes.n_extended_ends;
  figures["left_out"] = strokes.n_left_out;
  figures["weld_tolerance"] = made.weld_tolerance * made.diameter;
  figures["doubtful_places"] = made.estimate.warnings.size();
  return figures;
}

Json diagnosis_json(const StrokeNetwork& made) {
  Json diagnosis = Json::array();
  for (const NetworkFinding& finding : made.strokes.findings)
    if (is_notable(finding)) diagnosis.push_back(finding_json(finding));
  return diagnosis;
}

NetworkUncertainty carried_uncertainty(const Eigen::VectorXd& deviations, const CurveNetwork& read,
                                       const CurveNetwork& mended) {
  if (deviations.size() == 0) return {Eigen::VectorXd::Zero(mended.positions.rows()), {}};
  if (mended.positions.rows() == read.positions.rows()) return {deviations, {}};
  const Segments segments = shape_of(read).segments;
  const std::vector<ClosestPoint> closest = SegmentTree(read.positions, segments).closest(mended.positions);
  Eigen::VectorXd carried(mended.positions.rows());
  for (Eigen::Index v = 0; v < carried.size(); ++v) {
    const ClosestPoint& at = closest[static_cast<std::size_t>(v)];
    carried[v] = at.weights[0] * deviations[segments(at.element, 0)] +
                 at.weights[1] * deviations[segments(at.element, 1)];
  }
  return {carried, {}};
}

Json figures_of(const SurfaceArguments& arguments, const NetworkSurface& surface) {
  const MeshTopology& topology = surface.topology;
  const MeshQuality& quality = surface.quality;
  const auto genus = topology.genus();
  Json figures = Json::object();
  figures["curves"] = surface.n_curves;
  figures["nodes"] = surface.n_nodes;
  figures["segments"] = surface.n_segments;
  figures["cycles"] = surface.n_cycles;
  figures["components"] = topology.n_components;
  figures["boundary_loops"] = topology.n_boundary_loops;
  figures["vertices"] = topology.n_vertices;
  figures["faces"] = topology.n_triangles;
  figures["genus"] = genus ? Json(*genus) : Json(nullptr);
  figures["euler_characteristic"] = topology.euler_characteristic;
  figures["watertight"] = topology.is_watertight();
  figures["diameter"] = surface.diameter;
  figures["method"] = arguments.method;
  figures["rebuilds"] = surface.rebuilds;
  figures["last_move"] = surface.last_move;
  figures["patches_in_space"] = surface.patches_in_space;
  if (surface.flattening) figures["flattened_patches"] = surface.flattening->patches.size();
  figures["folded_faces"] = surface.folded_triangles;
  figures["degenerate_faces"] = surface.degenerate_triangles;
  figures["self_intersections"] = surface.crossing_pairs;
  figures["min_angle_deg"] = degrees(quality.min_angle);
  figures["mean_edge"] = quality.mean_edge;
  figures["flaws"] = surface.flaws;
  return figures;
}

}  // namespace batten::commands
