#include "modelling/sharp_cube.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/modelling/edge_courses_detail.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

// The sides of a square lie in its plane, also where two of them meet.
TEST(NormalOfCurvesAt, IsTheNormalOfThePlaneOfTheCurves) {
  PolylineMesh mesh;
  strokes::edit(mesh, [&](PolylineMesh& m) {
    using namespace strokes;
    return insert_curve(m, {polygon({kO, kX, kX + kY, kY, kO}), true}, {.snap = 1e-3});
  });
  int corners = 0;
  for (std::size_t v = 0; v < mesh.vertices().size(); ++v) {
    if (!mesh.vertices()[v].alive || mesh.vertices()[v].edges.size() < 2) continue;
    EXPECT_NEAR(std::abs(detail::normal_of_curves_at(mesh, static_cast<int>(v)).z()), 1, 1e-9) << v;
    ++corners;
  }
  EXPECT_EQ(corners, 4);
}

// A tie between two places of a sphere with great circles through them leaves them along the sphere: a cubic
// with the length of the chord, √2, as speed at both ends.
TEST(CourseOfEdge, TiesLeaveInThePlanesOfTheCurves) {
  const PolylineMesh mesh = strokes::ellipsoid(1, 1, 1);
  int e = -1;
  for (std::size_t k = 0; k < mesh.edges().size() && e < 0; ++k)
    if (mesh.edges()[k].alive) e = static_cast<int>(k);
  SketchEdge edge = mesh.edge(e);
  const Points drawn = detail::course_of_edge(mesh, edge, 8);
  ASSERT_EQ(drawn.rows(), 9);
  for (Eigen::Index i = 0; i < 9; ++i) EXPECT_NEAR(drawn.row(i).norm(), 1, 1e-3) << "the drawn circle itself";
  edge.drawn = false;
  const Points tie = detail::course_of_edge(mesh, edge, 8);
  EXPECT_EQ(tie.row(0), drawn.row(0));
  EXPECT_EQ(tie.row(8), drawn.row(8));
  // Tangents of length √2 at both ends add (√2 + √2)/8 along each, at 45° to the chord: 0.25 outwards.
  EXPECT_NEAR(tie.row(4).norm(), std::sqrt(0.5) + 0.25, 1e-3);
}

}  // namespace
}  // namespace batten
