#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "batten/core/error.hpp"

namespace batten {

/// The extension of a path in lower case without its dot: "ply" for "A/b.PLY". A final ".gz" is looked
/// through: "off" for "bunny.off.gz"; of a standard stream the format named before it: "ply" for "ply:-".
/// Empty where there is none.
std::string file_extension(std::string_view path);

/// The extension of a path names no format that could be meant: a slip in the command, not in a file.
class UnknownExtension : public FileError {
 public:
  UnknownExtension(std::string_view path, std::string_view problem) : FileError(path, 0, problem) {}
};

/// The whole content of a file, or of a standard stream (standard_streams.hpp). A file compressed with gzip
/// is unpacked, whatever its name.
/// @throws FileError when it is missing, a directory, unreadable or its compression is damaged.
std::string read_file(const std::string& path);

/// Reads a text file line by line in constant memory. Knows gzip, Windows line ends and a byte-order mark.
class LineReader {
 public:
  /// @throws FileError as read_file().
  explicit LineReader(const std::string& path);
  /// Reads from memory instead; `name` stands for the path in errors.
  LineReader(std::string text, std::string name);
  ~LineReader();
  LineReader(LineReader&&) noexcept;
  LineReader& operator=(LineReader&&) noexcept;

  /// The next line without its end; valid until the next call. False after the last.
  /// @throws FileError when the file holds zero bytes or endless lines: it is not a text file then.
  bool next(std::string_view& line);
  /// The number of the line read last, 1-based; 0 before the first.
  long line_number() const;
  const std::string& path() const;
  /// @throws FileError always: at the line read last.
  [[noreturn]] void fail(std::string_view problem) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Writes a file under a temporary name beside its place and renames it in commit(), so that nobody ever
/// sees half a file. What exists but is no regular file (a pipe, /dev/stdout) is written directly, a standard
/// stream as a whole in commit(). What a killed process has left beside the file is removed.
class OutputFile {
 public:
  /// @throws FileError when the folder is missing or not writable.
  explicit OutputFile(const std::string& path);
  /// Without commit() the temporary file is removed and the old file stays as it was.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// @throws FileError when the disk is full.
  void write(std::string_view bytes);
  /// Puts the file in its place. @throws FileError when that fails; the temporary file is removed then.
  void commit();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// OutputFile in one call.
void write_file(const std::string& path, std::string_view content);

}  // namespace batten
