#include "apps/run_batten.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

const char* kTetrahedron = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

bool is_png(const std::string& name) {
  return read_file(name).rfind("\x89PNG\r\n\x1a\n", 0) == 0;
}

TEST(RenderCommand, WritesOnePictureAndASheet) {
  write_file("t.off", kTetrahedron);
  const auto run =
      run_batten("render t.off -o one.png --shading isophotes --size 120x90 --view 30,20 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["width"], 120);
  EXPECT_EQ(json["height"], 90);
  EXPECT_TRUE(is_png("one.png"));
  EXPECT_EQ(
      run_batten("render t.off -o sheet.png --shading shaded,error --against t.off --size 200x90").exit_code,
      0);
  EXPECT_TRUE(is_png("sheet.png"));
}

TEST(RenderCommand, DrawsANetworkAloneAndUponAMesh) {
  write_file("t.off", kTetrahedron);
  write_file("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nl 1 2 3 1\n");
  EXPECT_EQ(run_batten("render n.obj -o n.png --shading porcupine --size 90x90").exit_code, 0);
  EXPECT_EQ(run_batten("render t.off -o m.png --network n.obj --size 90x90").exit_code, 0);
  EXPECT_TRUE(is_png("n.png"));
  EXPECT_TRUE(is_png("m.png"));
}

TEST(RenderCommand, TellsBadUsageFromBadInputAndLeavesNothingBehind) {
  write_file("t.off", kTetrahedron);
  write_file("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\n");
  for (const char* usage : {"render t.off", "render t.off -o p.jpg", "render t.off -o p.png --shading shiny",
                            "render t.off -o p.png --size 12", "render t.off -o p.png --size 99999x9",
                            "render t.off -o p.png --view sideways", "render t.off -o p.png --up w"})
    EXPECT_EQ(run_batten(usage).exit_code, 2) << usage;
  for (const char* input :
       {"render nowhere.off -o p.png", "render n.obj -o p.png --shading isophotes",
        "render t.off -o p.png --shading error", "render t.off -o p.png --shading porcupine",
        "render t.off -o p.png --network t.off", "render n.obj -o p.png --network n.obj",
        "render t.off -o p.png --normals given", "render t.off -o no/such/folder/p.png"}) {
    const auto run = run_batten(input);
    EXPECT_EQ(run.exit_code, 3) << input << run.err;
    EXPECT_EQ(run.err.rfind("batten: ", 0), 0U) << run.err;
  }
  EXPECT_FALSE(file_exists("p.png"));
}

}  // namespace
}  // namespace batten::test
