#include "batten/io/file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <utility>

#include "batten/core/text.hpp"
#include "batten/io/standard_streams.hpp"

#ifndef __EMSCRIPTEN__
#include <csignal>
#include <filesystem>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <zlib.h>
#endif

namespace batten {

namespace {

constexpr size_t kBlock = size_t{1} << 20;
// Longer lines are no text that anybody writes: a node list of a million nodes has 7 MB.
constexpr size_t kLongestLine = size_t{1} << 26;

/// What stands between the name of a file and the rest of the name under which it is written.
constexpr const char* kPart = ".part-";

std::string reason(int error) {
  return error == 0 ? std::string("unknown reason") : std::string(std::strerror(error));
}

/// Bytes of a file from front to back.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills up to `size` bytes; 0 at the end.
  virtual size_t read(char* bytes, size_t size) = 0;
};

#ifndef __EMSCRIPTEN__
/// zlib reads plain files as they are and unpacks those that begin with the mark of gzip.
class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::string& path) : path_(path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
      throw FileError(path, 0, "is a folder, expected a file");
    errno = 0;
    file_ = gzopen(path.c_str(), "rb");
    if (file_ == nullptr) throw FileError(path, 0, concat("cannot be opened: ", reason(errno)));
    gzbuffer(file_, 1 << 17);
  }
  ~FileSource() override { gzclose(file_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  size_t read(char* bytes, size_t size) override {
    const int count = gzread(file_, bytes, static_cast<unsigned>(size));
    refuse_bomb(count);
    int status = Z_OK;
    const char* message = gzerror(file_, &status);
    if (count >= 0 && (status == Z_OK || status == Z_STREAM_END)) return static_cast<size_t>(count);
    if (status == Z_ERRNO) throw FileError(path_, 0, concat("cannot be read: ", reason(errno)));
    if (status == Z_BUF_ERROR) throw FileError(path_, 0, "the compressed file ends too early; copy it again");
    throw FileError(path_, 0, concat("the compressed file is damaged (", message, "); copy it again"));
  }

 private:
  /// Stops files that unpack to far more than anybody would write, before they fill the memory.
  void refuse_bomb(int count) {
    constexpr std::int64_t kHarmless = std::int64_t{1} << 26, kMost = std::int64_t{1} << 32, kRatio = 100;
    unpacked_ += std::max(count, 0);
    if (unpacked_ <= kHarmless || gzdirect(file_) != 0) return;
    if (unpacked_ > kMost || unpacked_ > kRatio * std::int64_t{gzoffset(file_)})
      throw FileError(
          path_, 0,
          concat("unpacks to more than ", unpacked_ > kMost ? "4 GB" : "100 times its size",
                 ", which a damaged or hostile file may do; unpack it with gunzip if it is meant"));
  }

  std::string path_;
  gzFile file_ = nullptr;
  std::int64_t unpacked_ = 0;
};
#else
/// The browser hands over files already unpacked.
class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "rb")) {
    if (file_ == nullptr) throw FileError(path, 0, concat("cannot be opened: ", reason(errno)));
  }
  ~FileSource() override { std::fclose(file_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  size_t read(char* bytes, size_t size) override {
    const size_t count = std::fread(bytes, 1, size, file_);
    if (std::ferror(file_) != 0) throw FileError(path_, 0, concat("cannot be read: ", reason(errno)));
    return count;
  }

 private:
  std::string path_;
  std::FILE* file_;
};
#endif

/// A name beside `path` that nobody else uses. The number of the process tells whether it is still needed.
std::string temporary_name(const std::string& path) {
  static thread_local std::random_device device;
  static const char* const kDigits = "0123456789abcdef";
  std::string name = path + kPart;
#ifndef __EMSCRIPTEN__
  name += std::to_string(getpid()) + "-";
#endif
  unsigned bits = device();
  for (int i = 0; i < 8; ++i, bits >>= 4) name += kDigits[bits & 15];
  return name;
}

#ifndef __EMSCRIPTEN__
/// Removes what killed processes have left beside a file: names of temporary_name() whose process is gone,
/// and which nobody holds locked (a process of another machine or container may have that number here).
void remove_abandoned(const std::string& place) {
  const std::filesystem::path path(place);
  const std::string begin = path.filename().string() + kPart;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(path.has_parent_path() ? path.parent_path() : ".", error),
       end;
       !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.compare(0, begin.size(), begin) != 0) continue;
    long process = 0;
    const std::string_view rest = std::string_view(name).substr(begin.size());
    if (!parse_integer(rest.substr(0, rest.find('-')), process) || process <= 0) continue;
    if (kill(static_cast<pid_t>(process), 0) == 0 || errno != ESRCH) continue;
    const int file = open(entry->path().c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) unlink(entry->path().c_str());
    close(file);
  }
}
#endif

