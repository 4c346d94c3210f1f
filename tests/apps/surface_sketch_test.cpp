#include "apps/run_batten.hpp"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// The edges of a cube as OBJ lines; every edge has vertices of its own, as drawing programs write them.
/// @param shorter the last edge ends this much before its corner.
/// @param shift of the whole cube along all axes. @param next number of its first vertex.
std::string cube_sketch(double shorter, double shift = 0, int next = 1) {
  std::string text;
  int edges = 0;
  for (int a = 0; a < 8; ++a)
    for (int axis = 0; axis < 3; ++axis) {
      if ((a & (1 << axis)) != 0) continue;
      const double reach = ++edges == 12 ? 1 - shorter : 1;
      for (int k = 0; k <= 10; ++k) {
        text += "v";
        for (int i = 0; i < 3; ++i)
          text += " " + std::to_string(shift + (i == axis             ? reach * k / 10
                                                : (a & (1 << i)) != 0 ? 1.0
                                                                      : 0.0));
        text += "\n";
        if (k > 0) text += "l " + std::to_string(next - 1) + " " + std::to_string(next) + "\n";
        ++next;
      }
    }
  return text;
}

Json surface(const std::string& arguments) {
  // Coarse samples where the step does not matter, so that a build with sanitizers is done soon.
  const bool has_step = arguments.find("--step") != std::string::npos;
  const Run run = run_batten("surface " + arguments + (has_step ? "" : " --step 4%") + " --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return Json::parse(run.out, nullptr, false);
}

// A cube: 12 strokes, 8 nodes, 6 patches, closed, no handle.
TEST(SurfaceOfSketch, ClosesACube) {
  write_file("cube.obj", cube_sketch(0));
  const Json json = surface("cube.obj -o cube.ply");
  EXPECT_EQ(json["strokes"], 12);
  EXPECT_EQ(json["nodes"], 8);
  EXPECT_EQ(json["segments"], 12);
  EXPECT_EQ(json["cycles"], 6);
  EXPECT_EQ(json["dangling_ends"], 0);
  EXPECT_EQ(json["near_misses"], 0);
  EXPECT_EQ(json["components"], 1);
  EXPECT_EQ(json["genus"], 0);
  EXPECT_EQ(json["watertight"], true);
  EXPECT_TRUE(file_exists("cube.ply"));
}

// What a file of strokes amounts to is counted alike by the commands that look at it; what is stored there
// (twelve curves that share no vertex) is told as well.
TEST(SurfaceOfSketch, IsCountedAlikeByInfoAndConvert) {
  write_file("counted.obj", cube_sketch(0.03));
  const Json made = surface("counted.obj -o counted.ply");
  const Json info = Json::parse(run_batten("info counted.obj --json").out, nullptr, false);
  for (const char* count :
       {"strokes", "nodes", "segments", "cycles", "components", "genus", "dangling_ends", "near_misses"})
    EXPECT_EQ(info[count], made[count]) << count;
  EXPECT_EQ(info["stored"]["components"], 12);
  EXPECT_EQ(info["curves"], 12);
  const Json converted =
      Json::parse(run_batten("convert counted.obj counted.json --sketch --json").out, nullptr, false);
  for (const char* count : {"strokes", "nodes", "segments", "cycles", "components"})
    EXPECT_EQ(converted[count], made[count]) << count;
  // The network that was written has normals, and the same patches by them.
  const Json network = Json::parse(run_batten("info counted.json --json").out, nullptr, false);
  EXPECT_EQ(network["normals"], true);
  for (const char* count : {"nodes", "segments", "cycles", "components"})
    EXPECT_EQ(network[count], made[count]) << count;
  EXPECT_EQ(run_batten("convert counted.json again.json --sketch").exit_code, 3);
}

// The last edge stops 0.03 short of its corner, 1.7 % of the diameter: a near miss, named and mended.
// Stopping 0.3 short it dangles, and what is left of it is left out: two faces become one, with 11 curves
// around.
TEST(SurfaceOfSketch, NamesEndsThatMeetNothing) {
  write_file("near.obj", cube_sketch(0.03));
  Json json = surface("near.obj -o near.ply");
  EXPECT_EQ(json["near_misses"], 1);
  EXPECT_EQ(json["dangling_ends"], 0);
  EXPECT_EQ(json["extended_ends"], 1);
  EXPECT_EQ(json["cycles"], 6);
  bool named = false;
  for (const Json& finding : json["diagnosis"])
    named = named ||
            (finding["defect"] == "near miss" && std::abs(finding["distance"].get<double>() - 0.03) < 1e-6);
  EXPECT_TRUE(named) << json["diagnosis"];
  write_file("dangling.obj", cube_sketch(0.3));
  json = surface("dangling.obj -o dangling.ply");
  EXPECT_EQ(json["dangling_ends"], 1);
  EXPECT_EQ(json["left_out"], 1);
  EXPECT_EQ(json["cycles"], 5);
  EXPECT_EQ(json["genus"], 0);
}

/// Arcs of three circles of a ball, with gaps between them, that miss each other.
std::string ball_sketch() {
  std::string text;
  int next = 1;
  for (int axis = 0; axis < 3; ++axis)
    for (int arc = 0; arc < 3; ++arc)
      for (int k = 0; k <= 30; ++k) {
        const double a = 2.0944 * (arc + 0.85 * k / 30 + 0.11 * axis);
        double x[3] = {0.004 * arc, 0.003 * axis, -0.004 * arc};
        x[(axis + 1) % 3] += std::cos(a);
        x[(axis + 2) % 3] += std::sin(a);
        text += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
        if (k > 0) text += "l " + std::to_string(next - 1) + " " + std::to_string(next) + "\n";
        ++next;
      }
  return text;
}

TEST(SurfaceOfSketch, ClosesStrokesThatDoNotMeet) {
  write_file("ball.obj", ball_sketch());
  const Json json = surface("ball.obj -o ball.ply --edge-length 4%");
  EXPECT_EQ(json["topology"], "implicit");
  EXPECT_EQ(json["cycles_area"], 0);
  EXPECT_EQ(json["watertight"], true);
  EXPECT_EQ(json["genus"], 0);
  EXPECT_FALSE(json["doubt"].get<std::string>().empty());
  EXPECT_LT(json["stroke_distance_p95"], 0.005);
  EXPECT_NE(json["warnings"].dump().find("--topology cycles"), std::string::npos);
  EXPECT_EQ(surface("ball.obj -o ball.ply --edge-length 4% --topology implicit")["faces"], json["faces"]);
}

TEST(SurfaceOfSketch, TakesCyclesWhereTheyAreSureOrAskedFor) {
  write_file("cube.obj", cube_sketch(0));
  const Json json = surface("cube.obj -o cube.ply");
  EXPECT_EQ(json["topology"], "cycles");
  EXPECT_FALSE(json.contains("doubt"));
  EXPECT_EQ(surface("cube.obj -o cube.ply --closed yes")["topology"], "cycles");
  write_file("ball.obj", ball_sketch());
  // By cycles alone nothing is closed that is open, and CAD faces are made of patches.
  for (const char* options : {"-o ball.ply --closed no", "-o ball.ply --topology cycles"}) {
    const auto run = run_batten(std::string("surface ball.obj --json ") + options);
    const Json result = Json::parse(run.out, nullptr, false);
    EXPECT_FALSE(result.value("topology", "cycles") == "implicit") << run.out;
  }
  EXPECT_EQ(run_batten("surface ball.obj -o ball.step --topology implicit").exit_code, 2);
  EXPECT_EQ(run_batten("surface ball.obj -o ball.ply --topology implicit --closed no").exit_code, 2);
}

// The options reach their places; lengths may be relative or in the unit of the file.
TEST(SurfaceOfSketch, TakesItsOptions) {
  write_file("gap.obj", cube_sketch(0.03));
  EXPECT_EQ(surface("gap.obj -o gap.ply --reach none")["cycles"], 5);
  EXPECT_EQ(surface("gap.obj -o gap.ply --reach none --weld 0.04")["cycles"], 6);
  const Json fine = surface("gap.obj -o gap.ply --step 0.02"),
             coarse = surface("gap.obj -o gap.ply --step 6%");
  EXPECT_GT(fine["vertices"].get<int>(), 4 * coarse["vertices"].get<int>());
  EXPECT_EQ(run_batten("surface gap.obj -o gap.ply --weld nonsense").exit_code, 2);
  EXPECT_EQ(run_batten("surface gap.obj -o gap.ply --weld 0").exit_code, 3);  // strokes never share vertices
  EXPECT_EQ(run_batten("surface gap.obj -o gap.ply --step -1").exit_code, 2);
}

// A lone line has no patch: bad input, in words.
TEST(SurfaceOfSketch, SaysWhyThereIsNothingToSurface) {
  write_file("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\n");
  const auto run = run_batten("surface line.obj -o line.ply");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("no closed cycle"), std::string::npos) << run.err;
  EXPECT_FALSE(file_exists("line.ply"));
  write_file("dot.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nl 1 2 3\n");
  for (const char* topology : {"auto", "cycles", "implicit"}) {
    const auto dot = run_batten(std::string("surface dot.obj -o dot.ply --topology ") + topology);
    EXPECT_EQ(dot.exit_code, 3);
    EXPECT_NE(dot.err.find("no extent"), std::string::npos) << dot.err;
  }
  // Parallel lines in a plane go around nothing, however many.
  write_file(
      "lines.obj",
      "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\nv 0 1 0\nv 1 1 0\nv 2 1 0\nl 4 5 6\nv 0 2 0\nv 1 2 0\nv 2 2 "
      "0\nl 7 8 9\n");
  const auto lines = run_batten("surface lines.obj -o lines.ply");
  EXPECT_EQ(lines.exit_code, 3);
  EXPECT_NE(lines.err.find("no closed cycle"), std::string::npos) << lines.err;
  EXPECT_NE(run_batten("surface lines.obj -o lines.ply --topology implicit").err.find("in a plane"),
            std::string::npos);
}

