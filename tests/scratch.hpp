#pragma once
#include <filesystem>
#include <string>

#include <unistd.h>

namespace batten::test {

/// The folder of this run of a test program, removed at its end. Tests run side by side, each in a process of
/// its own: a fixed name would let one read what another is writing.
inline const std::string& scratch() {
  struct Folder {
    pid_t owner = getpid();  // a forked child must not remove its parent's files
    std::string path = std::filesystem::temp_directory_path() / ("batten_test_" + std::to_string(owner));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      if (getpid() == owner) std::filesystem::remove_all(path);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
  };
  static const Folder folder;
  return folder.path;
}

/// The path of a file in scratch().
inline std::string scratch_file(const std::string& name) {
  return scratch() + "/" + name;
}

}  // namespace batten::test
