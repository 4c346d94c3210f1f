#include "apps/run_batten.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// An L-shaped sheet at height z, scaled: no symmetry, so that a registration has one answer.
std::string sheet(double z, double scale = 1) {
  std::string text = "OFF\n6 4 0\n";
  const double corners[6][3] = {{0, 0, z}, {3, 0, z}, {3, 1, z}, {1, 1, z}, {1, 2, z + 0.2}, {0, 2, z}};
  for (const auto& p : corners)
    text += std::to_string(scale * p[0]) + " " + std::to_string(scale * p[1]) + " " +
            std::to_string(scale * p[2]) + "\n";
  return text + "3 0 1 2\n3 0 2 3\n3 0 3 5\n3 3 4 5\n";
}

/// A closed tetrahedron without symmetry, moved and scaled. (On a nearly flat sheet a registration by
/// distances alone may shrink: its inside slides within the other sheet.)
std::string tetrahedron(double shift, double scale = 1) {
  std::string text = "OFF\n4 4 0\n";
  const double corners[4][3] = {{0, 0, 0}, {3, 0, 0.4}, {0.5, 2, 0}, {1, 0.7, 1.5}};
  for (const auto& p : corners)
    text += std::to_string(scale * p[0] + shift) + " " + std::to_string(scale * p[1]) + " " +
            std::to_string(scale * p[2]) + "\n";
  return text + "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
}

// Two copies half a unit apart: every distance is 0.5 where they face each other flat, never more.
TEST(CompareCommand, MeasuresAKnownGapAndSaysItInJson) {
  write_file("a.off", sheet(0));
  write_file("b.off", sheet(0.5));
  const auto run = run_batten("compare a.off b.off --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["command"], "compare");
  EXPECT_EQ(json["options"]["register"], "none");
  EXPECT_EQ(json["samples"], 200000);
  const double diameter = std::sqrt(9 + 4 + 0.04);
  EXPECT_NEAR(json["diameter"].get<double>(), diameter, 1e-6);
  for (const char* side : {"a_to_b", "b_to_a"}) {
    EXPECT_NEAR(json[side]["max"].get<double>(), 0.5, 1e-6);
    EXPECT_NEAR(json[side]["mean"].get<double>(), 0.5, 0.01);
    for (const char* over : {"vertices", "samples"})
      for (const char* figure : {"max", "mean", "rms"})
        EXPECT_NEAR(json["relative"][side][over][figure].get<double>(),
                    json[side][over][figure].get<double>() / diameter, 1e-6);
  }
  EXPECT_TRUE(json["seconds"].contains("total"));
  EXPECT_TRUE(json["warnings"].is_array());
}

TEST(CompareCommand, RegistersAndWritesTheDistances) {
  write_file("a.off", tetrahedron(7, 2));
  write_file("b.off", tetrahedron(0));
  const auto run = run_batten("compare a.off b.off --register similarity --distances out.ply --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_NEAR(json["registration"]["scale"].get<double>(), 0.5, 1e-5);
  EXPECT_NEAR(json["registration"]["rotation"][0][0].get<double>(), 1, 1e-5);
  EXPECT_LT(json["a_to_b"]["max"].get<double>(), 1e-5);
  EXPECT_NE(read_file("out.ply").find("distance"), std::string::npos);
}

TEST(CompareCommand, TakesAMeshAndANetworkInEitherOrder) {
  write_file("a.off", sheet(0));
  write_file("n.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nl 1 2\nl 2 3\n");
  EXPECT_NEAR(Json::parse(run_batten("compare n.obj a.off --json").out)["a_to_b"]["max"].get<double>(), 1,
              1e-6);
  EXPECT_NEAR(Json::parse(run_batten("compare a.off n.obj --json").out)["b_to_a"]["max"].get<double>(), 1,
              1e-6);
}

TEST(CompareCommand, TellsBadUsageFromBadInput) {
  write_file("a.off", sheet(0));
  write_file("flat.net", "nonsense\n");
  EXPECT_EQ(run_batten("compare a.off").exit_code, 2);
  EXPECT_EQ(run_batten("compare a.off a.off --register loosely").exit_code, 2);
  EXPECT_EQ(run_batten("compare a.off a.off --samples 0").exit_code, 2);
  EXPECT_EQ(run_batten("compare a.off a.off --distances out.obj").exit_code, 2);
  const auto missing = run_batten("compare a.off nowhere.ply");
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.err.find("nowhere.ply"), std::string::npos);
  EXPECT_EQ(run_batten("compare a.off flat.net").exit_code, 3);
  const auto scan = run_batten("compare a.off scan.rawnet");
  EXPECT_EQ(scan.exit_code, 3);
  EXPECT_NE(scan.err.find("batten network"), std::string::npos);
  EXPECT_EQ(run_batten("compare a.off a.off --distances no/such/folder/out.ply").exit_code, 3);
}

}  // namespace
}  // namespace batten::test
