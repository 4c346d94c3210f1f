#include "batten/fairing/fair.hpp"

#include "fairing/shapes.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/noise.hpp"

namespace batten {
namespace {

using fixtures::Mesh;

TEST(FairingMethod, EveryOneHasAWord) {
  const std::vector<std::string> words = choice_words<FairingMethod>();
  EXPECT_EQ(words.front(), "auto");
  EXPECT_EQ(words.size(), static_cast<std::size_t>(FairingMethod::Nonlocal) + 1);
  EXPECT_EQ(parse_choice<FairingMethod>("guided-normal"), FairingMethod::GuidedNormal);
  EXPECT_THROW(parse_choice<FairingMethod>("magic"), InvalidInput);
}

TEST(Fair, BadOptionsAreNamed) {
  const Mesh mesh = fixtures::cube(2);
  FairingOptions options;
  options.noise = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(options.problem().has_value());
  EXPECT_NE(options.problem()->find("noise"), std::string::npos);
  EXPECT_THROW(fair(mesh.positions, mesh.triangles, options), InvalidInput);
  options.noise = -1;
  options.iterations = -1;
  EXPECT_THROW(fair(mesh.positions, mesh.triangles, options), InvalidInput);
  options.iterations = 0;
  EXPECT_FALSE(options.problem().has_value());
}

class FairByEveryMethod : public testing::TestWithParam<std::string> {};

// Whatever the method, the normals of a round shape come nearer to the truth and the border stays when asked.
TEST_P(FairByEveryMethod, BringsTheNormalsOfANoisyDomeNearerToTheTruth) {
  Mesh mesh = fixtures::sheet(20, 20, 2, 2);
  for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
    const double x = mesh.positions(v, 0) - 1, y = mesh.positions(v, 1) - 1;
    mesh.positions(v, 2) = 0.3 * (2 - x * x - y * y);
  }
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.15, 8);
  FairingOptions options;
  options.method = parse_choice<FairingMethod>(GetParam());
  options.keep_boundary = true;
  const FairingResult result = fair(noisy, mesh.triangles, options);
  EXPECT_LT(fixtures::normal_error_deg(result.positions, mesh.positions, mesh.triangles),
            0.95 * fixtures::normal_error_deg(noisy, mesh.positions, mesh.triangles));
  EXPECT_GT(result.iterations, 0);
  EXPECT_NEAR(result.noise, 0.15, 0.05);
  EXPECT_NEAR(result.largest_move, (result.positions - noisy).rowwise().norm().maxCoeff(), 1e-12);
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(result.positions.row(i), noisy.row(i));
}

INSTANTIATE_TEST_SUITE_P(Fairing, FairByEveryMethod, testing::ValuesIn(choice_words<FairingMethod>()),
                         [](const testing::TestParamInfo<std::string>& method) {
                           std::string name;
                           for (const char c : method.param) name += c == '-' ? '_' : c;
                           return name;
                         });

TEST(Fair, TakesTheNoiseAndIterationsThatAreGiven) {
  const Mesh mesh = fixtures::cube(8);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 8);
  FairingOptions options;
  options.noise = 0.25;
  options.iterations = 4;
  const FairingResult result = fair(noisy, mesh.triangles, options);
  EXPECT_NEAR(result.noise, 0.25, 1e-12);
  EXPECT_EQ(result.iterations, 4);
  options.noise = 0;  // "there is none"
  EXPECT_EQ(fair(noisy, mesh.triangles, options).positions, noisy);
  EXPECT_EQ(fair(noisy, mesh.triangles, options).strategy, FairingStrategy::None);
}

// Meshes in which lengths, areas or neighbourhoods vanish: every method ends, with numbers.
TEST_P(FairByEveryMethod, SurvivesBadTrianglesAndLonelyVertices) {
  std::vector<Mesh> meshes(4);
  meshes[0] = fixtures::sheet(7, 7, 1, 1);
  meshes[0].positions = add_gaussian_noise(meshes[0].positions, meshes[0].triangles, 0.2, 3);
  meshes[0].positions.row(20) = meshes[0].positions.row(21);  // triangles without area
  meshes[0].positions.conservativeResize(meshes[0].positions.rows() + 1, 3);
  meshes[0].positions.bottomRows(1).setConstant(5);  // a vertex without triangles
  meshes[1].positions = Points::Zero(5, 3);          // all in one place
  meshes[1].triangles.resize(3, 3);
  meshes[1].triangles << 0, 1, 2, 2, 1, 3, 2, 3, 4;
  meshes[2].positions.resize(3, 3);  // one triangle
  meshes[2].positions << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  meshes[2].triangles.resize(1, 3);
  meshes[2].triangles << 0, 1, 2;
  meshes[3].positions = Points::Ones(2, 3);  // no triangles
  meshes[3].triangles.resize(0, 3);
  FairingOptions options;
  options.method = parse_choice<FairingMethod>(GetParam());
  for (const Mesh& mesh : meshes) {
    const FairingResult result = fair(mesh.positions, mesh.triangles, options);
    ASSERT_EQ(result.positions.rows(), mesh.positions.rows());
    EXPECT_TRUE(result.positions.allFinite());
  }
  // What has no triangles stays where it is.
  EXPECT_LT((fair(meshes[0].positions, meshes[0].triangles, options).positions.bottomRows(1) -
             meshes[0].positions.bottomRows(1))
                .norm(),
            1e-9);
}

// In units a million times larger or smaller the result is the same but for rounding: no length of the method
// is absolute. (Motions too small for rounding to matter on the single precision weights of auto.)
TEST_P(FairByEveryMethod, DoesNotDependOnTheUnit) {
  const Mesh mesh = fixtures::closed_sphere(6);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 3);
  FairingOptions options;
  options.method = parse_choice<FairingMethod>(GetParam());
  const Points faired = fair(noisy, mesh.triangles, options).positions;
  for (const double scale : {1e-6, 1e6}) {
    const Points again = fair(scale * noisy, mesh.triangles, options).positions;
    EXPECT_LT((again / scale - faired).cwiseAbs().maxCoeff(), 1e-3) << scale;
  }
}

TEST(Fair, RefusesBadOptionsAndMeshes) {
  Mesh mesh = fixtures::cube(2);
  FairingOptions options;
  options.noise = std::nan("");
  EXPECT_THROW(fair(mesh.positions, mesh.triangles, options), InvalidInput);
  options = {};
  options.iterations = -2;
  EXPECT_THROW(fair(mesh.positions, mesh.triangles, options), InvalidInput);
  mesh.positions(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(fair(mesh.positions, mesh.triangles), InvalidInput);
}

}  // namespace
}  // namespace batten
