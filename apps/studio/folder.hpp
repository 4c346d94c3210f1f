#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The folder that a studio was started for: files by number, never by path.
namespace batten::studio {

/// A descriptor of the system that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool is_open() const { return number_ >= 0; }
  int number() const { return number_; }
  /// The caller closes it from now on.
  int release();

 private:
  int number_ = -1;
};

/// A file of the folder that may be opened.
struct ListedFile {
  int number = 0;
  std::string name;  ///< from the folder on, with slashes
  std::uint64_t size = 0;
};

struct Listing {
  std::vector<ListedFile> files;  ///< in the order of their names
  std::size_t left_out = 0;       ///< files beyond the most that are listed
};

/// A file that was opened to be sent.
struct OpenedBytes {
  Descriptor descriptor;
  std::uint64_t size = 0;
};

/// All its bytes. @throws Error where it is longer than kMostRead or cannot be read.
std::string read_all(const OpenedBytes& file);
inline constexpr std::uint64_t kMostRead = std::uint64_t{2} << 30;

/// What became of a file that was to be written.
struct Written {
  enum class Outcome { Done, BadName, Exists, Failed };
  Outcome outcome = Outcome::Done;
  std::string sentence;  ///< what is wrong, and what helps
  int number = 0;        ///< of the file, where it is done
};

/// Files below one folder. Hidden ones, other types than the studio reads and links that lead out are not
/// seen. A number stands for the same file as long as the server runs. For several threads at once.
class Folder {
 public:
  static constexpr std::size_t kMostFiles = 1000;
  static constexpr int kDeepest = 4;  ///< folders within folders

  /// @param place a folder, or a file: then this one alone is seen, and what is written later.
  /// @throws FileError where there is no such place.
  explicit Folder(const std::string& place);

  const std::string& name() const { return name_; }
  /// The number of the one file that the studio was started for.
  std::optional<int> first() const;

  /// Looks again what there is.
  Listing list();
  /// Nothing where there is no such number or the file is gone, was replaced by a link, or is no file.
  OpenedBytes open(long number) const;
  /// Writes a file into the folder itself: under another name first, so that nobody sees half a file.
  /// @param replace whether a file of this name may be replaced; a link is then replaced, not followed.
  Written write(const std::string& name, std::string_view bytes, bool replace);
  /// Makes an empty file in the folder itself, for what is written bit by bit; whoever writes it opens
  /// path().
  Written begin(const std::string& name);
  /// Takes a file away that begin() has made.
  void take_back(const std::string& name);
  std::string path(const std::string& name) const { return root_ + "/" + name; }

  /// What is wrong with the name of a file that is to be written; empty where nothing is.
  static std::string problem_of_name(std::string_view name);

 private:
  /// These two are called with the mutex held.
  int number_of(const std::string& relative);
  OpenedBytes open_numbered(long number) const;

  std::string root_;  // resolved, without a slash at its end
  std::string name_;
  Descriptor descriptor_;  // of the root
  bool one_file_ = false;
  mutable std::mutex mutex_;            // of what follows
  std::map<std::string, int> numbers_;  // by the resolved path from the root on
  std::vector<std::string> paths_;      // by number
};

}  // namespace batten::studio
