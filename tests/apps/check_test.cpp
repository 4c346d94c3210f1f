#include "apps/run_batten.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

class CheckCommand : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_batten("simulate sphere -o ball.rawnet").exit_code, 0);
    ASSERT_EQ(run_batten("reconstruct ball.rawnet -o ball.ply --network ball.json").exit_code, 0);
  }
};

TEST_F(CheckCommand, PassesASurfaceThatIsSmoothAndFailsItWithPicturesBelowWhatAMeshCanShow) {
  const auto good = run_batten("check ball.ply --network ball.json --json");
  ASSERT_EQ(good.exit_code, 0) << good.err << good.out;
  const Json passed = Json::parse(good.out);
  EXPECT_EQ(passed["passes"], true);
  EXPECT_EQ(passed["failed"], 0);
  EXPECT_GT(passed["checked"].get<int>(), 2);
  for (const Json& curve : passed["curves"]) EXPECT_LT(curve["max_normal_jump_deg"].get<double>(), 0.5);

  const auto bad =
      run_batten("check ball.ply --network ball.json --tolerance 0.0001deg --pictures failures --json");
  EXPECT_EQ(bad.exit_code, 1);
  const Json failed = Json::parse(bad.out);
  EXPECT_EQ(failed["passes"], false);
  ASSERT_EQ(failed["pictures"].size(), failed["failed"].get<std::size_t>());
  for (const Json& picture : failed["pictures"])
    EXPECT_EQ(read_file(picture.get<std::string>()).substr(1, 3), "PNG") << picture;
}

TEST_F(CheckCommand, SaysInWordsWhichCurveFailsAndWhereToLook) {
  const auto run = run_batten("check ball.ply --network ball.json --tolerance 0.0001deg");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.out.find("fail  curve 0"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("--pictures FOLDER"), std::string::npos) << run.err;
}

TEST_F(CheckCommand, RefusesTheOneForTheOtherAndSaysWhatIsMeant) {
  const auto network = run_batten("check ball.json --network ball.json");
  EXPECT_EQ(network.exit_code, 3) << network.err;
  EXPECT_NE(network.err.find("batten surface"), std::string::npos) << network.err;
  const auto mesh = run_batten("check ball.ply --network ball.ply");
  EXPECT_EQ(mesh.exit_code, 3);
  EXPECT_NE(mesh.err.find("is a mesh"), std::string::npos) << mesh.err;
  EXPECT_EQ(run_batten("check ball.ply").exit_code, 2);
  EXPECT_EQ(run_batten("check ball.ply --network ball.json --tolerance 0deg").exit_code, 2);
}

}  // namespace
}  // namespace batten::test
