#include "studio/folder.hpp"

#include "studio/gate.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestName = 120;
constexpr int kMostLookedAt =
    20000;  // entries of folders: whoever starts it for a whole disk gets a part of it

/// What the engine reads, and recordings; by the extension, through .gz.
bool is_readable(std::string_view name) {
  static const std::set<std::string, std::less<>> known = {"rawnet", "csv",  "net", "json",   "lop",
                                                           "txt",    "obj",  "ply", "off",    "stl",
                                                           "glb",    "gltf", "3mf", "batten", "blog"};
  return known.count(file_extension(name)) != 0;
}

/// What the studio makes, besides: no name that a shell or a desktop would run.
bool is_writable(std::string_view name) {
  static const std::set<std::string, std::less<>> known = {"step", "stp", "igs", "iges",
                                                           "png",  "svg", "html"};
  return !name.ends_with(".gz") && (is_readable(name) || known.count(file_extension(name)) != 0);
}

std::string reason() {
  return std::strerror(errno);
}

/// Opens a path without links below a folder, step by step: none of them may be a link. -1 where one is.
Descriptor open_beneath(int folder, const std::string& relative) {
  Descriptor at(fcntl(folder, F_DUPFD_CLOEXEC, 0));
  std::size_t begin = 0;
  while (at.is_open()) {
    const std::size_t slash = relative.find('/', begin);
    const bool is_last = slash == std::string::npos;
    const std::string part = relative.substr(begin, is_last ? slash : slash - begin);
    // Without O_NONBLOCK a pipe would hold the server.
    const int flags = O_RDONLY | O_CLOEXEC | O_NOFOLLOW | (is_last ? O_NONBLOCK : O_DIRECTORY);
    at = Descriptor(openat(at.number(), part.c_str(), flags));
    if (is_last) break;
    begin = slash + 1;
  }
  return at;
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// A file that was not there before, and no link.
constexpr int kNewFile = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;

/// What errno says of a file that was to be made.
Written failure_of(const std::string& name) {
  if (errno == EEXIST)
    return {Written::Outcome::Exists,
            concat("there is a file ", name, " already; choose another name or replace it"), 0};
  return {Written::Outcome::Failed, concat(name, " cannot be written: ", reason()), 0};
}

/// Gives a file its name where that is free. False with errno where it is not.
bool rename_if_free(int folder, const std::string& from, const std::string& to) {
#ifdef RENAME_NOREPLACE
  if (renameat2(folder, from.c_str(), folder, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == EEXIST) return false;
#endif
  // File systems without the flag: a second name fails where there is one already.
  if (linkat(folder, from.c_str(), folder, to.c_str(), 0) != 0) return false;
  unlinkat(folder, from.c_str(), 0);
  return true;
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

int Descriptor::release() {
  return std::exchange(number_, -1);
}

std::string read_all(const OpenedBytes& file) {
  if (file.size > kMostRead)
    throw Error(concat("the file has ", file.size, " bytes, more than the ", kMostRead, " that are read"));
  std::string bytes(file.size, '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::read(file.descriptor.number(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw Error("the file was shortened while it was read, or cannot be read");
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

Folder::Folder(const std::string& place) {
  std::error_code error;
  fs::path root = fs::canonical(place, error);
  if (error) throw FileError(place, 0, concat("cannot be opened: ", error.message()));
  std::string file;
  if (fs::is_regular_file(root)) {
    one_file_ = true;
    file = root.filename().string();
    root = root.parent_path();
  } else if (!fs::is_directory(root)) {
    throw FileError(place, 0, "is neither a folder nor a file");
  }
  root_ = root.string();
  name_ = root.filename().string();
  descriptor_ = Descriptor(::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!descriptor_.is_open()) throw FileError(place, 0, concat("cannot be opened: ", reason()));
  if (one_file_) number_of(file);
}

std::optional<int> Folder::first() const {
  return one_file_ ? std::optional(0) : std::nullopt;
}

int Folder::number_of(const std::string& relative) {
  const auto [place, is_new] = numbers_.emplace(relative, static_cast<int>(paths_.size()));
  if (is_new) paths_.push_back(relative);
  return place->second;
}

Listing Folder::list() {
  const std::lock_guard lock(mutex_);
  std::set<std::string> found;
  if (one_file_) {
    found.insert(paths_.begin(), paths_.end());
  } else {
    std::error_code error;
    fs::recursive_directory_iterator entry(root_, fs::directory_options::skip_permission_denied, error), end;
    for (int n = 0; !error && entry != end && n < kMostLookedAt; entry.increment(error), ++n) {
      const std::string name = entry->path().filename().string();
      std::error_code ignored;
      // Folders are never entered by a link (the iterator's default), so their paths are resolved ones.
      if (entry->is_directory(ignored) && (name[0] == '.' || entry.depth() >= kDeepest))
        entry.disable_recursion_pending();
      if (name[0] == '.' || !is_readable(name) || !entry->is_regular_file(ignored)) continue;
      const std::string resolved = fs::canonical(entry->path(), ignored).string();
      if (ignored || resolved.rfind(root_ == "/" ? root_ : root_ + "/", 0) != 0) continue;  // leads out
      if (!is_readable(resolved) || resolved.find("/.", root_.size()) != std::string::npos) continue;
      found.insert(resolved.substr(root_ == "/" ? 1 : root_.size() + 1));
    }
  }
  Listing listing;
  for (const std::string& relative : found) {
    if (listing.files.size() == kMostFiles) {
      ++listing.left_out;
      continue;
    }
    const int number = number_of(relative);
    OpenedBytes opened = open_numbered(number);
    if (opened.descriptor.is_open()) listing.files.push_back({number, relative, opened.size});
  }
  return listing;
}

OpenedBytes Folder::open(long number) const {
  const std::lock_guard lock(mutex_);
  return open_numbered(number);
}

OpenedBytes Folder::open_numbered(long number) const {
  OpenedBytes opened;
  if (number < 0 || number >= static_cast<long>(paths_.size())) return opened;
  Descriptor descriptor = open_beneath(descriptor_.number(), paths_[static_cast<std::size_t>(number)]);
  struct stat status {};
  if (!descriptor.is_open() || fstat(descriptor.number(), &status) != 0 || !S_ISREG(status.st_mode))
    return opened;
  opened.size = static_cast<std::uint64_t>(status.st_size);
  opened.descriptor = std::move(descriptor);
  return opened;
}

std::string Folder::problem_of_name(std::string_view name) {
  if (name.empty() || name.size() > kLongestName)
    return concat("the name of a file must have 1 to ", kLongestName, " bytes");
  if (name[0] == '.') return "the name of a file must not begin with a dot";
  for (const char c : name)
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 32 || c == 127)
      return "the name of a file must be a name alone, without folders and control characters";
  if (!is_writable(name)) return "the extension is not one that the studio writes";
  return {};
}

Written Folder::write(const std::string& name, std::string_view bytes, bool replace) {
  const std::lock_guard lock(mutex_);
  if (std::string problem = problem_of_name(name); !problem.empty())
    return {Written::Outcome::BadName, std::move(problem), 0};
  const std::string temporary = concat(".", name, ".part-", random_secret());
  Descriptor file(openat(descriptor_.number(), temporary.c_str(), kNewFile, 0666));
  const auto failed = [&] {
    Written outcome = failure_of(name);
    unlinkat(descriptor_.number(), temporary.c_str(), 0);
    return outcome;
  };
  if (!file.is_open() || !write_all(file.number(), bytes)) return failed();
  if (::close(file.release()) != 0) return failed();
  const bool renamed =
      replace ? renameat(descriptor_.number(), temporary.c_str(), descriptor_.number(), name.c_str()) == 0
              : rename_if_free(descriptor_.number(), temporary, name);
  if (!renamed) return failed();
  return {Written::Outcome::Done, {}, number_of(name)};
}

Written Folder::begin(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (std::string problem = problem_of_name(name); !problem.empty())
    return {Written::Outcome::BadName, std::move(problem), 0};
  const Descriptor file(openat(descriptor_.number(), name.c_str(), kNewFile, 0666));
  if (!file.is_open()) return failure_of(name);
  return {Written::Outcome::Done, {}, number_of(name)};
}

void Folder::take_back(const std::string& name) {
  unlinkat(descriptor_.number(), name.c_str(), 0);
}

}  // namespace batten::studio
