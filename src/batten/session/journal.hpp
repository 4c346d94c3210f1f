#pragma once
#include <string>
#include <vector>

#include "batten/session/document.hpp"

namespace batten {

/// An edit of a session and where it stands.
struct SessionEdit {
  long line = 0;  ///< 1-based
  Edit edit;
};

/// A recorded session: a header, then one edit a line.
struct Session {
  std::string unit = "m";
  std::vector<SessionEdit> edits;
  /// The last line was not finished: the process that wrote it was killed in the middle of an edit.
  bool torn = false;
  long torn_line = 0;
};

/// Reads a session or a journal (they are the same), packed with gzip or not. Empty lines are passed over.
/// @throws FileError naming the line, what is wrong with it and what was expected.
Session read_session(const std::string& path);
Session parse_session(const std::string& text, const std::string& path);

/// Writes a journal: every edit is on the disk before write() returns, so that a process that dies loses at
/// most the edit in flight.
class Journal {
 public:
  /// Begins a journal, or continues one after its last whole line. @throws FileError.
  explicit Journal(const std::string& path, const std::string& unit = "m");
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  /// @throws FileError when the disk is full or gone; the journal is then as before.
  void write(const Edit& edit);

 private:
  void append(const std::string& line);
  std::string path_;
  int file_ = -1;
};

}  // namespace batten
