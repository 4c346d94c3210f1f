#include "batten/session/journal.hpp"

#include "../sketch/strokes.hpp"
#include "one_model.hpp"
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

using namespace test;

/// Committed files of format 1, written before there was another.
const std::string kJournals = BATTEN_EXAMPLES "/../tests/session/data";

Document played(const Session& session, int* refused = nullptr) {
  Document document;
  for (const SessionEdit& edit : session.edits) try {
      document.apply(edit.edit);
    } catch (const RefusedEdit&) {
      if (!refused) throw;
      ++*refused;
    }
  return document;
}

TEST(Session, ErrorsCarryTheLine) {
  const std::string header = "{\"batten_session\":2}\n";
  EXPECT_EQ(parse_session(header, "s").edits.size(), 0u);
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
  EXPECT_EQ(line_of("{\"batten_session\":3}\n"), 1);
  EXPECT_EQ(line_of(header + "\n{\"op\":\"undo\"\n{\"op\":\"undo\"}\n"), 3);
  EXPECT_EQ(line_of(header + "{\"op\":\"undo\"}\n{\"op\":\"cut\"}\n"), 3);
  // A last line that is whole but wrong is no torn one.
  EXPECT_EQ(line_of(header + "{\"op\":\"undo\"}\n{\"op\":\"cut\"}"), 3);
  EXPECT_EQ(line_of(header + "{\"op\":\"und\n"), 2);
}

TEST(Session, EveryLineDamagedButTheLastIsAnErrorOfThatLine) {
  const std::string text = "{\"batten_session\":2}\n" +
                           format_edit(AddEdit{{1}, "model", "m", SharedModel()}) + '\n' +
                           format_edit(RenameEdit{{1}, "other"}) + '\n' + format_edit(UndoEdit{}) + '\n';
  long line = 1;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    try {
      parse_session(text.substr(0, at) + text.substr(at, (end - at) / 2) + text.substr(end), "s.jsonl");
      ADD_FAILURE() << line;
    } catch (const FileError& error) {
      EXPECT_EQ(error.line(), line);
    }
    at = end + 1;
  }
  EXPECT_EQ(line, 5);
}

TEST(Session, UnfinishedLastLineIsToldAndPassedOver) {
  const std::string text =
      "{\"batten_session\":2}\n{\"op\":\"undo\"}\n{\"op\":\"unit\",\"object\":\"o1\",\"unit\":\"m\"}";
  EXPECT_EQ(parse_session(text, "s").edits.size(), 2u);  // whole, without an end of line
  EXPECT_FALSE(parse_session(text, "s").torn);
  EXPECT_EQ(parse_session(text, "s").warning("s"), "");
  const std::size_t second = text.rfind('\n') + 1;
  for (std::size_t length = second + 1; length < text.size(); ++length) {
    const Session session = parse_session(text.substr(0, length), "s");
    EXPECT_TRUE(session.torn);
    EXPECT_EQ(session.torn_line, 3);
    EXPECT_EQ(session.edits.size(), 1u);
    EXPECT_NE(session.warning("s").find("s:3: the last line is not finished"), std::string::npos);
  }
  // Blank lines count as lines.
  EXPECT_EQ(parse_session("\n" + text.substr(0, second) + "\n{\"op\":", "s").torn_line, 5);
  // What a file system leaves when the computer dies.
  EXPECT_TRUE(parse_session(text.substr(0, second) + std::string(100, '\0'), "s").torn);
}

TEST(Session, FilesOfFormat1StillOpen) {
  const Session session = read_session(kJournals + "/format_1.jsonl");
  EXPECT_EQ(session.format, 1);
  EXPECT_EQ(session.n_implied, 2u);
  EXPECT_EQ(session.edits[session.n_implied].line, 2);
  int refused = 0;
  Document document = played(session, &refused);
  EXPECT_EQ(refused, 2);  // an undo of nothing, and a stroke that meets nothing
  EXPECT_EQ(document.objects().size(), 1u);
  EXPECT_EQ(document.object(kModel).name, "model");
  EXPECT_EQ(document.unit(kModel), "mm");
  // Counts as the program of format 1 told them.
  const SketchCounts counts = document.model(kModel).counts();
  EXPECT_EQ(counts.curves, 3);
  EXPECT_EQ(counts.vertices, 6);
  EXPECT_EQ(counts.edges, 12);
  EXPECT_EQ(counts.faces, 8);
  EXPECT_TRUE(document.can_redo());
  while (document.can_undo()) document.apply(UndoEdit{});
  EXPECT_TRUE(document.model(kModel) == PolylineMesh());  // the model itself was there from the first
}

TEST(Session, WrittenInFormat2ItIsTheSame) {
  int refused = 0;
  const Document document = played(read_session(kJournals + "/format_1.jsonl"), &refused);
  const std::string path = scratch_file("written.jsonl");
  write_session(path, document.log());
  const Session session = read_session(path);
  EXPECT_EQ(session.format, 2);
  EXPECT_EQ(session.n_implied, 0u);
  EXPECT_TRUE(played(session) == document);
}

TEST(Journal, ContinuesAfterATornLine) {
  const std::string path = scratch_file("torn.jsonl");
  {
    Journal journal(path);
    journal.write(AddEdit{kModel, "model", "mm", SharedModel()});
  }
  std::ofstream(path, std::ios::app) << "{\"op\":\"ins";
  {
    Journal journal(path);
    journal.write(UndoEdit{});
  }
  const Session session = read_session(path);
  EXPECT_FALSE(session.torn);
  ASSERT_EQ(session.edits.size(), 2u);
  EXPECT_EQ(name_of_op(session.edits[1].edit), "undo");
}

