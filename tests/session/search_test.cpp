#include "random_edits.hpp"
#include "sanitizers.hpp"

#include <map>

#include <gtest/gtest.h>

#include "batten/core/text.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/session/project.hpp"
#include "batten/sketch/contacts_detail.hpp"

// What the model keeps for searches against searches through all of it, written once more here, after every
// one of random edits with undo, redo, and refusals that are rolled back.
namespace batten {
namespace {

using namespace strokes;
using namespace test;
using Eigen::Index;
using Eigen::Vector3d;

/// Distance of two segments: where they do not cross, an end of one is nearest to the other. Lines that are
/// not parallel come nearest on their common normal.
double distance_of_segments(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  double least = std::sqrt(std::min({closest_point_on_segment(a, c, d).squared_distance,
                                     closest_point_on_segment(b, c, d).squared_distance,
                                     closest_point_on_segment(c, a, b).squared_distance,
                                     closest_point_on_segment(d, a, b).squared_distance}));
  const Vector3d u = b - a, v = d - c, normal = u.cross(v);
  if (normal.norm() > 1e-9 * u.norm() * v.norm()) {
    const double s = (c - a).cross(v).dot(normal) / normal.squaredNorm();
    const double t = (c - a).cross(u).dot(normal) / normal.squaredNorm();
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, (a + s * u - c - t * v).norm());
  }
  return least;
}

/// The distances of all pairs of segments of a line and the edges of a model within `snap`, by edge.
std::map<int, std::vector<double>> hits_without_index(const PolylineMesh& mesh, const Polyline& line,
                                                      double snap) {
  std::map<int, std::vector<double>> hits;
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    if (!mesh.edges()[e].alive) continue;
    const Points &ours = line.points(), &theirs = mesh.edges()[e].polyline->points();
    for (Index i = 0; i + 1 < ours.rows(); ++i)
      for (Index j = 0; j + 1 < theirs.rows(); ++j) {
        const double distance =
            distance_of_segments(ours.row(i), ours.row(i + 1), theirs.row(j), theirs.row(j + 1));
        if (distance <= snap) hits[static_cast<int>(e)].push_back(distance);
      }
  }
  return hits;
}

/// @return the number of pairs compared.
size_t expect_same_hits(const PolylineMesh& mesh, const Polyline& line, double snap) {
  auto expected = hits_without_index(mesh, line, snap);
  std::map<int, std::vector<double>> found;
  size_t n = 0;
  for (const detail::Hit& hit : detail::find_hits(mesh, line, snap)) {
    found[hit.edge].push_back(hit.distance);
    ++n;
    // The arcs are those of the place that is so far away.
    EXPECT_NEAR((line.at(hit.arc) - mesh.edge(hit.edge).polyline->at(hit.edge_arc)).norm(), hit.distance,
                1e-9);
  }
  EXPECT_EQ(found.size(), expected.size());
  for (auto& [edge, distances] : expected) {
    std::vector<double>& own = found[edge];
    EXPECT_EQ(own.size(), distances.size()) << "e" << edge;
    std::sort(own.begin(), own.end());
    std::sort(distances.begin(), distances.end());
    for (size_t k = 0; k < std::min(own.size(), distances.size()); ++k)
      EXPECT_NEAR(own[k], distances[k], 1e-9) << "e" << edge;
  }
  return n;
}

void expect_same_nearest_place(const PolylineMesh& mesh, const Vector3d& point) {
  double least = std::numeric_limits<double>::infinity();
  int nearest = -1;
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    if (!mesh.edges()[e].alive) continue;
    const Points& points = mesh.edges()[e].polyline->points();
    for (Index j = 0; j + 1 < points.rows(); ++j) {
      const double distance =
          std::sqrt(closest_point_on_segment(point, points.row(j), points.row(j + 1)).squared_distance);
      if (distance >= least) continue;
      least = distance;
      nearest = static_cast<int>(e);
    }
  }
  const detail::NearestPlace place = detail::nearest_place(mesh, point);
  EXPECT_EQ(place.edge, nearest);
  EXPECT_EQ(place.distance, least);
}

