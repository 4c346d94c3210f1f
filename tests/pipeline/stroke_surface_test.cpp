#include "batten/pipeline/stroke_surface.hpp"

#include "implicit/strokes.hpp"
#include "sanitizers.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

StrokeSurfaceOptions coarse(StrokeTopology topology = StrokeTopology::Auto) {
  StrokeSurfaceOptions options;
  options.topology = topology;
  options.strokes.step = 0.04;
  options.field.most_sites = test::repeated(200, 80);
  options.surface.edge_length = Length{0.04, Length::Kind::Relative};
  return options;
}

/// Three whole circles of a sphere, which meet.
CurveNetwork whole_circles() {
  return test::sphere_strokes(1, 0, 0);
}

TEST(StrokeSurface, KeepsCyclesThatAreSure) {
  const StrokeSurface made = stroke_surface(whole_circles(), coarse());
  EXPECT_FALSE(made.implicit);
  EXPECT_EQ(made.doubt, "");
  EXPECT_EQ(made.surface.n_cycles, 8);
  // What it gives when told to, bit for bit.
  const StrokeSurface told = stroke_surface(whole_circles(), coarse(StrokeTopology::Cycles));
  EXPECT_EQ(made.surface.mesh.positions, told.surface.mesh.positions);
}

TEST(StrokeSurface, ClosesWhatCyclesCannot) {
  bool was_told = false;
  const StrokeSurface made =
      stroke_surface(test::sphere_strokes(), coarse(), {}, [&](const StrokeNetwork&) { was_told = true; });
  ASSERT_TRUE(made.implicit);
  EXPECT_FALSE(made.doubt.empty());
  EXPECT_TRUE(made.surface.is_sound());
  EXPECT_TRUE(made.surface.topology.is_watertight());
  EXPECT_EQ(was_told, made.strokes.has_value());
}

TEST(StrokeSurface, IsClosedWhereItMustBe) {
  // The upper half of a sphere: a rim and two arcs over it.
  CurveNetwork dome;
  test::add_stroke(dome, 80, [](double t) {
    return Eigen::Vector3d(std::cos(test::kTurn * t), std::sin(test::kTurn * t), 0);
  });
  for (const bool x : {true, false})
    test::add_stroke(dome, 40, [&](double t) {
      const double a = test::kTurn / 2 * t;
      return Eigen::Vector3d(x ? std::cos(a) : 0, x ? 0 : std::cos(a), std::sin(a));
    });
  StrokeSurfaceOptions options = coarse();
  options.closed = StrokeClosure::Yes;
  const StrokeSurface closed = stroke_surface(dome, options);
  EXPECT_TRUE(closed.surface.topology.is_watertight());
  options.closed = StrokeClosure::No;
  EXPECT_FALSE(stroke_surface(dome, options).implicit);
}

// The arcs of a sphere with x > 0 alone, completed in the mirror x = 0.
TEST(StrokeSurface, IsCompletedFromHalfASketch) {
  const CurveNetwork whole = test::sphere_strokes(6, 0.1, 0);
  CurveNetwork half = whole;
  half.curves.clear();
  for (const NetworkCurve& curve : whole.curves)
    if (whole.positions(curve.vertices[20], 0) > -1e-3) half.curves.push_back(curve);
  ASSERT_LT(half.curves.size(), whole.curves.size());
  StrokeSurfaceOptions options = coarse(StrokeTopology::Implicit);
  options.symmetry = StrokeSymmetry::X;
  const StrokeSurface made = stroke_surface(half, options);
  ASSERT_TRUE(made.mirror);
  EXPECT_EQ(made.mirror->axis, 0);
  EXPECT_EQ(made.mirror->position, 0);
  EXPECT_TRUE(made.surface.topology.is_watertight());
  EXPECT_NEAR(made.surface.mesh.positions.col(0).minCoeff(), -1, 0.08);
  options.symmetry = StrokeSymmetry::Off;
  EXPECT_FALSE(stroke_surface(whole, options).mirror);
  options.symmetry = StrokeSymmetry::Auto;
  EXPECT_TRUE(stroke_surface(test::sphere_strokes(4, 0.1, 0), options).mirror);
}

// Circles that meet, inside them strokes that all pass through one point, and a field of too few places to
// follow them.
TEST(StrokeSurface, IsNotSoundWhereNeitherWayMeetsTheStrokes) {
  CurveNetwork strokes = whole_circles();
  Random random(2);
  for (int k = 0; k < 16; ++k) {
    const Eigen::Vector3d along = random.direction();
    test::add_stroke(strokes, 20, [&](double t) { return Eigen::Vector3d((1.6 * t - 0.8) * along); });
  }
  StrokeSurfaceOptions options = coarse();
  options.field.most_sites = 8;
  const StrokeSurface made = stroke_surface(strokes, options);
  EXPECT_FALSE(made.implicit);
  EXPECT_EQ(made.surface.flaws, std::vector<std::string>{made.doubt});
}

TEST(StrokeSurface, FailsAsTheCyclesDoWhereNeitherWayLeads) {
  CurveNetwork lines;  // parallel, in a plane
  for (int k = 0; k < 4; ++k)
    test::add_stroke(lines, 20, [&](double t) { return Eigen::Vector3d(t, 0.3 * k, 0); });
  EXPECT_THROW(stroke_surface(lines, coarse()), InvalidInput);
  EXPECT_THROW(stroke_surface(lines, coarse(StrokeTopology::Implicit)), InvalidInput);
  StrokeSurfaceOptions options = coarse(StrokeTopology::Implicit);
  options.closed = StrokeClosure::No;
  EXPECT_NE(options.problem()->find("closed no"), std::string::npos);
  EXPECT_THROW(stroke_surface(whole_circles(), options), InvalidInput);
  EXPECT_THROW(stroke_surface(test::sphere_strokes(), coarse(),
                              Progress([](std::string_view stage, double) { return stage != "normals"; })),
               Cancelled);
}

TEST(DoubtOfCycles, IsInStrokesThatLieOff) {
  const StrokeSurface made = stroke_surface(whole_circles(), coarse(StrokeTopology::Cycles));
  CurveNetwork more = whole_circles();
  EXPECT_EQ(doubt_of_cycles(more, made.surface, StrokeClosure::Yes), "");
  test::add_stroke(more, 20, [](double t) { return Eigen::Vector3d(1.5, 8 * t, 8 * t); });
  EXPECT_NE(doubt_of_cycles(more, made.surface, StrokeClosure::Auto).find("off the patches"),
            std::string::npos);
}

}  // namespace
}  // namespace batten
