#include "batten/session/sketch_edit.hpp"

#include "../sketch/strokes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace batten {
namespace {

using namespace strokes;

TEST(SketchEdit, RunsTheToolOfItsName) {
  PolylineMesh model;
  model.begin();
  const EditReport report = run_tool(model, InsertEdit{circle(kO, kX, kY), {}});
  model.commit();
  EXPECT_EQ(report.curves, std::vector<int>{0});
  EXPECT_EQ(model.counts().curves, 1);
  model.begin();
  EXPECT_THROW(run_tool(model, DeleteEdit{5}), RefusedEdit);
  model.roll_back();
}

// Ends up to 6 % of the diameter off find the curve that they are meant for, by going on, being cut off and
// moving aside; farther ones, and any beyond a snapping distance that is given, are refused as before.
TEST(SketchEdit, EndsReachForCurves) {
  const double diameter = 2 * std::sqrt(2.0);
  for (const double off : {-0.05, -0.02, 0.02, 0.05})
    for (const double aside : {0.0, 0.02}) {
      PolylineMesh model;
      model.begin();
      run_tool(model, InsertEdit{circle(kO, kX, kY), {}});
      model.commit();
      const Eigen::Vector3d up = aside * diameter * kZ, end = (1 + off * diameter) * kX;
      const InsertEdit stroke{{polygon({-end + up, end + up}), false}, {}};
      model.begin();
      run_patiently(model, stroke);
      model.commit();
      EXPECT_EQ(model.counts().faces, 2) << off;
      for (const int e : model.edges_of_curve(1))
        for (const int v : model.edge(e).vertices) {
          EXPECT_NEAR(std::abs(model.vertex(v).position.x()), 1, 1e-3) << off;
          EXPECT_NEAR(model.vertex(v).position.norm(), 1, 1e-3) << off;
        }
    }
  PolylineMesh model;
  model.begin();
  run_tool(model, InsertEdit{circle(kO, kX, kY), {}});
  model.commit();
  for (const InsertEdit& stroke : {InsertEdit{{polygon({-0.7 * kX, 0.7 * kX}), false}, {}},
                                   InsertEdit{{polygon({-0.95 * kX, 0.95 * kX}), false}, {.snap = 0.02}}}) {
    model.begin();
    EXPECT_THROW(run_patiently(model, stroke), RefusedEdit);
    model.roll_back();
  }
}

TEST(SketchEdit, DragsSetTheSameThing) {
  EXPECT_TRUE(sets_the_same(SharpnessEdit{1, 0.5, {}}, SharpnessEdit{1, 0.7, {}}));
  EXPECT_FALSE(sets_the_same(SharpnessEdit{1, 0.5, {}}, SharpnessEdit{2, 0.5, {}}));
  EXPECT_FALSE(sets_the_same(SharpnessEdit{1, 0.5, std::array<int, 2>{1, 2}}, SharpnessEdit{1, 0.5, {}}));
  EXPECT_TRUE(sets_the_same(TransformEdit{}, TransformEdit{}));
  EXPECT_FALSE(sets_the_same(InsertEdit{}, InsertEdit{}));
}

}  // namespace
}  // namespace batten
