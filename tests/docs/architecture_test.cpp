#include "docs/documents.hpp"

#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

/// The drawing and the table that docs/architecture.md has to hold. An arrow goes from a room to one that
/// uses it; arrows that others imply are left out, or nobody could read the drawing.
std::string expected_drawing(const std::vector<Room>& all) {
  std::map<std::string, std::set<std::string>> reach;  // what a room uses, directly or not
  for (const Room& room : all)                         // in order: what is used stands above
    for (const std::string& used : room.uses) {
      reach[room.name].insert(used);
      reach[room.name].insert(reach[used].begin(), reach[used].end());
    }
  std::ostringstream out;
  out << "```mermaid\nflowchart TD\n";
  for (const Room& room : all) {
    if (room.uses.empty()) out << "  " << room.name << "\n";
    for (const Room& other : all) {
      if (room.uses.count(other.name) == 0) continue;
      bool implied = false;
      for (const std::string& used : room.uses) implied = implied || reach[used].count(other.name) != 0;
      if (!implied) out << "  " << other.name << " --> " << room.name << "\n";
    }
  }
  out << "```\n\n| room | uses | purpose |\n|---|---|---|\n";
  for (const Room& room : all) {
    out << "| `" << room.name << "` | ";
    std::string list;
    for (const Room& other : all)
      if (room.uses.count(other.name) != 0) list += (list.empty() ? "" : " ") + other.name;
    out << (list.empty() ? "–" : list) << " | " << room.purpose << " |\n";
  }
  return out.str();
}

TEST(Architecture, DrawingAndTableAreWhatTheBuildDeclares) {
  const std::vector<Room> all = rooms();
  ASSERT_GT(all.size(), 15U);
  const std::string expected = expected_drawing(all);
  EXPECT_NE(documents().at("docs/architecture.md").text.find(expected), std::string::npos)
      << "docs/architecture.md should hold, as src/batten/*/CMakeLists.txt declare it:\n\n"
      << expected;
}

TEST(Architecture, RoomsUseOnlyRoomsAboveThem) {
  std::set<std::string> above;
  for (const Room& room : rooms()) {
    EXPECT_FALSE(room.purpose.empty()) << room.name;
    for (const std::string& used : room.uses)
      EXPECT_EQ(above.count(used), 1U) << room.name << " uses " << used;
    above.insert(room.name);
  }
}

// The README's list of the house names every room, and in the order of the build.
TEST(Architecture, ReadmeNamesTheRoomsInTheirOrder) {
  const std::string& readme = documents().at("README.md").text;
  const std::size_t house = readme.find("## The house");
  ASSERT_NE(house, std::string::npos);
  std::size_t last = house;
  for (const Room& room : rooms()) {
    const std::size_t at = readme.find("`" + room.name + "`", house);
    EXPECT_NE(at, std::string::npos) << room.name << " is missing";
    EXPECT_GT(at, last) << room.name << " is out of order";
    last = at;
  }
}

}  // namespace
}  // namespace batten::test
