#pragma once
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

// The files of the page. All of them are known at the start: a path that is asked for is looked up and never
// reaches the file system.
namespace batten::studio {

struct PageFile {
  std::string_view bytes;
  std::string_view gzip;  ///< the same packed; empty where that saves nothing
  std::string tag;        ///< of the content; for ETag
  std::string type;       ///< the MIME type
};

class Page {
 public:
  /// The page that the program was built with; without files where it was built without.
  static Page embedded();
  /// The files of a folder as they are now, for whoever works on the page.
  /// @throws FileError where there is no such folder or a file cannot be read.
  static Page of_folder(const std::string& folder);

  bool is_empty() const { return files_.empty(); }
  /// By its path without the first slash; null where there is no such file. The path "" is index.html.
  const PageFile* find(std::string_view path) const;

 private:
  std::map<std::string, PageFile, std::less<>> files_;
  std::vector<std::shared_ptr<const std::string>> owned_;  // what the views of a folder's files look at
};

/// The MIME type by the extension; application/octet-stream where it is unknown.
std::string mime_type(std::string_view path);

/// What is shown where the program was built without a page: how to build it.
std::string_view no_page_html();
std::string_view no_page_sentence();

}  // namespace batten::studio
