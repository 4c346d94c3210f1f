#pragma once
#include <string>
#include <vector>

#include "batten/session/document.hpp"

namespace batten {

/// A document as it is kept in a file.
struct Project {
  Document document;
  std::string unit = "m";
};

/// Writes a project: a zip file of project.json (the elements of the model), coordinates.f64 (little-endian
/// doubles) and journal.jsonl (all edits). Equal documents give equal bytes.
/// @throws FileError when the file cannot be written or would pass 4 GB.
void write_project(const std::string& path, const Project& project);

/// Reads a project. The journal is played again, so that undo works; where that does not give the stored
/// model bit for bit (a file of another version), the stored model holds and its history is gone.
/// @param warnings receives that, in words. @throws FileError when the file is no project or damaged.
Project read_project(const std::string& path, std::vector<std::string>* warnings = nullptr);

std::string format_project(const Project& project);
Project parse_project(const std::string& bytes, const std::string& path,
                      std::vector<std::string>* warnings = nullptr);

}  // namespace batten
