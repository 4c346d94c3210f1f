#include "docs/documents.hpp"

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

/// A line of prose: of a document, or a comment of a source.
struct Prose {
  Place place;
  std::string text;
};

/// All prose of the repository, this test's own folder excepted: it speaks of what must not be.
const std::vector<Prose>& all_prose() {
  static const std::vector<Prose> all = [] {
    std::vector<Prose> result;
    const auto add = [&](const std::string& path, bool comments) {
      std::istringstream in(content(repository() / path));
      std::string line;
      for (int number = 1; std::getline(in, line); ++number) {
        std::string text = comments ? comment_of(line) : line;
        if (!text.empty()) result.push_back({{path, number}, std::move(text)});
      }
    };
    for (const std::string& path :
         files_of({"src", "apps", "tests", "bench", "experiments", "fuzz", "examples", "python"},
                  {".hpp", ".cpp"}))
      if (path.rfind("tests/docs/", 0) != 0) add(path, true);
    for (const auto& [path, document] : documents()) add(path, false);
    return result;
  }();
  return all;
}

std::string where(const Place& place) {
  return place.file + ":" + std::to_string(place.line);
}

/// Calls `use(match, place)` for every match in the prose.
template <typename Use>
void each_match(const std::regex& pattern, const Use& use) {
  for (const Prose& prose : all_prose())
    for (std::sregex_iterator it(prose.text.begin(), prose.text.end(), pattern), end; it != end; ++it)
      use(*it, prose.place);
}

std::map<std::string, int> bibliography() {
  std::map<std::string, int> keys;
  const std::string text = content(repository() / "docs/bibliography.bib");
  const std::regex entry("@[a-z]+\\{([a-z0-9]+),");
  for (std::sregex_iterator it(text.begin(), text.end(), entry), end; it != end; ++it) ++keys[(*it)[1]];
  return keys;
}

// The form is that of CONTRIBUTING, "Citations": docs/methods.md#regression, in comments and documents alike.
TEST(Citations, EveryDocumentAndSectionThatIsNamedExists) {
  int n = 0;
  each_match(std::regex("\\bdocs/([A-Za-z0-9_/-]+\\.[a-z]+)(#([A-Za-z0-9_-]+))?"),
             [&](const std::smatch& match, const Place& place) {
               SCOPED_TRACE(where(place) + ": " + match.str());
               ++n;
               const std::string path = "docs/" + match[1].str();
               EXPECT_TRUE(std::filesystem::exists(repository() / path));
               if (!match[3].matched) return;
               const auto found = documents().find(path);
               ASSERT_NE(found, documents().end());
               EXPECT_EQ(found->second.anchors.count(match[3]), 1U) << "no such section";
             });
  EXPECT_GT(n, 40);
}

TEST(Citations, NoDocumentIsNamedThatIsNotInTheRepository) {
  each_match(std::regex("\\b(METHODS|ERRATA|DESIGN|STYLE|BASELINES|FEASIBILITY)\\b"),
             [](const std::smatch& match, const Place& place) {
               ADD_FAILURE() << where(place) << " cites " << match.str()
                             << "; cite a section of docs/, as docs/methods.md#regression";
             });
}

TEST(Citations, EveryWorkCitedByKeyIsInTheBibliographyAndEveryEntryIsCitedOnce) {
  const std::map<std::string, int> keys = bibliography();
  EXPECT_GT(keys.size(), 50U);
  for (const auto& [key, n] : keys) EXPECT_EQ(n, 1) << key << " is entered " << n << " times";
  std::set<std::string> cited;
  each_match(std::regex("\\[([a-z]+(19|20)[0-9]{2}[a-z]*|huska)\\]"),
             [&](const std::smatch& match, const Place& place) {
               EXPECT_EQ(keys.count(match[1]), 1U)
                   << where(place) << " cites " << match.str() << ", which docs/bibliography.bib lacks";
               cited.insert(match[1]);
             });
  for (const auto& [key, n] : keys) EXPECT_EQ(cited.count(key), 1U) << key << " is cited nowhere";
}

// One form for all: by key, not by author and year.
TEST(Citations, HeadersCiteWorksByKey) {
  each_match(std::regex("\\b[A-Z][a-z]+( et al\\.)?,? \\(?(19|20)[0-9]{2}\\b"),
             [](const std::smatch& match, const Place& place) {
               if (place.file.rfind("src/", 0) == 0 && place.file.find(".hpp") != std::string::npos)
                 ADD_FAILURE() << where(place) << " cites \"" << match.str()
                               << "\"; cite the key of docs/bibliography.bib in square brackets";
             });
}

}  // namespace
}  // namespace batten::test
