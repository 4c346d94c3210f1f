#include <algorithm>
#include <set>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/engine/tried_edit_detail.hpp"
#include "batten/sketch/stroke.hpp"

namespace batten::detail {

void add_tried(Draft& draft, const PolylineMesh& model, const SketchEdit& edit) {
  PolylineMesh tried = model;
  tried.begin();
  EditReport report;
  try {
    report = run_patiently(tried, edit);
  } catch (const RefusedEdit& refused) {
    draft.json["accepted"] = false;
    draft.json["reason"] = refused.reason();
    draft.json["remedy"] = refused.remedy();
    return;
  }
  tried.commit();
  const auto is_new = [&](int curve) {
    return std::find(report.curves.begin(), report.curves.end(), curve) != report.curves.end();
  };
  std::vector<Eigen::RowVector3d> points;
  std::set<int> vertices;
  Json pieces = Json::array();
  for (const SketchEdge& edge : tried.edges()) {
    if (!edge.alive || !edge.drawn || !is_new(edge.curve)) continue;
    const Points& line = edge.polyline->points();
    pieces.push_back({{"first", points.size()}, {"n", line.rows()}});
    for (Eigen::Index i = 0; i < line.rows(); ++i) points.emplace_back(line.row(i));
    vertices.insert(edge.vertices.begin(), edge.vertices.end());
  }
  Points positions(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) positions.row(static_cast<Eigen::Index>(i)) = points[i];
  const Eigen::RowVector3d origin = middle_of(positions);
  Json meets = Json::array();
  for (const int v : vertices)
    for (const int e : tried.vertex(v).edges) {
      const SketchEdge& edge = tried.edge(e);
      if (!edge.drawn || is_new(edge.curve)) continue;
      meets.push_back({{"at", json_of(Eigen::RowVector3d(tried.vertex(v).position.transpose() - origin))},
                       {"curve", concat("c", edge.curve)}});
      break;
    }
  draft.json["accepted"] = true;
  draft.json["origin"] = json_of(origin);
  draft.json["pieces"] = std::move(pieces);
  draft.json["meets"] = std::move(meets);
  draft.json["faces"] = tried.counts().faces - model.counts().faces;
  draft.json["remarks"] = report.remarks;
  draft.add_points("positions", positions, origin);
}

}  // namespace batten::detail