/// Where to put the bytes so that links are followed and devices are not replaced by files.
/// @param direct set when the place is no regular file and must be written as it is.
std::string place_of(const std::string& path, bool& direct) {
  direct = false;
#ifndef __EMSCRIPTEN__
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return path;
  if (std::filesystem::is_directory(status)) throw FileError(path, 0, "is a folder; name a file in it");
  direct = !std::filesystem::is_regular_file(status);
  if (direct) return path;
  const std::filesystem::path resolved = std::filesystem::canonical(path, error);
  if (!error) return resolved.string();
#endif
  return path;
}

}  // namespace

std::string file_extension(std::string_view path) {
  const auto last_extension = [](std::string_view name) {
    const size_t dot = name.rfind('.');
    const size_t slash = name.find_last_of("/\\");
    if (dot == std::string_view::npos || (slash != std::string_view::npos && dot < slash))
      return std::string();
    return lower_case(name.substr(dot + 1));
  };
  if (is_standard_stream(path))
    return lower_case(path.substr(0, path.size() - std::min<size_t>(path.size(), 2)));
  const std::string extension = last_extension(path);
  return extension == "gz" ? last_extension(path.substr(0, path.size() - 3)) : extension;
}

std::string read_file(const std::string& path) {
  if (is_standard_stream(path)) return standard_input();
  FileSource source(path);
  std::string content;
  while (true) {
    const size_t size = content.size();
    if (content.capacity() < size + kBlock) content.reserve(2 * size + kBlock);
    content.resize(size + kBlock);
    const size_t count = source.read(content.data() + size, kBlock);
    content.resize(size + count);
    if (count == 0) return content;
  }
}

struct LineReader::Implementation {
  std::string path;
  std::unique_ptr<ByteSource> source;  // empty when all is in the buffer already
  std::string buffer;
  size_t begin = 0;  // of the next line in the buffer
  long line = 0;
  bool at_end = false;

  void check_text(size_t from) const {
    if (buffer.find('\0', from) != std::string::npos)
      throw FileError(path, line + 1, "this is not a text file; is the extension right?");
  }

  void skip_byte_order_mark() {
    if (buffer.compare(0, 3, "\xEF\xBB\xBF") == 0) begin = 3;
  }

  /// Makes room at the front and appends a block. False when there is nothing more.
  bool refill() {
    if (at_end || source == nullptr) return false;
    buffer.erase(0, begin);
    begin = 0;
    const size_t size = buffer.size();
    if (size > kLongestLine) throw FileError(path, line + 1, "this line has no end; is it a text file?");
    buffer.resize(size + kBlock);
    const size_t count = source->read(buffer.data() + size, kBlock);
    buffer.resize(size + count);
    check_text(size);
    at_end = count == 0;
    return !at_end;
  }
};

