#include <limits>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/remeshing/feature_chains.hpp"
#include "batten/remeshing/normal_fit.hpp"
#include "batten/remeshing/surface_fit.hpp"

namespace batten {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(RemeshingOptions, DefaultsAreSound) {
  EXPECT_EQ(FeatureOptions().problem(), std::nullopt);
  EXPECT_EQ(NormalFitOptions().problem(), std::nullopt);
  EXPECT_EQ(SurfaceFitOptions().problem(), std::nullopt);
}

TEST(RemeshingOptions, TheFirstBadFieldIsNamedWithItsValue) {
  EXPECT_EQ(FeatureOptions{.crease_angle = -1}.problem(), "crease_angle must be >= 0, got -1");
  EXPECT_EQ(FeatureOptions{.corner_angle = -2}.problem(), "corner_angle must be >= 0, got -2");
  EXPECT_EQ(FeatureOptions{.least_length = -3}.problem(), "least_length must be >= 0, got -3");
  EXPECT_EQ(FeatureOptions{.fade = 0}.problem(), "fade must be above 0 and at most 1, got 0");
  EXPECT_EQ(FeatureOptions{.fade = 1.5}.problem(), "fade must be above 0 and at most 1, got 1.5");
  EXPECT_TRUE(FeatureOptions{.least_length = kNan}.problem().has_value());
  EXPECT_EQ(NormalFitOptions{.shape = -1}.problem(), "shape must be >= 0, got -1");
  EXPECT_EQ(NormalFitOptions{.mean_angle = 2}.problem(), "mean_angle must be 0 to π/3, got 2");
  EXPECT_EQ(NormalFitOptions{.distance = -1}.problem(), "distance must be >= 0, got -1");
  EXPECT_EQ(NormalFitOptions{.valence = -1}.problem(), "valence must be >= 0, got -1");
  EXPECT_EQ(NormalFitOptions{.least_angle = -1}.problem(), "least_angle must be 0 to π/3, got -1");
  EXPECT_EQ(NormalFitOptions{.rounds = -1}.problem(), "rounds must be >= 0, got -1");
  EXPECT_EQ(SurfaceFitOptions{.normals = -1}.problem(), "normals must be >= 0, got -1");
  EXPECT_EQ(SurfaceFitOptions{.most = -1}.problem(), "most must be >= 0, got -1");
}

TEST(RemeshingOptions, BadOnesAreRefusedBeforeAnyWork) {
  HalfedgeMesh mesh;
  EXPECT_THROW(mark_features(mesh, {.crease_angle = -1}), InvalidInput);
  EXPECT_THROW(fitted_to_surface(Points(0, 3), Triangles(0, 3), {}, {}, {.normals = -1}), InvalidInput);
}

}  // namespace
}  // namespace batten
