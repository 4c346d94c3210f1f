#include "batten/pipeline/step_surface.hpp"

#include "modelling/patched_shapes.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

TEST(StepSurface, IsTheFileOfItsFacesInMillimetres) {
  if (!has_step()) GTEST_SKIP() << "built without Open Cascade";
  const test::PatchedMesh cube = test::cube_of_patches();
  StepSurfaceOptions options;
  options.step.millimetres_per_unit = 25.4;
  const StepSurface surface = step_surface(cube.mesh, cube.patches, options);
  EXPECT_TRUE(surface.warnings.empty());
  EXPECT_TRUE(surface.flaws.empty());
  EXPECT_NEAR(surface.diameter, std::sqrt(3.0), 1e-12);
  const StepModel model = read_step(surface.text);
  EXPECT_EQ(model.n_faces, 6);
  EXPECT_EQ(model.n_solids, 1);
  EXPECT_NEAR(model.volume, 25.4 * 25.4 * 25.4, 1e-4);
  EXPECT_EQ(step_surface(cube.mesh, cube.patches, options).text, surface.text);
}

TEST(StepSurface, NamesItsEdgesAndFacesAfterTheCurves) {
  if (!has_step()) GTEST_SKIP() << "built without Open Cascade";
  const test::PatchedMesh cube = test::cube_of_patches();
  // One curve with a name and one without, of two edges each; the other edges of the cube have none.
  CurveNetwork network;
  network.positions.resize(6, 3);
  network.positions << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1;
  network.curves.resize(2);
  network.curves[0].name = "keel";
  network.curves[0].vertices = {0, 1, 2};
  network.curves[1].vertices = {3, 4, 5};
  StepSurfaceOptions options;
  options.network = &network;
  const std::string text = step_surface(cube.mesh, cube.patches, options).text;
  const auto count = [&](const std::string& words) {
    int n = 0;
    for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("EDGE_CURVE('keel'"), 2);
  EXPECT_EQ(count("EDGE_CURVE('curve 1'"), 2);
  EXPECT_EQ(count("EDGE_CURVE('',"), 8);
  EXPECT_EQ(count("ADVANCED_FACE('patch "), 6);
  EXPECT_EQ(count(": keel'"), 1);           // below
  EXPECT_EQ(count(": curve 1'"), 1);        // above
  EXPECT_EQ(count(": keel, curve 1'"), 2);  // beside
}

TEST(StepSurface, WarnsWhereTheToleranceIsNotReached) {
  if (!has_step()) GTEST_SKIP() << "built without Open Cascade";
  const test::PatchedMesh torus = test::torus_of_patches(0.35, 3, 2, 6);
  StepSurfaceOptions options;
  options.faces.tolerance = 1e-9;
  const StepSurface surface = step_surface(torus.mesh, torus.patches, options);
  ASSERT_FALSE(surface.warnings.empty());
  EXPECT_NE(surface.warnings[0].find("`step_tolerance`"), std::string::npos);
  EXPECT_TRUE(surface.flaws.empty());
}

TEST(StepSurface, OptionsAreCheckedBeforeTheWork) {
  StepSurfaceOptions options;
  EXPECT_FALSE(options.problem());
  options.step.millimetres_per_unit = 0;
  EXPECT_NE(options.problem().value_or("").find("millimetres_per_unit"), std::string::npos);
  options = {};
  options.faces.most_spans = 65;
  EXPECT_NE(options.problem().value_or("").find("most_spans"), std::string::npos);
  EXPECT_THROW(step_surface({}, {}, options), InvalidInput);
}

}  // namespace
}  // namespace batten
