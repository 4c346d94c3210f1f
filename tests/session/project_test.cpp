#include "batten/session/project.hpp"

#include "../sketch/strokes.hpp"
#include "one_model.hpp"
#include "scratch.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/io/file.hpp"
#include "batten/io/zip_archive.hpp"
#include "batten/session/journal.hpp"

namespace batten {
namespace {

using namespace strokes;
using namespace test;

const std::string kProjects = BATTEN_EXAMPLES "/../tests/session/data";

Document sphere() {
  Document document = one_model();
  document.apply(UnitEdit{kModel, "mm"});
  document.apply(on_model(InsertEdit{circle(kO, kX, kY), {}}));
  document.apply(on_model(InsertEdit{circle(kO, kX, kZ), {}}));
  document.apply(on_model(InsertEdit{circle(kO, kY, kZ), {.sharpness = 0.5}}));
  document.apply(on_model(DeleteEdit{2}));
  document.apply(UndoEdit{});
  return document;
}

TEST(Project, ReadsBackBitForBitWithItsHistory) {
  const Document document = sphere();
  ProjectFile read = parse_project(format_project(document), "p.batten");
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_EQ(read.format, 2);
  EXPECT_EQ(read.document.unit(kModel), "mm");
  EXPECT_TRUE(read.document == document);
  EXPECT_EQ(format_project(read.document), format_project(document));
  ASSERT_TRUE(read.document.can_redo());
  read.document.apply(RedoEdit{});
  EXPECT_EQ(model_of(read.document).counts().curves, 2);
}

TEST(Project, FilesOfFormat1StillOpenWithTheirHistory) {
  ProjectFile read = read_project(kProjects + "/format_1.batten");
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_EQ(read.format, 1);
  EXPECT_EQ(read.document.object(kModel).name, "model");
  EXPECT_EQ(read.document.unit(kModel), "mm");
  EXPECT_EQ(model_of(read.document).counts().faces, 8);
  // What a session of format 1 was played into is what the project of format 1 holds.
  Document played;
  for (const SessionEdit& edit : read_session(kProjects + "/format_1.jsonl").edits) try {
      played.apply(edit.edit);
    } catch (const RefusedEdit&) {
    }
  EXPECT_TRUE(read.document == played);
  ASSERT_TRUE(read.document.can_redo());
  read.document.apply(RedoEdit{});  // the motion that was undone last
  played.apply(RedoEdit{});
  EXPECT_TRUE(read.document == played);
  const ProjectFile again = parse_project(format_project(read.document), "again.batten");
  EXPECT_EQ(again.format, 2);
  EXPECT_TRUE(again.document == read.document);
  EXPECT_TRUE(again.document.can_undo());
}

TEST(Project, LongListsAreEntriesAndEqualOnesAreHeldOnce) {
  TriangleMesh mesh;
  mesh.positions = Points::Random(50, 3);
  mesh.triangles = Triangles::Zero(40, 3);
  Document document;
  document.apply(AddEdit{{}, "mesh", "", std::make_shared<const TriangleMesh>(mesh)});
  const auto entries = parse_archive(format_project(document));
  // project.json and the line of the journal name the same two entries.
  ASSERT_EQ(entries.size(), 4u);
  EXPECT_EQ(entries.at("arrays/0.f64").size(), 50u * 3 * 8);
  EXPECT_EQ(entries.at("arrays/1.i32").size(), 40u * 3 * 4);
  for (const char* name : {"project.json", "journal.jsonl"})
    EXPECT_NE(entries.at(name).find(R"("positions":{"entry":"arrays/0.f64"})"), std::string::npos) << name;
  // Little-endian, row by row.
  double first = 0;
  std::memcpy(&first, entries.at("arrays/0.f64").data() + 8, sizeof first);
  EXPECT_EQ(first, mesh.positions(0, 1));
  // Short ones stay where they are.
  mesh.positions = Points::Random(21, 3);
  mesh.triangles = Triangles::Zero(21, 3);
  Document small;
  small.apply(AddEdit{{}, "mesh", "", std::make_shared<const TriangleMesh>(mesh)});
  EXPECT_EQ(parse_archive(format_project(small)).size(), 2u);
}

// The bytes of 0.5 are those of the integers 0 and 1071644672: lists of either kind are two entries.
TEST(Project, ListsOfEqualBytesAndOtherTypesAreHeldApart) {
  TriangleMesh halves, integers;
  halves.positions = Points::Zero(65, 3);
  integers.positions = Points::Zero(130, 3);
  halves.triangles = integers.triangles = Triangles(0, 3);
  halves.vertex_values["q"] = Eigen::VectorXd::Constant(65, 0.5);
  integers.vertex_values["q"] = Eigen::VectorXd::Zero(130);
  for (int k = 1; k < 130; k += 2) integers.vertex_values["q"](k) = 1071644672;
  Document document;
  for (const auto& [name, mesh] : {std::pair{"halves", halves}, std::pair{"integers", integers}})
    document.apply(AddEdit{{}, name, "", std::make_shared<const TriangleMesh>(mesh)});
  const ProjectFile read = parse_project(format_project(document), "p.batten");
  EXPECT_TRUE(read.document == document);
  EXPECT_EQ(std::get<SharedMesh>(*read.document.object({2}).content())->vertex_values.at("q").size(), 130);
}

TEST(Project, StoredObjectsHoldWhereTheJournalLeadsElsewhere) {
  auto entries = parse_archive(format_project(sphere()));
  std::string& journal = entries["journal.jsonl"];
  journal.erase(journal.rfind("{\"op\":\"undo\"}"));
  ProjectFile read = parse_project(format_archive(entries), "p.batten");
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("p.batten: its journal does not lead"), std::string::npos);
  EXPECT_TRUE(read.document == sphere());
  EXPECT_FALSE(read.document.can_undo());
  // From then on its own journal leads to it.
  EXPECT_TRUE(parse_project(format_project(read.document), "p.batten").warnings.empty());
}

TEST(Project, CutOffOrDamagedFilesAreToldAndNeverCrash) {
  const std::string bytes = format_project(sphere());
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, bytes.size() / 2, bytes.size() - 1})
    EXPECT_THROW(parse_project(bytes.substr(0, length), "p.batten"), FileError) << length;
  Random random(3);
  for (int k = 0; k < 60; ++k) {
    std::string damaged = bytes;
    damaged[random.below(bytes.size())] ^= static_cast<char>(1 + random.below(255));
    try {
      parse_project(damaged, "p.batten");  // a byte of a date or of a name of no account may differ
    } catch (const FileError&) {
    }
  }
}

