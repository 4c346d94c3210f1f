#pragma once
// What tests of readers have in common: files that are refused, and what the refusal says.
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {

inline const std::string kSharedData = BATTEN_SHARED_DATA;

/// A file that no reader takes, and where it is at fault.
struct BadFile {
  const char* name;
  std::string content;
  long line;         // 0 where no line is to blame
  const char* word;  // in the sentence
};

/// So that a failing row is named in the output.
inline void PrintTo(const BadFile& file, std::ostream* out) {
  *out << file.name << " " << file.content.substr(0, 40);
}

inline const std::string kGarbage("\x7f\x45\x4c\x46\x02\x01\x01\x00\x00\xff\xfe\x80 garbage \x00\x01", 24);

/// A change of a good file that breaks one rule.
struct BadChange {
  const char* name;
  const char* from;
  const char* to;
  long line;
  const char* says;
};

/// The text with the first `from` replaced; a failure where there is none.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

/// Reading throws an error that names the file, the line (0: none) and the matter.
template <typename Read>
void expect_refused(const Read& read, const std::string& path, long line, const std::string& says) {
  try {
    read();
    ADD_FAILURE() << "was read";
  } catch (const FileError& error) {
    EXPECT_EQ(error.path(), path);
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
  }
}

}  // namespace batten::test