// A text editor may have taken the last end of line away.
TEST(Journal, ContinuesAfterALineWithoutEnd) {
  const std::string path = scratch_file("endless.jsonl");
  std::string text = format_session({UndoEdit{}});
  text.pop_back();
  write_file(path, text);
  Journal(path).write(RedoEdit{});
  const Session session = read_session(path);
  ASSERT_EQ(session.edits.size(), 2u);
  EXPECT_EQ(name_of_op(session.edits[1].edit), "redo");
}

// The last line is replaced only where this journal has written it: not the header, and not what was there.
TEST(Journal, ReplacesNothingThatItHasNotWritten) {
  const std::string path = scratch_file("first.jsonl");
  Journal(path).write(UndoEdit{}, LogPlace::ReplaceLast);
  EXPECT_EQ(read_session(path).edits.size(), 1u);
  Journal(path).write(RedoEdit{}, LogPlace::ReplaceLast);
  EXPECT_EQ(read_session(path).edits.size(), 2u);
}

TEST(Journal, IsWrittenByOneAtATime) {
  const std::string path = scratch_file("locked.jsonl");
  {
    const Journal first(path);
    EXPECT_THROW(Journal{path}, FileError);
  }
  EXPECT_NO_THROW(Journal{path});
}

TEST(Journal, BeginsAnewAfterATornHeaderOnly) {
  const std::string path = scratch_file("torn_header.jsonl");
  write_file(path, "{\"batten_sess");
  Journal(path).write(UndoEdit{});
  EXPECT_EQ(read_session(path).edits.size(), 1u);
  // Another file is left alone.
  write_file(path, "dear diary");
  EXPECT_THROW(Journal{path}, FileError);
  EXPECT_EQ(read_file(path), "dear diary");
}

TEST(Journal, AJournalOfFormat1IsContinuedInFormat2) {
  const std::string path = scratch_file("old.jsonl");
  const std::string header = "{\"batten_session\":1,\"unit\":\"mm\"}\n";
  const DrawnStroke stroke = circle(kO, kX, kY, 12);
  std::string line = format_edit(on_model(InsertEdit{stroke, {}}));
  line.erase(line.find("\"object\":\"o1\","), 14);
  write_file(path, header + line + "\n{\"op\":\"un");
  Journal(path).write(RenameEdit{kModel, "hull"});
  const Session session = read_session(path);
  EXPECT_EQ(session.format, 2);
  const Document document = played(session);
  EXPECT_EQ(document.unit(kModel), "mm");
  EXPECT_EQ(document.object(kModel).name, "hull");
  EXPECT_EQ(document.model(kModel).counts().curves, 1);
}

TEST(Journal, ADragIsOneLine) {
  const std::string path = scratch_file("drag.jsonl");
  Document document;
  {
    Journal journal(path);
    const auto confirm = [&](const Edit& edit, LogPlace place) { journal.write(edit, place); };
    document.apply(AddEdit{{}, "view", "", ViewState{}}, confirm);
    for (int k = 1; k <= 20; ++k) {
      ViewState view;
      view.azimuth = k;
      view.zoom = k % 3 == 0 ? 1 : 1.0 / k;  // lines grow and shrink
      document.apply(ViewEdit{{1}, view, 5}, confirm);
    }
    ASSERT_EQ(read_session(path).edits.size(), 2u);
    document.apply(RenameEdit{{1}, "side"}, confirm);
  }
  const Session session = read_session(path);
  ASSERT_EQ(session.edits.size(), 3u);
  EXPECT_EQ(std::get<ViewEdit>(session.edits[1].edit).view.azimuth, 20);
  EXPECT_TRUE(played(session) == document);
}

TEST(Journal, KilledProcessLosesAtMostTheEditInFlight) {
  // A child confirms edits through a pipe and is killed without warning; whatever it confirmed is on the
  // disk, drags as they were last.
  const std::string path = scratch_file("killed.jsonl");
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    Journal journal(path);
    Document document;
    for (int k = 0;; ++k) {
      const Edit edit = k == 0   ? Edit(AddEdit{kModel, "model", "m", SharedModel()})
                        : k == 1 ? on_model(InsertEdit{circle(kO, kX, kY), {}})
                                 : Edit(ModelEdit{kModel, SharpnessEdit{0, (k % 100) / 100.0, {}}, k / 3});
      document.apply(edit, [&](const Edit& done, LogPlace place) { journal.write(done, place); });
      if (write(pipe_ends[1], "x", 1) != 1) _exit(1);
    }
  }
  char byte = 0;
  int confirmed = 0;
  while (confirmed < 20 && read(pipe_ends[0], &byte, 1) == 1) ++confirmed;
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(pipe_ends[1]);
  while (read(pipe_ends[0], &byte, 1) == 1) ++confirmed;
  close(pipe_ends[0]);
  // Three lines for the first edits, then one for every three: edits 3, 4, 5 are drag 1, and so on.
  const auto lines_of = [](int n) { return n <= 3 ? n : 3 + (n - 1) / 3; };
  const Session session = read_session(path);
  const auto n = static_cast<int>(session.edits.size());
  // A drag that was being written over may be gone with the edit in flight.
  EXPECT_GE(n, lines_of(confirmed) - 1);
  EXPECT_LE(n, lines_of(confirmed + 1));
  EXPECT_EQ(played(session).model(kModel).broken_invariant(), "");
}

TEST(Journal, UnwritableFolderIsTold) {
  EXPECT_THROW(Journal("/nonexistent/folder/j.jsonl"), FileError);
}

}  // namespace
}  // namespace batten
