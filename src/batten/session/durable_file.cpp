#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/session/durable_file_detail.hpp"

namespace batten::detail {

namespace {

namespace fs = std::filesystem;

/// Waits until a file or folder is on the disk. Some file systems have none: they answer EINVAL.
bool flush(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool flushed = ::fsync(file) == 0 || errno == EINVAL || errno == EROFS;
  ::close(file);
  return flushed;
}

}  // namespace

void write_durably(const std::string& path, const std::string& content) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status)) {  // a pipe: nothing to replace
    write_file(path, content);
    return;
  }
  // A link stays, and what it leads to is replaced.
  const fs::path place = fs::exists(status) ? fs::canonical(path, none) : fs::path(path);
  const std::string next = concat(place.string(), ".", ::getpid(), ".next");
  try {
    write_file(next, content);
  } catch (const FileError&) {
    throw FileError(path, 0, "cannot be written; does its folder exist, is there room on the disk?");
  }
  if (!flush(next) || std::rename(next.c_str(), place.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    fs::remove(next, none);
    throw FileError(path, 0, "cannot be written: " + reason);
  }
  flush(place.has_parent_path() ? place.parent_path().string() : ".");  // the name, too, as far as possible
}

}  // namespace batten::detail
