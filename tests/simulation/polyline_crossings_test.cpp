#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "batten/simulation/polyline_crossings_detail.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten::detail {
namespace {

using Planes = std::vector<std::pair<int, double>>;

std::vector<MeshPolyline> lines_on(const TriangleMesh& mesh, const Planes& planes) {
  const MeshEdgeFaces faces(mesh);
  std::vector<MeshPolyline> lines = border_polylines(mesh, mesh.normals, faces);
  for (const auto& [axis, offset] : planes)
    for (MeshPolyline& section : plane_sections(mesh, mesh.normals, faces, axis, offset))
      lines.push_back(std::move(section));
  return lines;
}

Eigen::Vector3d point_at(const MeshPolyline& line, const CrossingPlace& place) {
  return (1 - place.fraction) * line.points[place.piece] + place.fraction * line.next(place.piece);
}

// Two planes across different axes and a convex surface meet in two points; parallel ones do not.
TEST(PolylineCrossings, AreTwoForEveryPairOfPlanesThroughABall) {
  const std::vector<MeshPolyline> lines =
      lines_on(shape_mesh(AnalyticShape::Ellipsoid, 0.02), {{0, 0.31}, {0, -0.42}, {1, 0.13}, {2, 0.07}});
  const PolylineCrossings found = find_crossings(lines);
  EXPECT_EQ(found.crossings.size(), 2U * 5);
  std::vector<int> n_places(found.crossings.size(), 0);
  for (size_t c = 0; c < lines.size(); ++c)
    for (const CrossingPlace& place : found.places[c]) {
      const MeshCrossing& crossing = found.crossings[static_cast<size_t>(place.node)];
      EXPECT_LT((point_at(lines[c], place) - crossing.position).norm(), 1e-12);
      EXPECT_NEAR(crossing.position[lines[c].axis], lines[c].offset, 1e-12);
      EXPECT_NEAR(crossing.normal.norm(), 1, 1e-12);
      ++n_places[static_cast<size_t>(place.node)];
    }
  for (const int n : n_places) EXPECT_EQ(n, 2);
}

TEST(PolylineCrossings, OpenSectionsMeetTheBorderAtBothEnds) {
  const std::vector<MeshPolyline> lines = lines_on(shape_mesh(AnalyticShape::Saddle, 0.03), {{0, 0.31}});
  ASSERT_EQ(lines.size(), 2U);
  const PolylineCrossings found = find_crossings(lines);
  ASSERT_EQ(found.crossings.size(), 2U);
  for (const CrossingPlace& place : found.places[0])
    EXPECT_LT((point_at(lines[0], place) - found.crossings[static_cast<size_t>(place.node)].position).norm(),
              1e-12);
  ASSERT_EQ(found.places[1].size(), 2U);
  EXPECT_EQ(found.places[1].front().piece, 0U);
  EXPECT_EQ(found.places[1].front().fraction, 0);
  EXPECT_EQ(found.places[1].back().piece, lines[1].n_pieces() - 1);
  EXPECT_EQ(found.places[1].back().fraction, 1);
}

// Without a section across, the two ends of a tube have nothing in common: the longer one is kept.
TEST(PolylineCrossings, TheLongestConnectedPartIsKept) {
  const TriangleMesh cone = shape_mesh(AnalyticShape::Cone, 0.03);
  std::vector<MeshPolyline> apart = lines_on(cone, {{2, 0.8}});
  ASSERT_EQ(apart.size(), 3U);
  std::vector<std::string> warnings;
  keep_connected(apart, warnings);
  ASSERT_EQ(apart.size(), 1U);
  EXPECT_TRUE(apart[0].boundary);
  EXPECT_NEAR(apart[0].points[0].z(), 0.1, 1e-9);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("2 of 3 curves (1 of them borders)"), std::string::npos) << warnings[0];

  std::vector<MeshPolyline> joined = lines_on(cone, {{2, 0.8}, {0, 0.01}});
  const size_t n = joined.size();
  keep_connected(joined, warnings);
  EXPECT_EQ(joined.size(), n);
  EXPECT_EQ(warnings.size(), 1U);
}

}  // namespace
}  // namespace batten::detail
