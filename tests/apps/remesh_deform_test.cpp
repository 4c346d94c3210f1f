#include "apps/run_json.hpp"

#include <cmath>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// A flat square of n × n squares over the unit square.
std::string square(int n) {
  std::ostringstream off;
  off << "OFF\n" << (n + 1) * (n + 1) << ' ' << 2 * n * n << " 0\n";
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) off << i / double(n) << ' ' << j / double(n) << " 0\n";
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      off << "3 " << a << ' ' << b << ' ' << b + 1 << "\n3 " << a << ' ' << b + 1 << ' ' << a + 1 << '\n';
    }
  return off.str();
}

const char* const kHandles =
    R"({"fixed": {"box": [[-1, -1, -1], [0.15, 2, 1]]},
        "handles": [{"select": {"box": [[0.85, -1, -1], [2, 2, 1]]}, "translate": [0, 0, 0.3],
                     "rotate_deg": [0, 1, 0, 50], "about": [1, 0, 0]}]})";

// The line of the issue with every option; the five measures of H, table 2.3, are there.
TEST(Remesh, TakesEveryOption) {
  write_file("square.off", square(12));
  for (const char* method : {"ar", "lf"}) {
    const Json json =
        run_json(std::string("remesh square.off -o new.ply --edge 5% --adaptivity 0.5 --keep-edges "
                             "40deg --iterations 4 --method ") +
                 method);
    for (const char* key :
         {"vertices", "faces", "curvature_change", "edge_variance_change", "area_variance_change",
          "curvature_variance_change", "mean_distance", "normal_error_deg"})
      EXPECT_TRUE(json.contains(key)) << key;
    // Flat before, flat after.
    EXPECT_LT(json["normal_error_deg"].get<double>(), 1e-6);
    EXPECT_LT(json["mean_distance"].get<double>(), 1e-12);
    EXPECT_EQ(json["corners"], 4);
  }
  EXPECT_NEAR(run_json("remesh square.off -o new.obj --vertices 500")["vertices"].get<double>(), 500, 40);
}

TEST(Remesh, TellsBadUsageAndBadInputApart) {
  write_file("square.off", square(4));
  for (const char* usage : {"--edge 0", "--edge 5% --vertices 100", "--adaptivity 2", "--keep-edges 0deg",
                            "--keep-edges 200deg", "--keep-border no", "--method best", "--vertices 1"})
    EXPECT_EQ(run_batten(std::string("remesh square.off -o bad.ply ") + usage).exit_code, 2) << usage;
  EXPECT_EQ(run_batten("remesh square.off -o bad.xyz").exit_code, 2);
  EXPECT_EQ(run_batten("remesh square.off -o bad.ply --sizes none").exit_code, 3);
  EXPECT_EQ(run_batten("remesh square.off -o bad.ply --edge 1e-9").exit_code, 3);
  write_file("turned.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 2 0 3\n3 0 2 3\n");
  EXPECT_EQ(run_batten("remesh turned.off -o bad.ply").exit_code, 3);
  EXPECT_FALSE(file_exists("bad.ply"));
}

/// A rod of 16 sides as CAD programs export it: 32 vertices.
std::string rod() {
  const double step = std::acos(-1.0) / 8;
  std::ostringstream off;
  off << "OFF\n32 60 0\n";
  for (const int z : {0, 10})
    for (int i = 0; i < 16; ++i) off << std::cos(i * step) << ' ' << std::sin(i * step) << ' ' << z << '\n';
  for (int i = 0; i < 16; ++i) {
    const int j = (i + 1) % 16;
    off << "3 " << i << ' ' << j << ' ' << 16 + j << "\n3 " << i << ' ' << 16 + j << ' ' << 16 + i << '\n';
  }
  for (int i = 1; i < 15; ++i)
    off << "3 0 " << i + 1 << ' ' << i << "\n3 16 " << 16 + i << ' ' << 17 + i << '\n';
  return off.str();
}

// A result that misses what was asked for is exit 1, says why, and leaves the old file; --accept-flaws writes
// it.
TEST(Remesh, DoesNotWriteWhatMissesTheWantedEdge) {
  write_file("rod.off", rod());
  const Json good = run_json("remesh rod.off -o rod_new.off --edge 0.2");
  EXPECT_TRUE(good["faceted"]);
  EXPECT_TRUE(good["flaws"].empty());
  EXPECT_NEAR(good["mean_edge"].get<double>(), 0.2, 0.04);
  write_file("kept.off", "old");
  const auto bad = run_batten("remesh rod.off -o kept.off --edge 6");  // no triangle is as long
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_NE(bad.err.find("mean edge"), std::string::npos) << bad.err;
  EXPECT_EQ(read_file("kept.off"), "old");
  const Json accepted = run_json("remesh rod.off -o kept.off --edge 6 --accept-flaws");
  EXPECT_EQ(accepted["flaws"].size(), 1U);
  EXPECT_EQ(accepted["warnings"].size(), 1U);
  EXPECT_NE(read_file("kept.off"), "old");
}

// Two fans that touch in one vertex are taken apart, and that is told.
TEST(Remesh, WarnsOfVerticesThatWereTakenApart) {
  write_file("touch.off", "OFF\n5 2 0\n0 0 0\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n3 0 1 2\n3 0 3 4\n");
  const Json json = run_json("remesh touch.off -o apart.ply");
  ASSERT_EQ(json["warnings"].size(), 1U);
  EXPECT_NE(json["warnings"][0].get<std::string>().find("vertices added: 1"), std::string::npos);
}

TEST(Deform, TakesEveryOption) {
  write_file("square.off", square(12));
  write_file("handles.json", kHandles);
  for (const char* energy : {"stretch", "bend", "combined", "total"})
    for (const char* detail : {"none", "shape-matching", "gauss-newton"}) {
      const Json json =
          run_json(std::string("deform square.off -o bent.ply --handles handles.json --iterations 30 "
                               "--energy ") +
                   energy + " --nonlinear " + detail);
      EXPECT_EQ(json["fixed"], 26);
      EXPECT_EQ(json["moved"], 26);
    }
  run_json("deform square.off -o soft.ply --handles handles.json --soft 10");
  EXPECT_TRUE(run_json("deform square.off -o two.ply --handles handles.json --multiresolution")
                  .contains("base_vertices"));
}

TEST(Deform, TellsBadUsageAndBadInputApart) {
  write_file("square.off", square(4));
  write_file("handles.json", kHandles);
  write_file("nothing.json", R"({"handles": []})");
  for (const char* usage : {"--energy most", "--nonlinear some", "--soft -1", "--iterations 0"})
    EXPECT_EQ(
        run_batten(std::string("deform square.off -o bad.ply --handles handles.json ") + usage).exit_code, 2)
        << usage;
  EXPECT_EQ(run_batten("deform square.off -o bad.ply").exit_code, 2);
  EXPECT_EQ(run_batten("deform square.off -o bad.ply --handles nothing.json").exit_code, 3);
  EXPECT_EQ(run_batten("deform square.off -o bad.ply --handles missing.json").exit_code, 3);
  EXPECT_EQ(run_batten("deform square.off -o bad.xyz --handles handles.json").exit_code, 2);
  EXPECT_FALSE(file_exists("bad.ply"));
  // All vertices moved: nothing is left to solve for, and the answer is the motion itself.
  write_file("all.json",
             R"({"handles": [{"select": {"box": [[-9, -9, -9], [9, 9, 9]]}, "translate": [0, 0, 1]}]})");
  EXPECT_EQ(run_json("deform square.off -o all.ply --handles all.json")["fixed"], 0);
}

}  // namespace
}  // namespace batten::test
