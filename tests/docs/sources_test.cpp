#include "docs/documents.hpp"

#include <algorithm>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

/// Calls with two random numbers among their arguments, which a compiler draws in the order that it likes:
/// the program and the page of the studio, made by another compiler, would go apart. Braces and declarations
/// have an order.
std::string unordered_draws(const std::string& text) {
  static const std::regex draws(
      R"(\w\((?:[^(){};]*\.(?:normal|uniform|below|bits|direction)\([^()]*\)[^(){};]*,){1,3}[^(){};]*\.(?:normal|uniform|below|bits|direction)\()");
  std::smatch found;
  return std::regex_search(text, found, draws) ? found.str() : std::string();
}

TEST(Sources, DrawRandomNumbersInAnOrder) {
  EXPECT_EQ(unordered_draws("const double a = r.uniform(0, 1), b = r.uniform(0, 2);"), "");
  EXPECT_EQ(unordered_draws("wave = {r.uniform(0, 1), r.normal()};"), "");
  EXPECT_EQ(unordered_draws("for (double t = r.uniform(); t < 1; t += r.uniform(1, 2)) {"), "");
  EXPECT_NE(unordered_draws("const Vector2d v(r.normal(), r.normal());"), "");
  EXPECT_NE(unordered_draws("x.push_back(m + s * Vector3d(r.uniform(0, 1),\n  r.uniform(0, 1), 2));"), "");
  int n = 0;
  for (const std::string& file : files_of({"src/batten", "apps", "experiments"}, {".hpp", ".cpp"})) {
    ++n;
    EXPECT_EQ(unordered_draws(content(repository() / file)), "") << file;
  }
  EXPECT_GT(n, 300);
}

}  // namespace
}  // namespace batten::test
