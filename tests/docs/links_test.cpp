#include "docs/documents.hpp"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

namespace fs = std::filesystem;

TEST(Slug, IsWhatGitHubMakesOfAHeading) {
  EXPECT_EQ(slug("Conventions"), "conventions");
  EXPECT_EQ(slug("From a scan to a network (S 3)"), "from-a-scan-to-a-network-s-3");
  EXPECT_EQ(slug("<a id=\"h-2-2\"></a>H 2.2"), "h-22");
  EXPECT_EQ(slug("Simplification, beside *its* peers"), "simplification-beside-its-peers");
  EXPECT_EQ(slug("A – B"), "a--b");
  EXPECT_EQ(slug("See [that](x.md)"), "see-that");
}

// A link of a document names a file or folder of the repository and, behind #, a heading or an id in it.
TEST(Documents, EveryRelativeLinkAndAnchorResolves) {
  int n_links = 0, n_anchors = 0;
  for (const auto& [path, document] : documents()) {
    for (const Link& link : links_of(path, document.text)) {
      SCOPED_TRACE(link.place.file + ":" + std::to_string(link.place.line) + ": " + link.target);
      ++n_links;
      const std::size_t hash = link.target.find('#');
      const std::string file = link.target.substr(0, hash);
      const std::string target =
          file.empty() ? path : (fs::path(path).parent_path() / file).lexically_normal().generic_string();
      EXPECT_TRUE(fs::exists(repository() / target)) << "there is no " << target;
      if (hash == std::string::npos) continue;
      ++n_anchors;
      const auto found = documents().find(target);
      ASSERT_NE(found, documents().end()) << target << " is no document";
      EXPECT_EQ(found->second.anchors.count(link.target.substr(hash + 1)), 1U) << "no such section";
    }
  }
  EXPECT_GT(n_links, 100);  // else the search itself is broken
  EXPECT_GT(n_anchors, 20);
}

}  // namespace
}  // namespace batten::test
