#include "batten/pipeline/subdivided_cage.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// The cube [0, 1]³ of six quads.
ControlCage cube() {
  ControlCage cage;
  cage.mesh.positions.resize(8, 3);
  for (int v = 0; v < 8; ++v) cage.mesh.positions.row(v) << (v & 1), (v >> 1 & 1), (v >> 2 & 1);
  cage.mesh.corners = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  for (int f = 1; f <= 6; ++f) cage.mesh.offsets.push_back(4 * f);
  return cage;
}

TEST(SubdividedCage, IsThatOfTheRoomBelowWithItsCage) {
  SubdividedCageOptions options;
  options.subdivision.levels = 2;
  const SubdividedCage result = subdivided_cage(cube(), options);
  EXPECT_EQ(result.n_vertices, 8);
  EXPECT_EQ(result.n_faces, 6);
  EXPECT_EQ(result.topology.genus().value_or(-1), 0);
  ASSERT_TRUE(result.refined.has_value());
  EXPECT_EQ(result.refined->cage.mesh.positions, subdivide(cube(), options.subdivision).cage.mesh.positions);
  EXPECT_EQ(result.refined->cage.mesh.n_faces(), 6 * 16);
  EXPECT_EQ(result.refined->triangles.n_triangles(), 2 * 6 * 16);
  EXPECT_EQ(result.refined->normals.rows(), 0);
  EXPECT_FALSE(result.patches.has_value());
}

TEST(SubdividedCage, OnTheLimitSurfaceHasItsNormalsWhereItIsSmooth) {
  SubdividedCageOptions options;
  options.subdivision.levels = 1;
  options.subdivision.limit = true;
  const SubdividedSurface below = subdivide(cube(), options.subdivision);
  const SubdividedCage smooth = subdivided_cage(cube(), options);
  EXPECT_EQ(smooth.refined->cage.mesh.positions, below.limit_positions);
  EXPECT_EQ(smooth.refined->normals, below.limit_normals);
  ControlCage creased = cube();
  creased.sharp_edges.push_back({0, 1});
  const SubdividedCage sharp = subdivided_cage(creased, options);
  EXPECT_EQ(sharp.n_sharp_edges, 1u);
  EXPECT_EQ(sharp.refined->normals.rows(), 0);
}

// One linear level, then two of Catmull-Clark: the same as the three by hand.
TEST(SubdividedCage, FirstSchemesMakeOneLevelEach) {
  SubdividedCageOptions options;
  options.first_schemes = {SubdivisionScheme::Linear};
  options.subdivision.levels = 3;
  const ControlCage linear = subdivide(cube(), {.scheme = SubdivisionScheme::Linear, .levels = 1}).cage;
  EXPECT_EQ(subdivided_cage(cube(), options).refined->cage.mesh.positions,
            subdivide(linear, {.levels = 2}).cage.mesh.positions);
  options.subdivision.levels = 0;  // no level is left for the first scheme either
  EXPECT_EQ(subdivided_cage(cube(), options).refined->cage.mesh.positions, cube().mesh.positions);
}

TEST(SubdividedCage, PatchesAreAskedForAlone) {
  SubdividedCageOptions options;
  options.refine = false;
  options.patches.emplace();
  if (!has_step()) {
    EXPECT_THROW(subdivided_cage(cube(), options), InvalidInput);
    return;
  }
  options.patches->step.millimetres_per_unit = 10;
  const SubdividedCage result = subdivided_cage(cube(), options);
  EXPECT_FALSE(result.refined.has_value());
  ASSERT_TRUE(result.patches.has_value());
  EXPECT_EQ(result.patches->surface.patches.size(), 6u);  // one per quad
  EXPECT_EQ(result.patches->n_exact, 0u);                 // every corner of a cube is extraordinary
  EXPECT_NEAR(result.patches->deviation, 10 * result.patches->surface.deviation, 1e-15);
  EXPECT_EQ(read_step(result.patches->text).n_solids, 1);
}

TEST(SubdividedCage, BadOptionsAreNamedAndWorkIsCancelled) {
  SubdividedCageOptions options;
  EXPECT_FALSE(options.problem().has_value());
  options.subdivision.levels = -1;
  EXPECT_NE(options.problem().value_or("").find("levels"), std::string::npos);
  options.subdivision.levels = 1;
  options.patches.emplace();
  options.patches->tolerance = -1;
  EXPECT_EQ(options.problem(), options.patches->problem());
  EXPECT_NE(options.problem().value_or("").find("tolerance must"), std::string::npos);
  options.patches->tolerance = 1e-5;
  options.patches->step.millimetres_per_unit = 0;
  EXPECT_EQ(options.problem(), options.patches->step.problem());
  EXPECT_NE(options.problem(), std::nullopt);
  options.patches.emplace();
  EXPECT_EQ(options.patches->problem(), std::nullopt);
  options.subdivision.scheme = SubdivisionScheme::Nuliss;
  EXPECT_NE(options.problem().value_or("").find("Catmull-Clark"), std::string::npos);
  EXPECT_THROW(subdivided_cage(cube(), options), InvalidInput);
  ControlCage broken = cube();
  broken.mesh.corners[0] = 99;
  EXPECT_THROW(subdivided_cage(broken), InvalidInput);
  EXPECT_THROW(subdivided_cage(cube(), {}, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

}  // namespace
}  // namespace batten
