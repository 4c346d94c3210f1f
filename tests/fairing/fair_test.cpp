#include "batten/fairing/fair.hpp"

#include "fairing/shapes.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/noise.hpp"

namespace batten {
namespace {

using fixtures::Mesh;

TEST(FairingMethodNames, GoBothWays) {
  const std::vector<std::string>& names = fairing_method_names();
  EXPECT_EQ(names.front(), "auto");
  EXPECT_EQ(names.size(), static_cast<std::size_t>(FairingMethod::Nonlocal) + 1);
  for (std::size_t i = 0; i < names.size(); ++i)
    EXPECT_EQ(static_cast<std::size_t>(parse_fairing_method(names[i])), i);
  EXPECT_EQ(parse_fairing_method("guided-normal"), FairingMethod::GuidedNormal);
  EXPECT_THROW(parse_fairing_method("magic"), InvalidInput);
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
  options.method = parse_fairing_method(GetParam());
  options.keep_boundary = true;
  const FairingResult result = fair(noisy, mesh.triangles, options);
  EXPECT_LT(fixtures::normal_error_deg(result.positions, mesh.positions, mesh.triangles),
            0.95 * fixtures::normal_error_deg(noisy, mesh.positions, mesh.triangles));
  EXPECT_GT(result.iterations, 0);
  EXPECT_NEAR(result.noise, 0.15, 0.05);
  EXPECT_NEAR(result.largest_move, (result.positions - noisy).rowwise().norm().maxCoeff(), 1e-12);
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(result.positions.row(i), noisy.row(i));
}

INSTANTIATE_TEST_SUITE_P(Fairing, FairByEveryMethod, testing::ValuesIn(fairing_method_names()),
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
  EXPECT_EQ(fair(noisy, mesh.triangles, options).strategy, "none");
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
