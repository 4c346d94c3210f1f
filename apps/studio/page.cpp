#include "studio/page.hpp"

#include "studio/embedded_detail.hpp"
#include "studio/page_tag_detail.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::studio {

namespace fs = std::filesystem;

std::string mime_type(std::string_view path) {
  static const std::map<std::string, const char*, std::less<>> types = {
      {"html", "text/html; charset=utf-8"},
      {"js", "text/javascript; charset=utf-8"},
      {"mjs", "text/javascript; charset=utf-8"},
      {"css", "text/css; charset=utf-8"},
      {"json", "application/json"},
      {"map", "application/json"},
      {"webmanifest", "application/manifest+json"},
      {"wasm", "application/wasm"},
      {"svg", "image/svg+xml"},
      {"png", "image/png"},
      {"jpg", "image/jpeg"},
      {"webp", "image/webp"},
      {"ico", "image/x-icon"},
      {"woff2", "font/woff2"},
      {"txt", "text/plain; charset=utf-8"},
      {"md", "text/plain; charset=utf-8"},
  };
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string_view::npos || path[dot] != '.') return "application/octet-stream";
  const auto found = types.find(lower_case(path.substr(dot + 1)));
  return found == types.end() ? "application/octet-stream" : found->second;
}

Page Page::embedded() {
  Page page;
  for (std::size_t k = 0; k < n_embedded_files; ++k) {
    const EmbeddedFile& file = embedded_files[k];
    page.files_[file.path] = {std::string_view(batten_studio_page + file.begin, file.size),
                              std::string_view(batten_studio_page + file.gzip_begin, file.gzip_size),
                              file.tag, mime_type(file.path)};
  }
  return page;
}

Page Page::of_folder(const std::string& folder) {
  Page page;
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw FileError(folder, 0, "is no folder of a page");
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_symlink() || !entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    auto bytes =
        std::make_shared<std::string>(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    if (!in) throw FileError(entry.path().string(), 0, "cannot be read");
    const std::string path = fs::relative(entry.path(), folder).generic_string();
    page.files_[path] = {*bytes, {}, content_tag(*bytes), mime_type(path)};
    page.owned_.push_back(std::move(bytes));
  }
  return page;
}

const PageFile* Page::find(std::string_view path) const {
  const auto found = files_.find(path.empty() ? std::string_view("index.html") : path);
  return found == files_.end() ? nullptr : &found->second;
}

std::string_view no_page_html() {
  return "<!doctype html>\n<html lang=\"en\"><head><meta "
         "charset=\"utf-8\"><title>Batten</title></head><body>\n"
         "<h1>This program was built without the page of the studio</h1>\n"
         "<p>In the folder of the sources, <code>tools/build web</code> builds the page; after that "
         "<code>tools/build release batten_program</code> builds the program with it. "
         "<code>batten studio --page FOLDER</code> shows a page that was built elsewhere.</p>\n"
         "</body></html>\n";
}

std::string_view no_page_sentence() {
  return "this program was built without the page of the studio; 'tools/build web' builds the page, "
         "'tools/build release batten_program' the program with it";
}

}  // namespace batten::studio
