#include "experiments/thesis_run.hpp"

#include "scratch.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::experiments {
namespace {

ThesisExperiment passes(const std::string& id) {
  return {{id}, [id](ThesisRun& run) {
            ThesisRow row;
            row.id = id;
            row.decide(true);
            run.add(std::move(row));
          }};
}

std::vector<std::string> ids(const std::vector<ThesisRow>& rows) {
  std::vector<std::string> found;
  for (const ThesisRow& row : rows) found.push_back(row.id + " " + verdict_text(row));
  return found;
}

ThesisResult made(const std::vector<ThesisExperiment>& experiments, const ThesisOptions& options = {},
                  const RowsDone& done = {}) {
  const Progress silent;
  return ThesisRun(options, silent).run(experiments, done);
}

using Ids = std::vector<std::string>;

// Numbers, not letters: 2.10 comes after 2.9. Rows of one number stay as given.
TEST(ThesisRun, OrdersRowsByTheirNumbers) {
  EXPECT_EQ(ids(made({passes("S 4.1"), passes("S 3.10 b"), passes("S 3.9"), passes("S 3.10 a")}).rows),
            (Ids{"S 3.9 pass", "S 3.10 b pass", "S 3.10 a pass", "S 4.1 pass"}));
}

TEST(ThesisRun, MakesOnlyRowsThatAreAskedFor) {
  int runs = 0;
  const ThesisExperiment both = {{"S 3.18", "S 5.17"}, [&](ThesisRun& run) {
                                   ++runs;
                                   EXPECT_FALSE(run.wants("S 3.18"));
                                   for (const char* id : {"S 3.18", "S 5.17"}) passes(id).work(run);
                                 }};
  const ThesisExperiment never = {{"S 3.9"}, [](ThesisRun&) { FAIL() << "nobody asked for it"; }};
  EXPECT_EQ(ids(made({never, both}, {.rows = {"5.17"}}).rows), Ids{"S 5.17 pass"});
  EXPECT_EQ(ids(made({never, passes("S 5.2")}, {.rows = {"S 5"}}).rows), Ids{"S 5.2 pass"});
  EXPECT_EQ(runs, 1);
  EXPECT_TRUE(made({never}, {.rows = {"9"}}).rows.empty());
}

// A refusal inside an experiment is a row that fails with its sentence; the others are made.
TEST(ThesisRun, GoesOnAfterARefusal) {
  const ThesisExperiment half = {{"S 1.1", "S 1.2"}, [](ThesisRun& run) {
                                   passes("S 1.1").work(run);
                                   throw InvalidInput("the mesh has no triangles");
                                 }};
  const ThesisResult result = made({half, passes("S 1.3")});
  EXPECT_EQ(ids(result.rows), (Ids{"S 1.1 pass", "S 1.2 fail", "S 1.3 pass"}));
  EXPECT_EQ(result.rows[1].remark, "the mesh has no triangles");
  EXPECT_EQ(result.warnings.size(), 1U);
  const ThesisExperiment forgets = {{"S 2.1"}, [](ThesisRun&) {}};
  EXPECT_EQ(ids(made({forgets}).rows), Ids{"S 2.1 fail"}) << "no row is missing from the page";
}

TEST(ThesisRun, DoesNotHideBrokenFilesNorCancelling) {
  EXPECT_THROW(made({{{"S 1.1"}, [](ThesisRun&) { throw FileError("a.off", 3, "no number"); }}}), FileError);
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(ThesisRun({}, stop).run({passes("S 1.1")}, {}), Cancelled);
}

// The page is written after each experiment: rows so far, and what is to come.
TEST(ThesisRun, TellsRowsAsTheyAreMade) {
  std::vector<std::pair<std::size_t, std::size_t>> told;
  const ThesisResult result = made({passes("S 1.2"), passes("S 1.1")}, {}, [&](const ThesisResult& so_far) {
    told.emplace_back(so_far.rows.size(), so_far.to_come.size());
  });
  EXPECT_EQ(told, (std::vector<std::pair<std::size_t, std::size_t>>{{1, 1}, {2, 0}}));
  EXPECT_TRUE(result.to_come.empty());
}

TEST(ThesisRun, TakesTwentySeedsOrFive) {
  const Progress silent;
  for (const bool quick : {false, true}) {
    ThesisRun run({.quick = quick}, silent);
    const std::vector<int> seeds = run.for_seeds([](int seed) { return 10 * seed; });
    ASSERT_EQ(seeds.size(), quick ? 5U : 20U);
    for (std::size_t i = 0; i < seeds.size(); ++i) EXPECT_EQ(seeds[i], 10 * (static_cast<int>(i) + 1));
  }
}

TEST(ThesisRun, FindsMeshesUnderTheUsualNames) {
  const std::string folder = test::scratch() + "/data";
  std::filesystem::create_directories(folder + "/meshes");
  std::ofstream(folder + "/meshes/cube_hole.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const Progress silent;
  ThesisRun run({.data = folder}, silent);
  std::string path;
  const TriangleMesh* mesh = run.mesh("cube-hole", &path);
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(mesh->n_triangles(), 1);
  EXPECT_EQ(path, folder + "/meshes/cube_hole.off");
  EXPECT_EQ(run.mesh("cube-hole"), mesh) << "read once";
  EXPECT_EQ(run.mesh("igea"), nullptr);
  EXPECT_EQ(run.file("meshes/cube_hole.off"), path);
  EXPECT_FALSE(ThesisRun({}, silent).file("meshes/cube_hole.off")) << "without a folder there is nothing";
}

}  // namespace
}  // namespace batten::experiments