TEST(Project, DamageWithinEntriesIsToldAndNeverCrashes) {
  const auto entries = parse_archive(format_project(sphere()));
  Random random(4);
  int n_refused = 0;
  for (int k = 0; k < 300; ++k) {
    auto damaged = entries;
    auto entry = damaged.begin();
    std::advance(entry, static_cast<std::ptrdiff_t>(random.below(damaged.size())));
    entry->second[random.below(entry->second.size())] ^= static_cast<char>(1 + random.below(255));
    try {
      parse_project(format_archive(damaged), "p.batten");
    } catch (const FileError& error) {
      EXPECT_EQ(error.path(), "p.batten");
      ++n_refused;
    }
  }
  EXPECT_GT(n_refused, 30);
  for (const char* missing : {"project.json", "journal.jsonl", "arrays/0.f64"}) {
    auto damaged = entries;
    damaged.erase(missing);
    EXPECT_THROW(parse_project(format_archive(damaged), "p.batten"), FileError) << missing;
  }
}

TEST(Project, WritingReplacesTheOldFileWhole) {
  const std::string path = scratch_file("p.batten");
  write_project(path, one_model());
  write_project(path, sphere());
  EXPECT_TRUE(read_project(path).document == sphere());
  EXPECT_THROW(write_project("/nonexistent/folder/p.batten", sphere()), FileError);
  // A link stays one, and what it leads to is replaced.
  const std::string link = scratch_file("link.batten");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(path, link);
  write_project(link, one_model());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(read_project(path).document == one_model());
}

}  // namespace
}  // namespace batten
