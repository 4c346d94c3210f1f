#include "batten/pipeline/surface_flaws.hpp"

#include "network/sample_networks.hpp"

#include <gtest/gtest.h>

#include "batten/mesh/self_intersections.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {
namespace {

std::vector<std::string> flaws_of_surface(const SurfaceResult& surface) {
  return surface_flaws(surface.mesh, {surface.patch_of_triangle, surface.on_network, surface.folded,
                                      self_intersections(surface.mesh.positions, surface.mesh.triangles)});
}

bool contain(const std::vector<std::string>& flaws, const std::string& words) {
  for (const std::string& flaw : flaws)
    if (flaw.find(words) != std::string::npos) return true;
  return false;
}

/// A short tube: two circles with normals away from their axis, one patch.
SurfaceResult short_tube() {
  samples::NetworkBuilder builder;
  samples::add_circle(builder, 24, 1, 0, 0, true);
  samples::add_circle(builder, 24, 1, 0.5, 0, true);
  return surface_network(builder.build());
}

TEST(SurfaceFlaws, AreNoneOfASoundSurface) {
  EXPECT_TRUE(flaws_of_surface(surface_network(samples::octahedral_sphere(6))).empty());
  EXPECT_TRUE(flaws_of_surface(short_tube()).empty());
}

// The inside of the tube drawn together in a point of its axis: two flat cones, whose normals stand at 76° to
// those of the tube. No triangle is turned over.
TEST(SurfaceFlaws, NameAPatchThatCollapsed) {
  SurfaceResult surface = short_tube();
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v)
    if (!surface.on_network[static_cast<std::size_t>(v)]) {
      surface.mesh.positions.row(v).leftCols(2) *= 1e-3;
      surface.mesh.positions(v, 2) = 0.25;
    }
  const std::vector<std::string> flaws = flaws_of_surface(surface);
  EXPECT_TRUE(contain(flaws, "the surface has collapsed")) << flaws.size();
  EXPECT_TRUE(contain(flaws, "in patch 0, at (")) << flaws.front();
}

// The box around the circles is 2 × 2 × 0.5 with a diagonal of 2.87; a vertex 4 above it is too far away,
// one 2 above is not.
TEST(SurfaceFlaws, NameAPatchThatLeavesItsCurves) {
  SurfaceResult surface = short_tube();
  Eigen::Index inner = 0;
  while (surface.on_network[static_cast<std::size_t>(inner)]) ++inner;
  surface.mesh.positions.row(inner) << 0, 0, 2.5;
  EXPECT_FALSE(contain(flaws_of_surface(surface), "leaves its curves"));
  surface.mesh.positions.row(inner) << 0, 0, 4.5;
  EXPECT_TRUE(contain(flaws_of_surface(surface), "patch 0 leaves its curves by 4 at (0, 0, 4.5)"));
}

TEST(SurfaceFlaws, CountAndPlaceWhatCrossesAndWhatIsTurned) {
  SurfaceResult surface = surface_network(samples::octahedral_sphere(6));
  surface.folded = {3, 5};
  const std::vector<std::string> flaws =
      surface_flaws(surface.mesh, {surface.patch_of_triangle, surface.on_network, surface.folded, {{3, 5}}});
  ASSERT_EQ(flaws.size(), 2U);
  EXPECT_EQ(flaws[0].rfind("1 pair of triangles crosses in patch 0, at (", 0), 0U) << flaws[0];
  EXPECT_EQ(flaws[1].rfind("2 triangles are turned away from the normals of the curves in patch 0, at (", 0),
            0U)
      << flaws[1];
}

}  // namespace
}  // namespace batten
