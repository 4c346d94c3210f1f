#include "batten/session/journal.hpp"

#include "../sketch/strokes.hpp"
#include "scratch.hpp"

#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "batten/io/file.hpp"
#include "batten/session/edit_json.hpp"

namespace batten {
namespace {

using namespace strokes;

std::vector<Edit> one_of_each() {
  const Points square = polygon({kO, kX, kX + kY, kY, kO}, 1);
  MirrorEdit mirror;
  mirror.curve = 4;
  mirror.axis = polygon({kO, kX}, 1);
  MirrorEdit drawn_mirror;
  drawn_mirror.stroke.points = square;
  return {
      InsertEdit{{square, true}, {.snap = 0.1, .sharpness = 0.25, .into = Into::Opening}},
      DeleteEdit{3},
      SharpnessEdit{2, 1.0 / 3, std::array<int, 2>{4, 5}},
      mirror,
      drawn_mirror,
      HoleEdit{{square, false}, {}},
      GlueEdit{{square, false}, {square, false}, std::array<int, 2>{4, 7}, {}},
      SkinEdit{
          {{square, false}, {square, true}}, {DrawnStroke{square, false}, DrawnStroke{square, false}}, {}},
      AlignEdit{2, {square, false}},
      TransformEdit{Eigen::Matrix4d::Constant(0.1)},
      UndoEdit{},
      RedoEdit{}};
}

TEST(EditJson, EveryEditReadsBackAsItWasWritten) {
  for (const Edit& edit : one_of_each()) {
    const std::string line = format_edit(edit);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(format_edit(parse_edit(line)), line);
  }
  const auto sharpness =
      std::get<SharpnessEdit>(parse_edit(format_edit(SharpnessEdit{2, 1.0 / 3, std::array<int, 2>{4, 5}})));
  EXPECT_EQ(sharpness.value, 1.0 / 3);  // bit for bit
}

TEST(EditJson, MistakesAreNamed) {
  const auto message = [](const std::string& line) -> std::string {
    try {
      parse_edit(line);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& line, const std::string& part) {
    EXPECT_NE(message(line).find(part), std::string::npos) << line << ": " << message(line);
  };
  expect("{}", "no \"op\"");
  expect("[1]", "not a JSON object");
  expect("{\"op\":", "not JSON");
  expect(R"({"op":"cut"})", "no op \"cut\"; the ops are insert");
  expect(R"({"op":"insert"})", "needs the field \"points\"");
  expect(R"({"op":"insert","points":[[0,0]]})", "point 0 is [0,0]");
  expect(R"({"op":"insert","points":[[0,0,NaN]]})", "NaN");
  expect(R"({"op":"insert","points":[[0,0,1e999]]})", "finite");
  expect(R"({"op":"insert","points":[],"snpa":1})", "no field \"snpa\"; it takes op, points, closed, snap");
  expect(R"({"op":"insert","points":[],"into":"side"})", "\"auto\", \"face\" or \"opening\"");
  expect(R"({"op":"delete","curve":3})", "the id of a curve");
  expect(R"({"op":"delete","curve":"v3"})", "the id of a curve");
  expect(R"({"op":"transform","matrix":[1,2,3]})", "16 numbers");
  expect(R"({"op":"skin","profiles":[],"spines":[]})", "two objects");
  // Depth and length have no bound in a file; sentences have.
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  expect(R"({"op":"insert","points":)" + deep + "}", "point 0 is a list of 1");
  std::string wide = "0";
  for (int k = 0; k < 100000; ++k) wide += ",0";
  expect(R"({"op":"insert","points":[[)" + wide + "]]}", "point 0 is a list of 100001");
}

TEST(Session, ErrorsCarryTheLine) {
  const std::string header = "{\"batten_session\":1,\"unit\":\"mm\"}\n";
  EXPECT_EQ(parse_session(header, "s").unit, "mm");
  const auto line_of = [](const std::string& text) {
    try {
      parse_session(text, "s.jsonl");
    } catch (const FileError& error) {
      return error.line();
    }
    return -1L;
  };
  EXPECT_EQ(line_of(""), 0);
  EXPECT_EQ(line_of("{\"op\":\"undo\"}\n"), 1);
  EXPECT_EQ(line_of("{\"batten_session\":2}\n"), 1);
  EXPECT_EQ(line_of(header + "\n{\"op\":\"undo\"\n{\"op\":\"undo\"}\n"), 3);
  EXPECT_EQ(line_of(header + "{\"op\":\"undo\"}\n{\"op\":\"cut\"}\n"), 3);
}

TEST(Session, UnfinishedLastLineIsToldAndPassedOver) {
  const std::string text =
      "{\"batten_session\":1,\"unit\":\"m\"}\n{\"op\":\"undo\"}\n{\"op\":\"delete\",\"curve\":\"c1\"}";
  EXPECT_EQ(parse_session(text, "s").edits.size(), 2u);  // whole, without an end of line
  EXPECT_FALSE(parse_session(text, "s").torn);
  const size_t second = text.rfind('\n') + 1;
  for (size_t length = second + 1; length < text.size(); ++length) {
    const Session session = parse_session(text.substr(0, length), "s");
    EXPECT_TRUE(session.torn);
    EXPECT_EQ(session.torn_line, 3);
    EXPECT_EQ(session.edits.size(), 1u);
  }
}

TEST(Journal, ContinuesAfterATornLine) {
  const std::string path = test::scratch_file("torn.jsonl");
  {
    Journal journal(path, "mm");
    journal.write(InsertEdit{circle(kO, kX, kY), {}});
  }
  std::ofstream(path, std::ios::app) << "{\"op\":\"ins";
  {
    Journal journal(path);
    journal.write(UndoEdit{});
  }
  const Session session = read_session(path);
  EXPECT_EQ(session.unit, "mm");
  EXPECT_FALSE(session.torn);
  ASSERT_EQ(session.edits.size(), 2u);
  EXPECT_EQ(name_of_op(session.edits[1].edit), "undo");
}

TEST(Journal, KilledProcessLosesAtMostTheEditInFlight) {
  // A child confirms edits through a pipe and is killed without warning; whatever it confirmed is on the
  // disk.
  const std::string path = test::scratch_file("killed.jsonl");
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    Journal journal(path);
    Document document;
    for (int k = 0;; ++k) {
      const Edit edit =
          k == 0 ? Edit(InsertEdit{circle(kO, kX, kY), {}}) : Edit(SharpnessEdit{0, (k % 100) / 100.0, {}});
      document.apply(edit, [&](const Edit& done) { journal.write(done); });
      if (write(pipe_ends[1], "x", 1) != 1) _exit(1);
    }
  }
  char byte = 0;
  size_t confirmed = 0;
  while (confirmed < 20 && read(pipe_ends[0], &byte, 1) == 1) ++confirmed;
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(pipe_ends[1]);
  while (read(pipe_ends[0], &byte, 1) == 1) ++confirmed;
  close(pipe_ends[0]);
  const Session session = read_session(path);
  EXPECT_GE(session.edits.size(), confirmed);
  EXPECT_LE(session.edits.size(), confirmed + 1);
  Document document;
  for (const SessionEdit& edit : session.edits) document.apply(edit.edit);
  EXPECT_EQ(document.mesh().broken_invariant(), "");
}

TEST(Journal, UnwritableFolderIsTold) {
  EXPECT_THROW(Journal("/nonexistent/folder/j.jsonl"), FileError);
}

}  // namespace
}  // namespace batten