Box box_without_index(const PolylineMesh& mesh, const SketchFace& face) {
  const auto points = [&](size_t k) -> const Points& {
    return mesh.edge(edge_of(face.sides[k])).polyline->points();
  };
  Box box{points(0).colwise().minCoeff(), points(0).colwise().maxCoeff()};
  for (size_t k = 1; k < face.sides.size(); ++k)
    box.include({points(k).colwise().minCoeff(), points(k).colwise().maxCoeff()});
  return box;
}

void expect_same_boxes(const PolylineMesh& mesh, const Box& box) {
  std::vector<int> edges, faces;
  std::vector<std::vector<int>> edges_of_curve(static_cast<size_t>(mesh.n_curves()));
  Box all{};
  bool any = false;
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    if (!mesh.edges()[e].alive) continue;
    const Box& own = mesh.edges()[e].polyline->box();
    if (own.meets(box)) edges.push_back(static_cast<int>(e));
    if (!any) all = own;
    all.include(own);
    any = true;
    edges_of_curve[static_cast<size_t>(mesh.edges()[e].curve)].push_back(static_cast<int>(e));
  }
  for (size_t f = 0; f < mesh.faces().size(); ++f)
    if (mesh.faces()[f].alive && box_without_index(mesh, mesh.faces()[f]).meets(box))
      faces.push_back(static_cast<int>(f));
  EXPECT_EQ(mesh.edge_boxes().meeting(box), edges);
  EXPECT_EQ(mesh.face_boxes().meeting(box), faces);
  EXPECT_EQ(mesh.empty(), !any);
  EXPECT_EQ(mesh.diameter(), any ? (all.high - all.low).norm() : 0);
  for (int c = -1; c <= mesh.n_curves(); ++c)
    EXPECT_EQ(mesh.edges_of_curve(c),
              c >= 0 && c < mesh.n_curves() ? edges_of_curve[static_cast<size_t>(c)] : std::vector<int>());
}

Box random_box(Random& random) {
  const Vector3d a = random.normal3(), b = a + random.uniform(0, 2) * random.normal3();
  return {a.cwiseMin(b), a.cwiseMax(b)};
}

TEST(Search, FindsWhatASearchThroughTheWholeModelFinds) {
  constexpr int kSessions = test::repeated(4, 1), kCalls = test::repeated(100, 50);
  size_t n_hits = 0, n_taken_back = 0;
  for (int session = 0; session < kSessions; ++session) {
    Random random(7, static_cast<std::uint64_t>(session));
    Document document = one_model();
    const PolylineMesh& mesh = model_of(document);
    for (int call = 0; call < kCalls && !HasFailure(); ++call) {
      const Edit edit = random_edit(mesh, random);
      try {
        document.apply(edit);
        if (std::holds_alternative<UndoEdit>(edit)) ++n_taken_back;
      } catch (const RefusedEdit&) {
        ++n_taken_back;
      }
      SCOPED_TRACE(concat("session ", session, " call ", call, " tool ", edit.index()));
      expect_same_boxes(mesh, random_box(random));
      const Polyline line(random_stroke(mesh, random).points);
      n_hits += expect_same_hits(mesh, line, mesh.diameter() * random.uniform(0.001, 0.03));
      if (mesh.empty()) continue;
      expect_same_nearest_place(mesh, random.normal3());
      expect_same_nearest_place(mesh, line.front());  // most often on the model
    }
    while (document.can_undo()) {
      document.apply(UndoEdit{});
      expect_same_boxes(mesh, random_box(random));
    }
    while (document.can_redo()) document.apply(RedoEdit{});
    expect_same_boxes(mesh, random_box(random));
    const ProjectFile read = parse_project(format_project(document), "stored.batten");
    expect_same_boxes(model_of(read.document), random_box(random));
    const PolylineMesh copy = mesh;  // a copy has its own
    document.apply(on_model(InsertEdit{circle(100 * kX, kX, kY), {}}));
    expect_same_boxes(copy, random_box(random));
    expect_same_hits(copy, Polyline(circle(100 * kX, kX, kY).points), 0.1);
  }
  EXPECT_GT(n_hits, 10u * kSessions * kCalls);
  EXPECT_GT(n_taken_back, kSessions * kCalls / 10u);
}

}  // namespace
}  // namespace batten
