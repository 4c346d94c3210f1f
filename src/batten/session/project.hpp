#pragma once
#include <string>
#include <vector>

#include "batten/session/document.hpp"

namespace batten {

/// Writes a project: a zip file of project.json (the objects as they are), journal.jsonl (all edits) and the
/// long lists of both as arrays (docs/projects.md). Equal documents with equal logs give equal bytes. The
/// file takes its place when it is whole and on the disk.
/// @throws FileError when the file cannot be written or would pass 4 GB.
void write_project(const std::string& path, const Document& document);
std::string format_project(const Document& document);

/// A project as it was read.
struct ProjectFile {
  Document document;
  int format = 2;                     ///< of the file: 1 or 2
  std::vector<std::string> warnings;  ///< in words
};

/// Reads a project of format 2 or 1 (a single model, which becomes the object "model"). The journal is played
/// again, so that undo works; where that does not give the stored objects bit for bit (a file of another
/// version), these hold and their history is gone, with a warning.
/// @throws FileError when the file is no project or damaged.
ProjectFile read_project(const std::string& path);
ProjectFile parse_project(const std::string& bytes, const std::string& path);

}  // namespace batten
