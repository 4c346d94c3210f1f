#include "apps/run_json.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

// From a scan to a network, a surface and a picture: the deviations travel in the files.
TEST(Uncertainty, TravelsFromTheScanToThePicture) {
  const std::string simulate =
      "simulate sphere -o u.rawnet --orientation-noise 2deg --drift 1deg --odometer-error 0.3% --seed 5";
  ASSERT_EQ(run_batten(simulate).exit_code, 0);
  const Json network = run_json("network u.rawnet -o u.json --step 5% --uncertainty");
  const Json figures = network["uncertainty"];
  EXPECT_GT(figures["median"].get<double>(), 0);
  EXPECT_LE(figures["median"], figures["p95"]);
  EXPECT_LE(figures["p95"], figures["max"]);
  const Json file = Json::parse(read_file("u.json"));
  ASSERT_EQ(file["uncertainty"].size(), file["positions"].size());
  const Json surface = run_json("surface u.json -o u.ply --edge-length 10% --uncertainty");
  EXPECT_TRUE(surface["warnings"].empty()) << surface["warnings"];
  // Between the curves nothing is surer than the least sure curve by much: both are spread from the same
  // values.
  EXPECT_GE(surface["uncertainty"]["max"].get<double>(), 0.9 * figures["max"].get<double>());
  EXPECT_NE(read_file("u.ply").find("uncertainty"), std::string::npos);
  EXPECT_EQ(run_batten("render u.ply -o u.png --shading uncertainty --size 64x48").exit_code, 0);
  EXPECT_EQ(run_batten("render u.json -o n.png --shading uncertainty --size 64x48").exit_code, 0);
}

TEST(Uncertainty, SaysWhereItCannotBeKeptOrTold) {
  const std::string simulate = "simulate sphere -o w.rawnet --orientation-noise 2deg --seed 5 --step 3%";
  ASSERT_EQ(run_batten(simulate).exit_code, 0);
  const Json network = run_json("network w.rawnet -o w.obj --step 8% --uncertainty");
  EXPECT_NE(network["warnings"].dump().find("write .json to keep it"), std::string::npos);
  EXPECT_EQ(run_batten("network w.rawnet -o w.json --weights thesis --uncertainty").exit_code, 2);
  // A surface of curves that do not say how sure they are says so; a file without the value cannot be drawn.
  const Json surface = run_json("surface w.obj -o w.ply --edge-length 15% --uncertainty");
  EXPECT_NE(surface["warnings"].dump().find("taken as exact"), std::string::npos);
  EXPECT_EQ(run_batten("render w.obj -o w.png --shading uncertainty").exit_code, 3);
}

}  // namespace
}  // namespace batten::test
