#include "batten/session/project.hpp"

#include "../sketch/strokes.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/session/edit_json.hpp"

namespace batten {
namespace {

using namespace strokes;

Project sphere() {
  Project project;
  project.unit = "mm";
  project.document.apply(InsertEdit{circle(kO, kX, kY), {}});
  project.document.apply(InsertEdit{circle(kO, kX, kZ), {}});
  project.document.apply(InsertEdit{circle(kO, kY, kZ), {.sharpness = 0.5}});
  project.document.apply(DeleteEdit{2});
  project.document.apply(UndoEdit{});
  return project;
}

TEST(Project, ReadsBackBitForBitWithItsHistory) {
  const Project project = sphere();
  std::vector<std::string> warnings;
  Project read = parse_project(format_project(project), "p.batten", &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(read.unit, "mm");
  EXPECT_TRUE(read.document.mesh() == project.document.mesh());
  EXPECT_EQ(format_project(read), format_project(project));
  ASSERT_TRUE(read.document.can_redo());
  read.document.apply(RedoEdit{});
  EXPECT_EQ(read.document.mesh().counts().curves, 2);
}

TEST(Project, CutOffOrDamagedFilesAreToldAndNeverCrash) {
  const std::string bytes = format_project(sphere());
  for (const size_t length : {size_t{0}, size_t{10}, bytes.size() / 2, bytes.size() - 1})
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

}  // namespace
}  // namespace batten
