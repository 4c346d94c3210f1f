#include <cmath>
#include <optional>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/engine/inspection_detail.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/operators/curve_continuity.hpp"
#include "batten/render/render.hpp"

namespace batten::detail {

namespace {

void add_shown(Draft& draft, const TriangleMesh& mesh, const Subject& subject, Shading shading) {
  RenderOptions options;
  options.shading = shading;
  const std::optional<ShownValues> shown = shown_values(subject, options);
  if (!shown)
    throw InvalidInput(concat("the shading '", word_of(shading),
                              "' has no values per vertex; the page draws it by "
                              "itself"));
  draft.add_values("values", split_at_creases(mesh).spread(shown->values));
  draft.json["low"] = json_of(shown->low);
  draft.json["high"] = json_of(shown->high);
  draft.json["title"] = shown->title;
}

}  // namespace

void add_values(Draft& draft, const TriangleMesh& mesh, const std::string& shading) {
  Subject subject;
  subject.mesh = &mesh;
  add_shown(draft, mesh, subject, parse_choice<Shading>(shading));
}

void add_continuity(Draft& draft, const TriangleMesh& mesh, const CurveNetwork& network, double tolerance,
                    const Eigen::RowVector3d& origin, const Progress& progress) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput(concat("the tolerance must be an angle above 0, got ", tolerance));
  std::vector<Points> curves;
  for (const NetworkCurve& curve : network.curves) {
    Points points(static_cast<Eigen::Index>(curve.vertices.size()), 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      points.row(i) = network.positions.row(curve.vertices[at(i)]);
    curves.push_back(std::move(points));
  }
  const std::vector<std::vector<ContinuitySample>> samples =
      curve_continuity(mesh.positions, mesh.triangles, curves, {}, progress);
  Json list = Json::array();
  int n_failed = 0, n_checked = 0;
  for (std::size_t c = 0; c < samples.size(); ++c) {
    const CurveContinuity figures = continuity_figures(samples[c]);
    const NetworkCurve& curve = network.curves[c];
    const bool is_checked = figures.n_samples > 0 && !curve.sharp && !curve.boundary;
    const bool passes = figures.max_normal_jump <= tolerance;
    n_checked += is_checked ? 1 : 0;
    n_failed += is_checked && !passes ? 1 : 0;
    list.push_back({{"name", curve_name(network, static_cast<int>(c))},
                    {"verdict", !is_checked ? (figures.n_samples == 0 ? "border" : "sharp")
                                : passes    ? "pass"
                                            : "fail"},
                    {"gap", json_of(figures.max_gap)},
                    {"normal_jump", json_of(figures.max_normal_jump)},
                    {"mean_normal_jump", json_of(figures.mean_normal_jump)},
                    {"curvature_jump", json_of(figures.max_curvature_jump)},
                    {"distance", json_of(figures.max_distance)},
                    {"worst", json_of(Eigen::RowVector3d(figures.worst.transpose() - origin))}});
  }
  draft.json["curves"] = std::move(list);
  draft.json["n_checked"] = n_checked;
  draft.json["n_failed"] = n_failed;
}

void add_distances(Draft& draft, const TriangleMesh& mesh, const TriangleMesh& truth,
                   const Progress& progress) {
  const ShapeTree tree(Shape{truth.positions, truth.triangles, {}});
  const std::vector<ClosestPoint> closest = tree.closest(mesh.positions, progress);
  Subject subject;
  subject.mesh = &mesh;
  subject.errors.resize(mesh.n_vertices());
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    subject.errors[v] = std::sqrt(closest[at(v)].squared_distance);
  add_shown(draft, mesh, subject, Shading::Error);
  draft.json["mean"] = json_of(subject.errors.mean());
  draft.json["rms"] =
      json_of(std::sqrt(subject.errors.squaredNorm() / static_cast<double>(mesh.n_vertices())));
  draft.json["max"] = json_of(subject.errors.maxCoeff());
}

}  // namespace batten::detail