LineReader::LineReader(const std::string& path) : implementation_(std::make_unique<Implementation>()) {
  implementation_->path = path;
  if (is_standard_stream(path)) {
    implementation_->buffer = standard_input();
    implementation_->check_text(0);
  } else {
    implementation_->source = std::make_unique<FileSource>(path);
    implementation_->refill();
  }
  implementation_->skip_byte_order_mark();
}

LineReader::LineReader(std::string text, std::string name)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->path = std::move(name);
  implementation_->buffer = std::move(text);
  implementation_->check_text(0);
  implementation_->skip_byte_order_mark();
}

LineReader::~LineReader() = default;
LineReader::LineReader(LineReader&&) noexcept = default;
LineReader& LineReader::operator=(LineReader&&) noexcept = default;

bool LineReader::next(std::string_view& line) {
  Implementation& in = *implementation_;
  size_t searched = 0;  // bytes of this line known to hold no line end
  size_t end = std::string::npos;
  while (true) {
    end = in.buffer.find('\n', in.begin + searched);
    if (end != std::string::npos) break;
    searched = in.buffer.size() - in.begin;
    if (!in.refill()) break;
  }
  if (end == std::string::npos && in.begin >= in.buffer.size()) return false;
  const size_t stop = end == std::string::npos ? in.buffer.size() : end;
  line = std::string_view(in.buffer).substr(in.begin, stop - in.begin);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  in.begin = end == std::string::npos ? in.buffer.size() : end + 1;
  ++in.line;
  return true;
}

long LineReader::line_number() const {
  return implementation_->line;
}

const std::string& LineReader::path() const {
  return implementation_->path;
}

void LineReader::fail(std::string_view problem) const {
  throw FileError(implementation_->path, implementation_->line, problem);
}

struct OutputFile::Implementation {
  std::string path;       // as the caller names it
  std::string place;      // what is replaced
  std::string temporary;  // what is written; equal to `place` when written directly
  std::FILE* file = nullptr;
  bool is_stream = false;  // standard output
  std::string held;        // for it, until it is whole

  void discard() {
    if (file != nullptr) std::fclose(file);
    file = nullptr;
    if (temporary != place) std::remove(temporary.c_str());
  }

  [[noreturn]] void fail(int error) {
    discard();
    throw FileError(path, 0, concat("cannot be written: ", reason(error)));
  }
};

OutputFile::OutputFile(const std::string& path) : implementation_(std::make_unique<Implementation>()) {
  Implementation& out = *implementation_;
  bool direct = false;
  out.path = path;
  out.is_stream = is_standard_stream(path);
  if (out.is_stream) return;
  out.place = place_of(path, direct);
  out.temporary = direct ? out.place : temporary_name(out.place);
  errno = 0;
  out.file = std::fopen(out.temporary.c_str(), direct ? "wb" : "wbx");
  if (out.file == nullptr)
    throw FileError(path, 0, concat("cannot be written: ", reason(errno), "; does its folder exist?"));
#ifndef __EMSCRIPTEN__
  if (!direct) {
    flock(fileno(out.file), LOCK_EX | LOCK_NB);  // held until it is closed
    remove_abandoned(out.place);
  }
#endif
}

OutputFile::~OutputFile() {
  if (implementation_->file != nullptr) implementation_->discard();
}

void OutputFile::write(std::string_view bytes) {
  if (implementation_->is_stream) {
    implementation_->held += bytes;
    return;
  }
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), implementation_->file) != bytes.size())
    implementation_->fail(errno);
}

void OutputFile::commit() {
  Implementation& out = *implementation_;
  if (out.is_stream) {
    write_standard_output(out.held);
    return;
  }
  errno = 0;
  const bool written = std::fflush(out.file) == 0;
  const bool closed = std::fclose(out.file) == 0;
  out.file = nullptr;
  if (!written || !closed) out.fail(errno);
  if (out.temporary != out.place && std::rename(out.temporary.c_str(), out.place.c_str()) != 0)
    out.fail(errno);
}

void write_file(const std::string& path, std::string_view content) {
  OutputFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace batten
