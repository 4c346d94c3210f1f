#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "batten/session/document.hpp"
#include "batten/session/edit.hpp"

namespace batten {

/// An edit of a journal and where it stands.
struct SessionEdit {
  long line = 0;  ///< 1-based
  Edit edit;
};

/// A recorded session: a header, then one edit a line.
struct Session {
  /// Of the file. Sessions of format 1 are edits of one model; they are given as those of format 2, after two
  /// that the file implies: one that adds the model "model" as o1, with the unit of the header, and a
  /// checkpoint. Both stand in the line of the header.
  int format = 2;
  std::vector<SessionEdit> edits;
  std::size_t n_implied = 0;  ///< of the first edits: not written in the file
  /// The last line was not finished: the process that wrote it was killed in the middle of an edit. It is not
  /// among the edits.
  bool torn = false;
  long torn_line = 0;

  /// What is lost by a torn line, naming file and line; empty where nothing is.
  std::string warning(const std::string& path) const;
};

/// Reads a session or a journal (they are the same), packed with gzip or not. Empty lines are passed over.
/// @throws FileError naming the line, what is wrong with it and what was expected.
Session read_session(const std::string& path);
Session parse_session(const std::string& text, const std::string& path);

/// Writes a session of format 2 in one go: under another name, to the disk, then renamed.
/// @throws FileError.
void write_session(const std::string& path, const std::vector<Edit>& edits);
std::string format_session(const std::vector<Edit>& edits);

/// Writes a journal: every edit is on the disk before write() returns, so that a process that dies, or a
/// computer, loses at most the edit in flight. Edits within a drag replace each other at the end of the file;
/// they wait for the next other edit to be flushed, and a computer that dies may lose the drag under way.
class Journal {
 public:
  /// Begins a journal, or continues one after its last whole line. One of format 1 is first rewritten in
  /// format 2. @throws FileError, also when another process writes it.
  explicit Journal(const std::string& path);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  /// As Document::Confirm. @throws FileError when the disk is full or gone; the journal is then as before but
  /// for an edit that was to be replaced, which is gone.
  void write(const Edit& edit, LogPlace place = LogPlace::Append);

 private:
  void open();
  void close();
  void append(const std::string& line);
  void flush();
  [[noreturn]] void fail(const std::string& problem) const;

  std::string path_;
  int file_ = -1;
  std::int64_t last_line_ = -1;  ///< where the edit written last begins; −1: none was written yet
};

}  // namespace batten
