#include "batten/io/standard_streams.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <vector>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

std::atomic<bool> output_taken{false};

/// The lines that are neither blank nor comments, at most `n` of them.
std::vector<std::string_view> first_lines(std::string_view content, std::size_t n) {
  std::vector<std::string_view> lines;
  while (!content.empty() && lines.size() < n) {
    const std::size_t end = std::min(content.find('\n'), content.size());
    const std::string_view line = trim(content.substr(0, end));
    if (!line.empty() && line[0] != '#') lines.push_back(line);
    content.remove_prefix(std::min(end + 1, content.size()));
  }
  return lines;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool is_binary_stl(std::string_view content) {
  if (content.size() < 84) return false;
  std::uint32_t n = 0;
  for (int k = 0; k < 4; ++k)
    n |= static_cast<std::uint32_t>(static_cast<unsigned char>(content[80 + static_cast<std::size_t>(k)]))
         << (8 * k);
  return content.size() >= 84 + std::uint64_t{50} * n && n > 0 &&
         content.size() < 84 + std::uint64_t{50} * n + 4096;
}

/// Of formats that begin with numbers or with words of their own.
std::string extension_of_lines(const std::vector<std::string_view>& lines) {
  if (lines.empty()) return {};
  const std::vector<std::string_view> words = words_of(lines[0]);
  for (const std::string_view word : {"v", "vn", "vt", "f", "o", "g", "l", "s", "t", "mtllib", "usemtl"})
    if (words[0] == word) return "obj";
  if (words[0] == "CURVE") return "txt";
  long count = 0;
  if (words.size() == 1 && parse_integer(words[0], count) && lines.size() > 1)
    // The vertices of a network follow, or the flags of the first curve of a scan.
    return words_of(lines[1]).size() >= 3 && words_of(lines[1])[1] != "#" ? "net" : "rawnet";
  if (lines[0].find(',') != std::string_view::npos || lines[0].find(';') != std::string_view::npos)
    return "csv";
  return {};
}

}  // namespace

bool is_standard_stream(std::string_view path) {
  if (path == "-") return true;
  if (path.size() < 3 || path.substr(path.size() - 2) != ":-") return false;
  path.remove_suffix(2);
  return std::all_of(path.begin(), path.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; });
}

std::string input_extension(const std::string& path) {
  return path == "-" ? extension_of_content(standard_input()) : file_extension(path);
}

std::string output_extension(std::string_view path, std::string_view standard) {
  return path == "-" ? std::string(standard) : file_extension(path);
}

std::string extension_of_content(std::string_view content) {
  if (content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);
  if (content.substr(0, 4) == "PK\x03\x04") return "batten";
  if (content.substr(0, 4) == "glTF") return "glb";
  if (content.substr(0, 4) == "ply\n" || content.substr(0, 4) == "ply\r") return "ply";
  const std::string_view begin = trim(content.substr(0, 2000));
  if (lower_case(begin.substr(0, 5)) == "solid" &&
      lower_case(content.substr(0, 4000)).find("facet") != std::string::npos)
    return "stl";
  if (is_binary_stl(content)) return "stl";
  if (begin.substr(0, 1) == "{")
    return begin.find("\"batten_session\"") != std::string_view::npos ? "jsonl" : "json";
  if (begin.substr(0, 22) == "# batten curve network") return "obj";
  for (const std::string_view name : {"OFF", "COFF", "NOFF", "CNOFF", "NCOFF", "STOFF"})
    if (begin.substr(0, name.size()) == name) return "off";
  return extension_of_lines(first_lines(content, 2));
}

const std::string& standard_input() {
  static std::optional<std::string> content;
  if (!content) content = read_file("/dev/stdin");
  return *content;
}

bool standard_output_taken() {
  return output_taken.load();
}

void write_standard_output(std::string_view bytes) {
  output_taken = true;
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() || std::fflush(stdout) != 0)
    throw FileError("-", 0, concat("standard output cannot be written: ", std::strerror(errno)));
}

}  // namespace batten
