#include "batten/io/standard_streams.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <vector>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_formats_detail.hpp"

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

/// Of formats that begin with numbers or with words of their own.
std::string extension_of_lines(const std::vector<std::string_view>& lines) {
  if (lines.empty()) return {};
  const std::vector<std::string_view> words = split_blanks(lines[0]);
  for (const std::string_view word : {"v", "vn", "vt", "f", "o", "g", "l", "s", "t", "mtllib", "usemtl"})
    if (words[0] == word) return "obj";
  if (words[0] == "CURVE") return "txt";
  long count = 0;
  if (words.size() == 1 && parse_integer(words[0], count) && lines.size() > 1)
    // The vertices of a network follow, or the flags of the first curve of a scan.
    return split_blanks(lines[1]).size() >= 3 && split_blanks(lines[1])[1] != "#" ? "net" : "rawnet";
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
  const std::string_view begin = trim(content.substr(0, 2000));
  if (const auto mesh = detail::shown_mesh_format(content)) {
    // A text may begin with "solid" and be none.
    const bool is_stl = detail::is_binary_stl(content) ||
                        lower_case(content.substr(0, 4000)).find("facet") != std::string::npos;
    if (*mesh == MeshFormat::Ply) return "ply";
    if (*mesh == MeshFormat::Off) return "off";
    if (*mesh == MeshFormat::Gltf) return "glb";
    if (is_stl) return "stl";
  }
  if (detail::has_bytes_behind_facets(content)) return "stl";
  if (begin.substr(0, 1) == "{")
    return begin.find("\"batten_session\"") != std::string_view::npos ? "jsonl" : "json";
  if (begin.substr(0, 22) == "# batten curve network") return "obj";
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
