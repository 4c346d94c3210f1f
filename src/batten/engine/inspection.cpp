#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/engine/inspection_detail.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/plane_section.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/operators/shape_operator.hpp"
#include "batten/pipeline/checked_curves.hpp"
#include "batten/render/porcupine.hpp"
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

void add_combs(Draft& draft, const CurveNetwork& network, const Eigen::RowVector3d& origin) {
  const std::vector<Quills> all = porcupine(network);
  Eigen::Index n = 0;
  for (const Quills& quills : all) n += quills.roots.rows();
  Points roots(n, 3), directions(n, 3);
  Eigen::VectorXd curvature(n);
  Json list = Json::array();
  Eigen::Index first = 0;
  for (const Quills& quills : all) {
    const Eigen::Index rows = quills.roots.rows();
    roots.middleRows(first, rows) = quills.roots;
    directions.middleRows(first, rows) = quills.directions;
    curvature.segment(first, rows) = quills.curvature;
    list.push_back({{"name", curve_name(network, quills.curve)},
                    {"first", first},
                    {"n", rows},
                    {"largest", rows > 0 ? json_of(quills.curvature.cwiseAbs().maxCoeff()) : Json()}});
    first += rows;
  }
  draft.json["combs"] = std::move(list);
  draft.add_points("roots", roots, origin);
  draft.add_points("directions", directions, Eigen::RowVector3d::Zero());
  draft.add_values("curvature", curvature);
}

void add_directions(Draft& draft, const TriangleMesh& mesh, Eigen::Index most,
                    const Eigen::RowVector3d& origin) {
  if (most < 1) throw InvalidInput(concat("'most' must be at least 1, got ", most));
  const FaceCurvatures found =
      face_curvatures(mesh.positions, mesh.triangles, vertex_normals(mesh.positions, mesh.triangles));
  const Eigen::Index step = std::max<Eigen::Index>(1, (mesh.n_triangles() + most - 1) / most);
  const Eigen::Index n = (mesh.n_triangles() + step - 1) / step;
  Points places(n, 3), first(n, 3), second(n, 3);
  Eigen::VectorXd curvatures(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index f = i * step;
    places.row(i) = (mesh.positions.row(mesh.triangles(f, 0)) + mesh.positions.row(mesh.triangles(f, 1)) +
                     mesh.positions.row(mesh.triangles(f, 2))) /
                    3;
    first.row(i) = found.first_direction.row(f);
    second.row(i) = found.second_direction.row(f);
    curvatures.segment(2 * i, 2) << found.first[f], found.second[f];
  }
  draft.add_points("places", places, origin);
  draft.add_points("first", first, Eigen::RowVector3d::Zero());
  draft.add_points("second", second, Eigen::RowVector3d::Zero());
  draft.add_values("curvatures", curvatures);
}

CurveNetwork add_section(Draft& draft, const TriangleMesh& mesh, const Eigen::Vector3d& normal, double offset,
                         const Eigen::RowVector3d& origin) {
  const std::vector<SectionCurve> found = plane_section(mesh.positions, mesh.triangles, normal, offset);
  CurveNetwork network;
  Eigen::Index n = 0;
  for (const SectionCurve& curve : found) n += curve.points.rows();
  network.positions.resize(n, 3);
  Json list = Json::array();
  double length = 0, area = 0;
  int first = 0;
  for (const SectionCurve& curve : found) {
    const auto rows = static_cast<int>(curve.points.rows());
    network.positions.middleRows(first, rows) = curve.points;
    NetworkCurve& made = network.curves.emplace_back();
    made.boundary = true;
    for (int i = 0; i < rows; ++i) made.vertices.push_back(first + i);
    if (curve.closed) made.vertices.push_back(first);
    list.push_back({{"first", first},
                    {"n", rows},
                    {"closed", curve.closed},
                    {"length", json_of(curve.length)},
                    {"area", curve.closed ? json_of(curve.area) : Json()}});
    length += curve.length;
    area += curve.area;
    first += rows;
  }
  draft.json["curves"] = std::move(list);
  draft.json["length"] = json_of(length);
  draft.json["area"] = json_of(area);
  draft.add_points("positions", network.positions, origin);
  return network;
}

}  // namespace batten::detail
