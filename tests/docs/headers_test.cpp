#include "docs/documents.hpp"

#include <filesystem>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

// Whoever changes src/batten/<room>/<name>.hpp finds its tests in tests/<room>/<name>_test.cpp.
TEST(Headers, EveryPublicHeaderHasATestOfItsName) {
  int n = 0;
  for (const std::string& file : files_of({"src/batten"}, {".hpp"})) {
    const std::filesystem::path path(file);
    const std::string stem = path.stem().string(), room = path.parent_path().filename().string();
    if (stem.size() > 7 && stem.substr(stem.size() - 7) == "_detail") continue;
    ++n;
    const std::string test = "tests/" + room + "/" + stem + "_test.cpp";
    EXPECT_TRUE(std::filesystem::exists(repository() / test))
        << file << " has no test of its name; write " << test;
  }
  EXPECT_GT(n, 120);
}

/// The text between the brace at `open` and the one that closes it.
std::string in_braces(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '{') ++depth;
    if (text[i] == '}' && --depth == 0) return text.substr(open, i - open);
  }
  return text.substr(open);
}

// Whoever fills in options, in whichever language, asks them what is wrong before anything is run.
TEST(Headers, EveryOptionsStructNamesItsProblem) {
  const std::regex definition(R"(struct (\w+Options)\b[^;{]*\{)");
  int n = 0;
  for (const std::string& file : files_of({"src/batten"}, {".hpp"})) {
    if (file.find("_detail.hpp") != std::string::npos) continue;
    const std::string text = content(repository() / file);
    for (std::sregex_iterator found(text.begin(), text.end(), definition), end; found != end; ++found) {
      ++n;
      const auto open = static_cast<std::size_t>(found->position() + found->length()) - 1;
      EXPECT_NE(in_braces(text, open).find("problem("), std::string::npos)
          << file << ": " << (*found)[1] << " has no problem()";
    }
  }
  EXPECT_GT(n, 60);
}

}  // namespace
}  // namespace batten::test
