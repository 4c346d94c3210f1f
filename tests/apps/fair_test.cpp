#include "apps/run_batten.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// A square sheet of n × n cells with every other inner vertex lifted by `bump`.
std::string sheet(int n, double bump) {
  std::string text = "OFF\n" + std::to_string((n + 1) * (n + 1)) + " " + std::to_string(2 * n * n) + " 0\n";
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      text += std::to_string(i) + " " + std::to_string(j) + " " +
              std::to_string(inner && (7 * i + 3 * j) % 4 < 2 ? bump : 0.0) + "\n";
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int p = i * (n + 1) + j, q = p + n + 1;
      text += "3 " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(q + 1) + "\n3 " +
              std::to_string(p) + " " + std::to_string(q + 1) + " " + std::to_string(p + 1) + "\n";
    }
  return text;
}

TEST(FairCommand, SmoothsAMeshAndSaysWhatItDid) {
  write_file("rough.off", sheet(12, 0.4));
  const auto run = run_batten("fair rough.off -o smooth.ply --keep-boundary --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["command"], "fair");
  EXPECT_EQ(json["options"]["method"], "auto");
  EXPECT_EQ(json["vertices"], 169);
  EXPECT_EQ(json["faces"], 288);
  EXPECT_EQ(json["boundary_loops"], 1);
  EXPECT_GT(json["noise"].get<double>(), 0.05);
  EXPECT_GT(json["largest_move"].get<double>(), 0.05);
  EXPECT_TRUE(json["volume_change_percent"].is_null());  // open
  EXPECT_TRUE(file_exists("smooth.ply"));
}

TEST(FairCommand, TakesEveryMethod) {
  write_file("rough.off", sheet(6, 0.3));
  for (const char* method : {"auto", "nlsdf", "sdf", "mcf", "bilaplacian", "amcf", "amcf-tensor", "tv",
                             "taubin", "bilateral-normal", "guided-normal", "elastica", "nonlocal"}) {
    const auto run = run_batten(
        std::string("fair rough.off -o out.obj --noise 0.2 --iterations 2 --json --method ") + method);
    ASSERT_EQ(run.exit_code, 0) << method << run.err;
    EXPECT_EQ(Json::parse(run.out)["method"], method);
  }
}

TEST(FairCommand, LeavesACleanMeshAloneAndWarns) {
  write_file("flat.off", sheet(10, 0));
  const auto run = run_batten("fair flat.off -o same.off --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["strategy"], "none");
  EXPECT_EQ(json["largest_move"], 0);
  EXPECT_EQ(json["warnings"].size(), 1U);
}

TEST(FairCommand, SplitsPolygonsAndSaysSo) {
  write_file("quads.off",
             "OFF\n9 4 0\n0 0 0\n1 0 .1\n2 0 0\n0 1 .1\n1 1 -.2\n2 1 .1\n0 2 0\n1 2 .1\n2 2 0\n"
             "4 0 1 4 3\n4 1 2 5 4\n4 3 4 7 6\n4 4 5 8 7\n");
  const auto run = run_batten("fair quads.off -o out.off --noise 0.1 --keep-boundary --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["faces"], 8);
  ASSERT_EQ(json["warnings"].size(), 1U);
  EXPECT_NE(json["warnings"][0].get<std::string>().find("split into triangles"), std::string::npos);
}

TEST(FairCommand, TellsBadUsageFromBadInput) {
  write_file("rough.off", sheet(4, 0.3));
  EXPECT_EQ(run_batten("fair rough.off -o a.off --method magic").exit_code, 2);
  EXPECT_EQ(run_batten("fair rough.off -o a.off --noise much").exit_code, 2);
  EXPECT_EQ(run_batten("fair rough.off -o a.off --noise -1").exit_code, 2);
  EXPECT_EQ(run_batten("fair rough.off").exit_code, 2);
  EXPECT_EQ(run_batten("fair missing.off -o a.off").exit_code, 3);
  EXPECT_EQ(run_batten("fair rough.off -o a.step").exit_code, 2);
  EXPECT_FALSE(file_exists("a.off"));
  // One triangle inside out: refused with the place named.
  write_file("turned.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 3 2\n");
  const auto run = run_batten("fair turned.off -o a.off");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("triangle"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace batten::test