// No curve of the one cube touches the other, but their faces cross: the work failed, places are named, and
// the file that was there stays, unless flaws are accepted.
TEST(SurfaceOfSketch, LeavesTheOldFileWhereTheSurfaceCrossesItself) {
  write_file("two.obj", cube_sketch(0) + cube_sketch(0, 0.5, 133));
  write_file("two.ply", "as it was");
  const auto refused = run_batten("surface two.obj -o two.ply --step 8% --topology cycles --json");
  EXPECT_EQ(refused.exit_code, 1);
  for (const char* words : {"the surface is not sound", " cross in patches ", " at (", "--accept-flaws"})
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
  EXPECT_EQ(read_file("two.ply"), "as it was");
  const Json json = Json::parse(refused.out, nullptr, false);
  EXPECT_EQ(json["written"], false);
  EXPECT_EQ(json["flaws"].size(), 1U) << json["flaws"];
  EXPECT_EQ(run_batten("surface two.obj -o two.step --step 8%").exit_code, 1);
  EXPECT_FALSE(file_exists("two.step"));
  const Json accepted = surface("two.obj -o two.ply --step 8% --topology cycles --accept-flaws");
  EXPECT_EQ(accepted["written"], true);
  EXPECT_GT(accepted["self_intersections"], 0);
  EXPECT_NE(read_file("two.ply"), "as it was");
}

// The sketches as they are: 20 patches of the trebol, the hole of the torus, and a surface of each of the
// others.
TEST(SurfaceOfSketch, TakesPublicSketches) {
  const std::string folder = std::string(BATTEN_SHARED_DATA) + "/curves/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is missing";
  const Json trebol = surface(folder + "sketch_trebol_flowrep.obj -o trebol.ply");
  EXPECT_EQ(trebol["cycles"], 20);
  EXPECT_EQ(trebol["watertight"], true);
  const Json torus = surface(folder + "sketch_torus.obj -o torus.ply");
  EXPECT_EQ(torus["cycles"], 16);
  EXPECT_EQ(torus["genus"], 1);
  for (const char* name : {"bathtub", "box", "car", "dress", "gamepad", "guitar", "spherecylinder"}) {
    const std::string file = std::string(name) + ".ply";
    const Json json = surface(folder + "sketch_" + name + ".obj --accept-flaws -o " + file);
    EXPECT_GT(json["faces"].get<int>(), 100) << name;
    EXPECT_TRUE(file_exists(file));
  }
}

}  // namespace
}  // namespace batten::test
