#pragma once
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

// Shared by the readers of scans; not part of the library's interface.
namespace batten::detail {

/// Text of a file for an error: shortened, and without what a terminal would obey.
inline std::string quoted(std::string_view text) {
  constexpr size_t kLongest = 40;
  std::string shown(text.substr(0, kLongest));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  return concat("\"", shown, text.size() > kLongest ? "…\"" : "\"");
}

/// A node as a file lists it, kept until all are known.
struct NodeEntry {
  int id;
  std::string path;
  long line;
};

/// The numbers of n nodes are 0 … n − 1 or 1 … n (S 5.2.1). A number beyond is a slip of the hand, and would
/// silently give another topology. @throws FileError at the first such entry.
inline void check_node_numbers(const std::vector<NodeEntry>& nodes) {
  std::set<int> ids;
  for (const NodeEntry& node : nodes)
    if (node.id >= 0) ids.insert(node.id);
  if (ids.empty()) return;
  const int last = static_cast<int>(ids.size()) - (*ids.begin() == 0 ? 1 : 0);
  for (const NodeEntry& node : nodes)
    if (node.id > last)
      throw FileError(node.path, node.line,
                      concat("node number ", node.id, " is out of range: the file names ", ids.size(),
                             " nodes, so they are numbered 0 … ", ids.size() - 1, " or 1 … ", ids.size(),
                             " without gaps"));
}

/// One line of text for a comment.
inline std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

}  // namespace batten::detail
