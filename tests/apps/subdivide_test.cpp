#include "apps/run_json.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

// [−1, 1]³ with a sharp edge.
const char* const kCube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST(SubdivideCommand, TakesEverySchemeAndFormat) {
  write_file("cube.obj", kCube);
  for (const char* options :
       {"-o out.ply", "-o out.obj --scheme nuliss", "-o out.off --scheme nulissmod --knots 1",
        "-o out.ply --scheme linear", "-o out.ply --scheme nulissmod,catmull-clark", "-o out.ply --limit",
        "-o out.stl --corners smooth", "-o out.ply --scheme nuliss --limit --knots 0"}) {
    const Json json = run_json(std::string("subdivide cube.obj --levels 3 ") + options);
    EXPECT_EQ(json["faces"], 384) << options;
    EXPECT_EQ(json["vertices"], 386) << options;
    EXPECT_EQ(json["genus"], 0) << options;
    EXPECT_EQ(json["boundary_loops"], 0) << options;
    EXPECT_TRUE(json["seconds"].contains("total"));
  }
  EXPECT_EQ(run_json("info out.ply")["genus"], 0);
  EXPECT_EQ(run_json("subdivide cube.obj -o same.obj --levels 0")["faces"], 6);
}

// Sharpness left over is written and read again.
TEST(SubdivideCommand, HandsSharpnessOnInObjFiles) {
  write_file("crease.obj", std::string(kCube) + "t crease 2/1/0 4 5 3\nt corner 1/1/0 0 10\n");
  EXPECT_EQ(run_json("subdivide crease.obj -o once.obj --levels 1")["sharp_edges"], 1);
  const Json json = run_json("subdivide once.obj -o twice.obj --levels 1");
  EXPECT_EQ(json["sharp_edges"], 2);
  EXPECT_EQ(json["sharp_vertices"], 1);
  EXPECT_NE(read_file("twice.obj").find("t crease 2/1/0"), std::string::npos);
}

TEST(SubdivideCommand, WritesStep) {
  write_file("cube.obj", kCube);
  const auto run = run_batten("subdivide cube.obj --step cube.step --unit mm --json");
  if (run.err.find("has no Open Cascade") != std::string::npos) {
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_NE(run.err.find("tools/setup step && tools/build program"), std::string::npos) << run.err;
    GTEST_SKIP() << run.err;
  }
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["step"]["patches"], 6);
  EXPECT_EQ(json["step"]["solids"], 1);
  EXPECT_EQ(json["step"]["closed"], true);
  EXPECT_LE(json["step"]["relative_deviation"].get<double>(), 1e-5);
  EXPECT_EQ(read_file("cube.step").substr(0, 13), "ISO-10303-21;");
}

TEST(SubdivideCommand, TellsUsageFromInput) {
  write_file("cube.obj", kCube);
  EXPECT_EQ(run_batten("subdivide cube.obj").exit_code, 2) << "no output";
  EXPECT_EQ(run_batten("subdivide cube.obj -o x.ply --scheme loop").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj -o x.ply --levels 13").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj -o x.ply --knots 2").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj --step x.step --scheme nuliss").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj --step x.step --unit parsec").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj --step x.step --step-tolerance 0").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj -o x.xyz").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide cube.obj --step x.dwg").exit_code, 2);
  EXPECT_EQ(run_batten("subdivide missing.obj -o x.ply").exit_code, 3);
  write_file("turned.obj", std::string(kCube) + "f 1 2 3 4\n");
  const auto run = run_batten("subdivide turned.obj -o x.ply");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("belongs to"), std::string::npos) << run.err;
  EXPECT_FALSE(file_exists("x.ply"));
}

}  // namespace
}  // namespace batten::test
