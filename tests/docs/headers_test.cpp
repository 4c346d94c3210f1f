#include "docs/documents.hpp"

#include <filesystem>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

/// Public headers that no source of tests is named for yet. What is here and has one is an error too.
const std::set<std::string> kWithout = {
    "session/edit_json",  // entered through journal_test and document_test
};

// Whoever changes src/batten/<room>/<name>.hpp finds its tests in tests/<room>/<name>_test.cpp.
TEST(Headers, EveryPublicHeaderHasATestOfItsName) {
  int n = 0;
  for (const std::string& file : files_of({"src/batten"}, {".hpp"})) {
    const std::filesystem::path path(file);
    const std::string stem = path.stem().string(), room = path.parent_path().filename().string();
    if (stem.size() > 7 && stem.substr(stem.size() - 7) == "_detail") continue;
    ++n;
    const std::string test = "tests/" + room + "/" + stem + "_test.cpp";
    const bool is_there = std::filesystem::exists(repository() / test);
    if (kWithout.count(room + "/" + stem) > 0)
      EXPECT_FALSE(is_there) << file << " has a test by now: take it off the list here";
    else
      EXPECT_TRUE(is_there) << file << " has no test of its name; write " << test;
  }
  EXPECT_GT(n, 120);
}

}  // namespace
}  // namespace batten::test
