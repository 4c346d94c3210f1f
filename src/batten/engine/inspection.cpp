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
#include "batten/pipeline/checked_curves.hpp"
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
  CurveCheckOptions options;
  options.tolerance = tolerance;
  const CurveCheck check = check_curves(mesh, network, options, progress);
  Json list = Json::array();
  for (const CheckedCurve& curve : check.curves)
    list.push_back({{"name", curve.name},
                    {"verdict", word_of(curve.verdict)},
                    {"reasons", curve.reasons},
                    {"gap", json_of(curve.figures.max_gap)},
                    {"normal_jump", json_of(curve.figures.max_normal_jump)},
                    {"mean_normal_jump", json_of(curve.figures.mean_normal_jump)},
                    {"curvature_jump", json_of(curve.figures.max_curvature_jump)},
                    {"distance", json_of(curve.figures.max_distance)},
                    {"worst", json_of(Eigen::RowVector3d(curve.worst.transpose() - origin))}});
  draft.json["curves"] = std::move(list);
  draft.json["n_checked"] = check.n_checked;
  draft.json["n_failed"] = check.n_failed;
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
