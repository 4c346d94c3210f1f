#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace batten::test {

/// A place in a file of the repository, for messages.
struct Place {
  std::string file;  ///< relative to the root
  int line = 0;      ///< from 1
};

/// A document and what links into it may name.
struct Document {
  std::string text;
  std::set<std::string> anchors;  ///< slugs of the headings as GitHub makes them, and explicit ids
};

/// A link of a document: [text](target), target neither a web address nor in a code block.
struct Link {
  Place place;
  std::string target;
};

/// The root of the repository.
std::filesystem::path repository();

/// The content of a file. @throws std::runtime_error when there is none.
std::string content(const std::filesystem::path& file);

/// The files below the folders, relative to the root, whose names end in one of the extensions; sorted.
std::vector<std::string> files_of(const std::vector<std::string>& folders,
                                  const std::vector<std::string>& extensions);

/// Every .md of the repository outside build folders, by path relative to the root.
const std::map<std::string, Document>& documents();
std::vector<Link> links_of(const std::string& path, const std::string& text);

/// "From a scan (S 3)" → "from-a-scan-s-3": lower case, punctuation gone, blanks to hyphens.
std::string slug(const std::string& heading);

/// The comment of a line of C++, empty where it has none.
std::string comment_of(const std::string& line);

/// What a batten_room() declares.
struct Room {
  std::string name, purpose;
  std::set<std::string> uses;
};

/// The rooms in the order of src/batten/CMakeLists.txt.
std::vector<Room> rooms();

}  // namespace batten::test
