#include "batten/session/sketch_edit.hpp"

#include "../sketch/strokes.hpp"

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

TEST(SketchEdit, DragsSetTheSameThing) {
  EXPECT_TRUE(sets_the_same(SharpnessEdit{1, 0.5, {}}, SharpnessEdit{1, 0.7, {}}));
  EXPECT_FALSE(sets_the_same(SharpnessEdit{1, 0.5, {}}, SharpnessEdit{2, 0.5, {}}));
  EXPECT_FALSE(sets_the_same(SharpnessEdit{1, 0.5, std::array<int, 2>{1, 2}}, SharpnessEdit{1, 0.5, {}}));
  EXPECT_TRUE(sets_the_same(TransformEdit{}, TransformEdit{}));
  EXPECT_FALSE(sets_the_same(InsertEdit{}, InsertEdit{}));
}

}  // namespace
}  // namespace batten
