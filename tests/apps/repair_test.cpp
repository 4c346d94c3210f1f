#include "apps/run_batten.hpp"
#include "mesh/broken_shapes.hpp"
#include "sanitizers.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"

namespace batten::test {
namespace {

using Json = nlohmann::json;
using fixtures::beside;
using fixtures::box;
using fixtures::glued;
using fixtures::soup_of;
using fixtures::turned_at_random;

std::string off(const TriangleMesh& mesh) {
  std::string text = concat("OFF\n", mesh.n_vertices(), ' ', mesh.n_triangles(), " 0\n");
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    text += concat(exact_decimal(mesh.positions(v, 0)), ' ', exact_decimal(mesh.positions(v, 1)), ' ',
                   exact_decimal(mesh.positions(v, 2)), '\n');
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    text += concat("3 ", mesh.triangles(f, 0), ' ', mesh.triangles(f, 1), ' ', mesh.triangles(f, 2), '\n');
  return text;
}

TEST(RepairCommand, ReportsWhatWasDoneByKind) {
  write_file("soup.off", off(soup_of(turned_at_random(box(3)))));
  const auto run = run_batten("repair soup.off -o sound.off --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["done"]["welded_vertices"], 3 * 108 - 56);
  EXPECT_GT(json["done"]["turned_faces"], 0);
  EXPECT_EQ(json["done"]["doubled_faces"], 0);
  EXPECT_EQ(json["watertight"], true);
  EXPECT_NEAR(json["volume"].get<double>(), 1, 1e-12);
  EXPECT_EQ(json["flaws"].size(), 0U);
  EXPECT_EQ(json["written"], true);
  // What is mended has nothing left to mend, byte for byte.
  const auto again = run_batten("repair sound.off -o again.off");
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.out.find("nothing to repair"), std::string::npos);
  EXPECT_EQ(read_file("again.off"), read_file("sound.off"));
}

// Every command refuses what it cannot work with and names the remedy, which helps when it is followed; so
// does --repair.
TEST(RepairCommand, IsTheRemedyThatOtherCommandsName) {
  const TriangleMesh cube = box(3);
  TriangleMesh fin = cube;
  fin.positions.conservativeResize(cube.n_vertices() + 1, 3);
  fin.positions.row(cube.n_vertices()) << -1, -1, -1;
  const int a = cube.triangles(0, 0), b = cube.triangles(0, 1);
  fin = fixtures::with_triangles(fin, {{a, b, static_cast<int>(cube.n_vertices())}});
  const std::vector<std::pair<std::string, TriangleMesh>> broken = {
      {"turned", turned_at_random(cube)},
      {"edge", glued(beside(cube, box(3, {1, 1, 0})))},
      {"vertex", glued(beside(cube, box(3, {1, 1, 1})))},
      {"fin", fin},
      {"repeated", fixtures::with_triangles(cube, {{a, a, b}})},
      {"doubled", fixtures::with_triangles(cube, {{a, b, cube.triangles(0, 2)}})}};
  for (const auto& [name, mesh] : broken) {
    write_file(name + ".off", off(mesh));
    ASSERT_EQ(run_batten("repair " + name + ".off -o mended.off").exit_code, 0) << name;
    for (const std::string& command :
         {std::string("fair IN -o out.off --noise 0.1"), std::string("remesh IN -o out.off"),
          std::string("simplify IN -o out.off --remove 20%")}) {
      const auto with = [&](const std::string& path) {
        std::string line = command;
        return line.replace(line.find("IN"), 2, path);
      };
      if (test::kSanitized && name != "fin" && command.rfind("remesh", 0) != 0) continue;
      const auto refused = run_batten(with(name + ".off"));
      if (refused.exit_code != 0) {
        EXPECT_EQ(refused.exit_code, 3) << name << ": " << command;
        EXPECT_NE(refused.err.find("batten repair IN -o OUT"), std::string::npos) << refused.err;
      }
      const auto followed = run_batten(with("mended.off"));
      const auto at_once = run_batten(with(name + ".off") + " --repair");
      for (const auto& run : {followed, at_once}) {
        // The fin still touches the cube along an edge: its new triangles may cross those of the cube, which
        // is told.
        const bool crosses =
            name == "fin" && run.exit_code == 1 && run.err.find("that cross") != std::string::npos;
        EXPECT_TRUE(run.exit_code == 0 || crosses) << name << ": " << command << ": " << run.err;
      }
      EXPECT_NE(at_once.err.find("repaired:"), std::string::npos) << name << ": " << command;
    }
  }
}

TEST(RepairCommand, FillsHolesOnDemand) {
  TriangleMesh open = box(4);
  open.triangles.conservativeResize(open.n_triangles() - 2, 3);  // a corner of a face
  write_file("open.off", off(open));
  const auto left = run_batten("repair open.off -o left.off --json");
  EXPECT_EQ(Json::parse(left.out)["holes"][0]["edges"], 4);
  const auto few = run_batten("repair open.off -o few.off --fill-holes 3 --json");
  EXPECT_EQ(Json::parse(few.out)["done"]["holes_filled"], 0);
  const auto all = run_batten("repair open.off -o all.off --fill-holes all --json");
  EXPECT_EQ(Json::parse(all.out)["done"]["holes_filled"], 1);
  EXPECT_EQ(Json::parse(all.out)["watertight"], true);
}

// An unsound result never leaves with success, and never over a good file.
TEST(RepairCommand, KeepsTheOldFileWhereFlawsAreLeft) {
  write_file("crossing.off", off(beside(box(2), box(2, {0.5, 0.4, 0.3}))));
  write_file("good.off", "as it was");
  const auto refused = run_batten("repair crossing.off -o good.off");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find(" cross"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find(" at ("), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--accept-flaws"), std::string::npos) << refused.err;
  EXPECT_EQ(read_file("good.off"), "as it was");
  const auto accepted = run_batten("repair crossing.off -o good.off --accept-flaws --json");
  EXPECT_EQ(accepted.exit_code, 0) << accepted.err;
  EXPECT_GT(Json::parse(accepted.out)["crossings"].size(), 0U);
  EXPECT_NE(read_file("good.off"), "as it was");
}

TEST(RepairCommand, WeldsSoupsForOtherCommandsWithANote) {
  write_file("soup.off", off(soup_of(box(3))));
  const auto run = run_batten("remesh soup.off -o even.off --edge 0.3 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("were welded"), std::string::npos);
  EXPECT_NE(run_batten("info soup.off").out.find("batten repair IN -o OUT welds them"), std::string::npos);
}

TEST(RepairCommand, TellsBadUsageFromBadInput) {
  write_file("cube.off", off(box(1)));
  EXPECT_EQ(run_batten("repair cube.off -o a.off --weld much").exit_code, 2);
  EXPECT_EQ(run_batten("repair cube.off -o a.off --weld -1").exit_code, 2);
  EXPECT_EQ(run_batten("repair cube.off -o a.off --fill-holes 2").exit_code, 2);
  EXPECT_EQ(run_batten("repair cube.off -o a.step").exit_code, 2);
  EXPECT_EQ(run_batten("repair missing.off -o a.off").exit_code, 3);
  EXPECT_FALSE(file_exists("a.off"));
}

}  // namespace
}  // namespace batten::test
