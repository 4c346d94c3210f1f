#include "docs/documents.hpp"

#include <filesystem>
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

}  // namespace
}  // namespace batten::test
