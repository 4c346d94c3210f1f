#include "docs/documents.hpp"

#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace batten::test {

namespace fs = std::filesystem;

fs::path repository() {
  return BATTEN_SOURCE;
}

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::vector<std::string> files_of(const std::vector<std::string>& folders,
                                  const std::vector<std::string>& extensions) {
  std::vector<std::string> found;
  for (const std::string& folder : folders) {
    if (!fs::exists(repository() / folder)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(repository() / folder))
      if (entry.is_regular_file() && std::find(extensions.begin(), extensions.end(),
                                               entry.path().extension().string()) != extensions.end())
        found.push_back(fs::relative(entry.path(), repository()).generic_string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string slug(const std::string& heading) {
  std::string text = std::regex_replace(heading, std::regex("<[^>]*>"), "");
  text = std::regex_replace(text, std::regex("\\[([^\\]]*)\\]\\([^)]*\\)"), "$1");
  const std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t\r");
  text = begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c == ' ') result += '-';
    if (std::isalnum(c) != 0 || c == '-' || c == '_') result += static_cast<char>(std::tolower(c));
    if (c == 0xe2) i += 2;  // dashes, quotation marks and signs of mathematics go like other punctuation
    if (c >= 0x80 && c != 0xe2) result += text[i];
  }
  return result;
}

namespace {

/// Calls `use(line, number)` for every line outside ``` blocks and blocks set off by four blanks.
template <typename Use>
void each_prose_line(const std::string& text, const Use& use) {
  std::istringstream in(text);
  std::string line;
  bool fenced = false;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.rfind("```", 0) == 0) {
      fenced = !fenced;
      continue;
    }
    if (!fenced && line.rfind("    ", 0) != 0) use(line, number);
  }
}

Document read_document(const fs::path& file) {
  Document document;
  document.text = content(file);
  std::map<std::string, int> seen;
  each_prose_line(document.text, [&](const std::string& line, int) {
    static const std::regex heading("#{1,6} +(.*)"), id("<a id=\"([^\"]+)\">");
    std::smatch match;
    if (std::regex_match(line, match, heading)) {
      const std::string name = slug(match[1]);
      const int n = seen[name]++;
      document.anchors.insert(n == 0 ? name : name + "-" + std::to_string(n));
    }
    for (std::sregex_iterator it(line.begin(), line.end(), id), end; it != end; ++it)
      document.anchors.insert((*it)[1]);
  });
  return document;
}

}  // namespace

const std::map<std::string, Document>& documents() {
  static const std::map<std::string, Document> all = [] {
    std::map<std::string, Document> result;
    for (const fs::directory_entry& entry : fs::directory_iterator(repository()))
      if (entry.path().extension() == ".md")
        result[entry.path().filename().string()] = read_document(entry.path());
    for (const std::string& path :
         files_of({"apps", "bench", "benchmark", "data", "docs", "examples", "experiments", "fuzz", "plugins",
                   "python", "src", "tests", "tools", "workflows"},
                  {".md"}))
      result[path] = read_document(repository() / path);
    return result;
  }();
  return all;
}

std::vector<Link> links_of(const std::string& path, const std::string& text) {
  std::vector<Link> links;
  each_prose_line(text, [&](const std::string& line, int number) {
    static const std::regex link("\\]\\(([^()\\s]+)\\)"), code("`[^`]*`");
    const std::string prose = std::regex_replace(line, code, "``");
    for (std::sregex_iterator it(prose.begin(), prose.end(), link), end; it != end; ++it)
      if ((*it)[1].str().find("://") == std::string::npos) links.push_back({{path, number}, (*it)[1]});
  });
  return links;
}

std::string comment_of(const std::string& line) {
  const std::size_t at = line.find("//");
  return at == std::string::npos ? "" : line.substr(at);
}

std::vector<Room> rooms() {
  const fs::path root = repository() / "src/batten";
  std::smatch match;
  const std::string list = content(root / "CMakeLists.txt");
  if (!std::regex_search(list, match, std::regex("set\\(rooms ([^)]*)\\)")))
    throw std::runtime_error("src/batten/CMakeLists.txt does not list the rooms as set(rooms …)");
  std::vector<Room> result;
  std::istringstream names(match[1]);
  for (std::string name; names >> name;) {
    if (!fs::exists(root / name / "CMakeLists.txt")) continue;
    const std::string text = content(root / name / "CMakeLists.txt");
    Room room;
    room.name = name;
    if (std::regex_search(text, match, std::regex("PURPOSE \"([^\"]*)\""))) room.purpose = match[1];
    if (std::regex_search(text, match, std::regex("USES([a-z_\\s]*)"))) {
      std::istringstream uses(match[1]);
      for (std::string used; uses >> used;) room.uses.insert(used);
    }
    result.push_back(room);
  }
  return result;
}

}  // namespace batten::test
