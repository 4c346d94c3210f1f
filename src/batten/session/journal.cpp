#include "batten/session/journal.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/session/edit_json.hpp"

namespace batten {

Session parse_session(const std::string& text, const std::string& path) {
  Session session;
  bool has_header = false;
  long line_number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin);
    const bool unfinished = end == std::string::npos;
    const std::string_view line =
        trim(std::string_view(text).substr(begin, unfinished ? std::string::npos : end - begin));
    begin = unfinished ? text.size() : end + 1;
    ++line_number;
    if (line.empty()) continue;
    if (unfinished && has_header && !is_whole_json(line)) {  // a whole value needs no end of line
      session.torn = true;
      session.torn_line = line_number;
      break;
    }
    try {
      if (has_header)
        session.edits.push_back({line_number, parse_edit(line)});
      else
        session.unit = parse_session_header(line);
    } catch (const InvalidInput& error) {
      throw FileError(path, line_number, error.what());
    }
    has_header = true;
  }
  if (!has_header)
    throw FileError(path, 0, R"(the file is empty; a session begins with {"batten_session":1,"unit":"m"})");
  return session;
}

Session read_session(const std::string& path) {
  return parse_session(read_file(path), path);
}

Journal::Journal(const std::string& path, const std::string& unit) : path_(path) {
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) throw FileError(path, 0, concat("the journal cannot be opened: ", std::strerror(errno)));
  try {
    struct stat status {};
    if (::fstat(file_, &status) != 0) throw FileError(path, 0, std::strerror(errno));
    if (status.st_size == 0) {
      append(format_session_header(unit));
      return;
    }
    const std::string text = read_file(path);
    const Session session = parse_session(text, path);
    if (session.torn) {  // the unfinished line goes, or the next edit would be written behind it
      const size_t last = text.rfind('\n');
      if (::ftruncate(file_, static_cast<off_t>(last + 1)) != 0)
        throw FileError(path, 0, std::strerror(errno));
    } else if (text.back() != '\n' && ::write(file_, "\n", 1) != 1) {
      throw FileError(path, 0, std::strerror(errno));
    }
  } catch (...) {
    ::close(file_);
    throw;
  }
}

Journal::~Journal() {
  if (file_ >= 0) ::close(file_);
}

void Journal::append(const std::string& line) {
  const off_t before = ::lseek(file_, 0, SEEK_END);
  const std::string bytes = line + '\n';
  size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t n = ::write(file_, bytes.data() + written, bytes.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const std::string reason = std::strerror(errno);
      if (::ftruncate(file_, before) != 0) throw FileError(path_, 0, "the journal is damaged: " + reason);
      throw FileError(path_, 0, "the edit cannot be written to the journal: " + reason);
    }
    written += static_cast<size_t>(n);
  }
  if (::fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS)
    throw FileError(path_, 0, concat("the journal cannot be flushed: ", std::strerror(errno)));
}

void Journal::write(const Edit& edit) {
  append(format_edit(edit));
}

}  // namespace batten
