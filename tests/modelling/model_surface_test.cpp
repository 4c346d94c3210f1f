#include "batten/modelling/model_surface.hpp"

#include "sketch/quadrics.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {
namespace {

using namespace strokes;

TEST(ModelSurface, EveryMethodMakesASoundSphereOfThreeGreatCircles) {
  const PolylineMesh model = three_great_circles();
  for (const ModelSurfaceMethod method : choice_values<ModelSurfaceMethod>()) {
    const ModelSurface surface = model_surface(model, {.method = method, .levels = 2});
    ASSERT_TRUE(surface.soundness.has_value()) << word_of(method);
    EXPECT_TRUE(surface.soundness->is_sound()) << word_of(method);
    EXPECT_TRUE(surface.warnings.empty()) << word_of(method);
    const MeshTopology topology = mesh_topology(surface.mesh.triangles, surface.mesh.n_vertices());
    EXPECT_TRUE(topology.is_watertight());
    EXPECT_EQ(topology.euler_characteristic, 2);
    // Coons patches bulge between their curves (docs/sketch.md); the others are held by mean curvature.
    EXPECT_LT((surface.mesh.positions.rowwise().norm().array() - 1).abs().maxCoeff(),
              method == ModelSurfaceMethod::Coons ? 0.07 : 0.02)
        << word_of(method);
    EXPECT_EQ(surface.division.has_value(), method == ModelSurfaceMethod::Coons);
  }
}

TEST(ModelSurface, WithoutAMeshOnlyTheCageIsMade) {
  const ModelSurface surface = model_surface(three_great_circles(), {.with_mesh = false});
  EXPECT_EQ(surface.mesh.n_triangles(), 0);
  EXPECT_FALSE(surface.soundness.has_value());
  EXPECT_EQ(surface.cage.mesh.n_faces(), surface.n_quads);
}

TEST(ModelSurface, BadOptionsAreNamed) {
  const ModelSurfaceOptions options{.levels = 7};
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("levels"), std::string::npos);
  EXPECT_THROW(model_surface(three_great_circles(), options), InvalidInput);
}

}  // namespace
}  // namespace batten
