#include "apps/run_batten.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

bool lacks_step(const Run& run) {
  return run.exit_code != 0 && run.err.find("Open Cascade") != std::string::npos;
}

TEST(SurfaceStep, AScanBecomesASolidOfFewFaces) {
  ASSERT_EQ(run_batten("simulate torus -o torus.rawnet --step 4%").exit_code, 0);
  const test::Run run = run_batten("reconstruct torus.rawnet -o torus.step --unit cm --json");
  if (lacks_step(run)) GTEST_SKIP() << "built without Open Cascade";
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json step = Json::parse(run.out)["surface"]["step"];
  EXPECT_EQ(step["solids"], 1);
  EXPECT_EQ(step["unit"], "cm");
  EXPECT_EQ(step["sharp_edges"], 0);
  EXPECT_LT(step["faces"], 100);
  EXPECT_LT(step["relative_deviation"], 1e-4);
  EXPECT_LT(step["normal_jump_deg"], 0.1);
  const std::string text = read_file("torus.step");
  EXPECT_EQ(text.rfind("ISO-10303-21;", 0), 0u);
  EXPECT_NE(text.find("MANIFOLD_SOLID_BREP"), std::string::npos);
  EXPECT_EQ(text.size(), step["bytes"].get<std::size_t>());
}

TEST(SurfaceStep, RefusesBeforeAnythingIsWritten) {
  ASSERT_EQ(run_batten("simulate sphere -o sphere.rawnet --step 4%").exit_code, 0);
  write_file("old.step", "kept");
  test::Run run = run_batten("reconstruct sphere.rawnet -o old.step --max-patches 3");
  if (lacks_step(run)) GTEST_SKIP() << "built without Open Cascade";
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("B-spline faces"), std::string::npos) << run.err;
  run = run_batten("reconstruct sphere.rawnet -o old.step --unit parsec");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("parsec"), std::string::npos) << run.err;
  EXPECT_EQ(read_file("old.step"), "kept");
}

}  // namespace
}  // namespace batten::test
