#include "batten/modelling/model_surface.hpp"

#include "sketch/quadrics.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/modelling/continuity.hpp"

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

/// Two unit squares in the plane z = 0, side by side, of two triangles each; one face of the model each.
TriangleMesh two_squares() {
  TriangleMesh mesh;
  mesh.positions.resize(6, 3);
  mesh.positions << 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4;
  mesh.normals = Points::Zero(6, 3);
  mesh.normals.col(2).setOnes();
  return mesh;
}

TEST(TurnedTriangles, AreThoseAgainstTheNormalsButForCreases) {
  TriangleMesh mesh = two_squares();
  EXPECT_TRUE(turned_triangles(mesh, std::vector<char>(6, 0)).empty());
  mesh.triangles.row(2) << 2, 1, 5;
  EXPECT_EQ(turned_triangles(mesh, std::vector<char>(6, 0)), std::vector<int>{2});
  // All its vertices on creases: their normals are means of both sides and say nothing.
  EXPECT_TRUE(turned_triangles(mesh, {0, 1, 1, 0, 0, 1}).empty());
}

TEST(SurfaceSoundness, NamesTheFacesThatCrossOrHoldTurnedTriangles) {
  TriangleMesh mesh = two_squares();
  EXPECT_TRUE(surface_soundness(mesh, {}, {7, 7, 9, 9}).is_sound());
  const SurfaceSoundness turned = surface_soundness(mesh, {3}, {7, 7, 9, 9});
  EXPECT_EQ(turned.broken_faces, std::vector<int>{9});
  EXPECT_NE(turned.sentence().find("f9"), std::string::npos);
  // A fifth triangle that goes upright through the first one, of face 11.
  mesh.positions.conservativeResize(9, 3);
  mesh.positions.bottomRows(3) << 0.6, 0.1, -1, 0.6, 0.3, -1, 0.6, 0.2, 1;
  mesh.triangles.conservativeResize(5, 3);
  mesh.triangles.row(4) << 6, 7, 8;
  const SurfaceSoundness crossing = surface_soundness(mesh, {}, {7, 7, 9, 9, 11});
  EXPECT_EQ(crossing.crossing_pairs, 1u);
  EXPECT_EQ(crossing.broken_faces, (std::vector<int>{7, 11}));
}

TEST(ModelContinuity, MeasuresEverySmoothCurveOfASphere) {
  const PolylineMesh model = three_great_circles();
  const ModelSurface surface = model_surface(model, {.levels = 2});
  const ModelContinuity continuity = model_continuity(model, surface.mesh, 3);
  EXPECT_EQ(continuity.curves.size(), 3u);
  EXPECT_EQ(continuity.sharp.n_samples, 0);
  EXPECT_GT(continuity.smooth.n_samples, 0);
  EXPECT_LT(continuity.smooth.max_normal_jump, 0.01);  // radians; 0.09 degrees in docs/sketch.md at level 3
  std::set<int> curves;
  for (const ModelContinuity::CurveEntry& entry : continuity.curves) curves.insert(entry.curve);
  EXPECT_TRUE(curves.count(continuity.worst_curve) > 0);
}

}  // namespace
}  // namespace batten
