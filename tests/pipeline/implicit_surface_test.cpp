#include "batten/pipeline/implicit_surface.hpp"

#include "implicit/strokes.hpp"
#include "sanitizers.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

ImplicitSurfaceOptions coarse() {
  ImplicitSurfaceOptions options;
  options.field.most_sites = test::repeated(250, 80);
  options.edge_length = Length{test::repeated(0.02, 0.04), Length::Kind::Relative};
  return options;
}

// Arcs that miss each other and leave gaps: no network could be made of them.
TEST(ImplicitSurface, OfArcsOfASphereIsTheSphere) {
  const ImplicitSurface made = implicit_surface(test::sphere_strokes(), coarse());
  const NetworkSurface& surface = made.surface;
  EXPECT_TRUE(surface.is_sound()) << surface.flaws.front();
  EXPECT_TRUE(surface.topology.is_watertight());
  EXPECT_EQ(surface.topology.genus(), 0);
  EXPECT_EQ(surface.n_curves, 9U);
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
    EXPECT_NEAR(surface.mesh.positions.row(v).norm(), 1, 0.03);
    EXPECT_GT(surface.mesh.normals.row(v).dot(surface.mesh.positions.row(v)), 0.97);
  }
  EXPECT_LT(made.stroke_distance_p95, 0.004);
  EXPECT_LE(made.stroke_distance_p95, made.stroke_distance_max);
}

TEST(ImplicitSurface, OfOpenCirclesOfATorusHasItsHandle) {
  ImplicitSurfaceOptions options = coarse();
  options.field.most_sites = test::repeated(300, 120);
  const ImplicitSurface made = implicit_surface(test::torus_strokes(), options);
  EXPECT_TRUE(made.surface.is_sound());
  EXPECT_EQ(made.surface.topology.genus(), 1);
  EXPECT_LT(made.stroke_distance_max, 0.01);
}

TEST(ImplicitSurface, NamesThePlacesThatNoStrokeIsNear) {
  CurveNetwork strokes = test::sphere_strokes(2, 0.05, 0);
  EXPECT_EQ(strokes.curves.size(), 6U);
  const ImplicitSurface whole = implicit_surface(strokes, coarse());
  // One in the middle of each octant, 35 degrees from the circles.
  ASSERT_EQ(whole.unsure.size(), 8U);
  for (const UnsurePlace& place : whole.unsure) {
    EXPECT_NEAR(place.position.cwiseAbs().minCoeff(), place.position.cwiseAbs().maxCoeff(), 0.15);
    EXPECT_NEAR(place.distance, 0.61 / whole.surface.diameter, 0.02);
    EXPECT_GT(place.area, 0.02);
    EXPECT_LT(place.area, 0.125);
  }
  EXPECT_NE(whole.surface.warnings.front().find("a stroke there would decide it"), std::string::npos);
}

TEST(ImplicitSurface, GivesTheSameBytesAgain) {
  const ImplicitSurface a = implicit_surface(test::sphere_strokes(), coarse());
  const ImplicitSurface b = implicit_surface(test::sphere_strokes(), coarse());
  EXPECT_EQ(a.surface.mesh.positions, b.surface.mesh.positions);
  EXPECT_EQ(a.surface.mesh.triangles, b.surface.mesh.triangles);
}

TEST(ImplicitSurface, NamesWhatIsWrong) {
  ImplicitSurfaceOptions options = coarse();
  options.edge_length = Length{1e-7, Length::Kind::Relative};
  EXPECT_THROW(implicit_surface(test::sphere_strokes(), options), InvalidInput);
  options.edge_length = Length{-1, Length::Kind::Relative};
  EXPECT_THROW(implicit_surface(test::sphere_strokes(), options), InvalidInput);
  options = coarse();
  options.max_triangles = 0;
  EXPECT_NE(options.problem()->find("max_triangles"), std::string::npos);
  EXPECT_THROW(implicit_surface(CurveNetwork{}, coarse()), InvalidInput);
}

}  // namespace
}  // namespace batten
