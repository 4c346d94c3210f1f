#include "batten/session/journal.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/io/file.hpp"
#include "batten/session/edit_json.hpp"

namespace batten {

namespace {

std::vector<Edit> edits_of(const Session& session) {
  std::vector<Edit> edits;
  edits.reserve(session.edits.size());
  for (const SessionEdit& edit : session.edits) edits.push_back(edit.edit);
  return edits;
}

}  // namespace

void Journal::fail(const std::string& problem) const {
  throw FileError(path_, 0, problem + ": " + std::strerror(errno));
}

Journal::Journal(const std::string& path) : path_(path) {
  open();
  try {
    struct stat status {};
    if (::fstat(file_, &status) != 0) fail("the journal cannot be read");
    if (status.st_size > 0) {
      const std::string text = read_file(path);
      const Session session = parse_session(text, path);
      if (session.format == 1) {
        write_session(path, edits_of(session));
        close();
        open();
        return;
      }
      const std::size_t whole = session.torn ? text.rfind('\n') + 1 : text.size();  // none: npos + 1 = 0
      // An unfinished line goes, or the next edit would be written behind it.
      if (session.torn && ::ftruncate(file_, static_cast<off_t>(whole)) != 0)
        fail("the torn line cannot be cut off");
      if (whole > 0) {
        if (!session.torn && text.back() != '\n') append("");
        last_line_ = -1;
        return;
      }
    }
    append(format_session_header());
    flush();
    last_line_ = -1;  // the header is no edit
  } catch (...) {
    close();
    throw;
  }
}

Journal::~Journal() {
  if (file_ < 0) return;
  ::fdatasync(file_);
  close();
}

void Journal::open() {
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail("the journal cannot be opened");
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close();
    throw FileError(path_, 0, "another process writes this journal; close it there first");
  }
}

void Journal::close() {
  ::close(file_);
  file_ = -1;
}

void Journal::flush() {
  // Pipes and read-only systems have nothing to flush.
  if (::fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) fail("the journal cannot be flushed");
}

void Journal::append(const std::string& line) {
  const off_t before = ::lseek(file_, 0, SEEK_END);
  const std::string bytes = line + '\n';
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t n = ::write(file_, bytes.data() + written, bytes.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const std::string reason = std::strerror(errno);
      if (::ftruncate(file_, before) != 0) throw FileError(path_, 0, "the journal is damaged: " + reason);
      throw FileError(path_, 0, "the edit cannot be written to the journal: " + reason);
    }
    written += static_cast<std::size_t>(n);
  }
  last_line_ = before;
}

void Journal::write(const Edit& edit, LogPlace place) {
  const std::string line = format_edit(edit);
  if (place == LogPlace::Append || last_line_ < 0) {
    append(line);
    flush();
    return;
  }
  if (::ftruncate(file_, static_cast<off_t>(last_line_)) != 0) fail("the last edit cannot be replaced");
  append(line);
}

}  // namespace batten
