#include "batten/io/zip_archive.hpp"

#include <array>
#include <cstdint>

#include "batten/core/error.hpp"

#ifndef __EMSCRIPTEN__
#include <zlib.h>
#endif

namespace batten {

namespace {

// Layout: PKWARE's APPNOTE 6.3, sections 4.3.7 (local header), 4.3.12 (central directory), 4.3.16 (its end).
constexpr std::uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50;
constexpr size_t kLocalSize = 30, kCentralSize = 46, kEndSize = 22;

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
}

std::uint32_t get(const std::string& bytes, size_t at, int n) {
  if (at + static_cast<size_t>(n) > bytes.size()) throw InvalidInput("the file is cut off");
  std::uint32_t value = 0;
  for (int i = 0; i < n; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + static_cast<size_t>(i)]))
             << (8 * i);
  return value;
}

/// The check sum of zip files: remainders of the reflected polynomial of APPNOTE 4.4.7, a byte at a time.
/// An own table, so that the browser needs no library of compression.
constexpr std::array<std::uint32_t, 256> kRemainders = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder >> 1) ^ ((remainder & 1) != 0 ? 0xedb88320u : 0u);
    table[byte] = remainder;
  }
  return table;
}();

std::uint32_t checksum(const std::string& content) {
  std::uint32_t sum = 0xffffffffu;
  for (const char c : content) sum = (sum >> 8) ^ kRemainders[(sum ^ static_cast<unsigned char>(c)) & 0xff];
  return ~sum;
}

/// What is packed by the method of zlib, whose size is said beforehand.
std::string inflated(const std::string& name, const std::string& packed, std::uint32_t size) {
#ifdef __EMSCRIPTEN__
  (void)packed, (void)size;
  throw InvalidInput("the entry " + name + " of the file is compressed; store it uncompressed");
#else
  // The method reaches a ratio of 1032; what people pack stays far below, and what is small does no harm.
  constexpr std::uint32_t kHarmless = 1u << 26, kRatio = 100;
  if (size > kHarmless && size / kRatio > packed.size())
    throw InvalidInput(
        "the entry " + name +
        " of the file unpacks to more than 100 times its size, which a damaged or hostile file "
        "may do; store it uncompressed if it is meant");
  std::string content(size, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(content.data());
  stream.avail_out = size;
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw InvalidInput("there is no memory to unpack the file");
  const int status = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (status != Z_STREAM_END || stream.avail_out != 0)
    throw InvalidInput("the entry " + name + " of the file is damaged");
  return content;
#endif
}

void put_common(std::string& out, const std::string& name, const std::string& content) {
  put(out, 20, 2);            // version needed
  put(out, 0, 2);             // flags
  put(out, 0, 2);             // stored
  put(out, 0, 2);             // time
  put(out, (1 << 5) | 1, 2);  // 1 January 1980, the first day there is
  put(out, checksum(content), 4);
  put(out, content.size(), 4);
  put(out, content.size(), 4);
  put(out, name.size(), 2);
  put(out, 0, 2);  // extra
}

}  // namespace

std::string format_archive(const std::map<std::string, std::string>& entries) {
  std::string out, directory;
  for (const auto& [name, content] : entries) {
    const size_t at = out.size();
    put(out, kLocal, 4);
    put_common(out, name, content);
    out += name + content;
    put(directory, kCentral, 4);
    put(directory, 20, 2);  // made by
    put_common(directory, name, content);
    put(directory, 0, 2);  // comment
    put(directory, 0, 2);  // disk
    put(directory, 0, 2);  // internal attributes
    put(directory, 0, 4);  // external attributes
    put(directory, at, 4);
    directory += name;
  }
  const size_t at = out.size();
  out += directory;
  put(out, kEnd, 4);
  put(out, 0, 4);  // disks
  put(out, entries.size(), 2);
  put(out, entries.size(), 2);
  put(out, directory.size(), 4);
  put(out, at, 4);
  put(out, 0, 2);  // comment
  return out;
}

std::map<std::string, std::string> parse_archive(const std::string& bytes) {
  if (bytes.size() < kEndSize || get(bytes, 0, 4) != kLocal)
    throw InvalidInput("this does not begin as a zip file");
  size_t end = bytes.size() - kEndSize;
  while (get(bytes, end, 4) != kEnd) {
    if (end == 0 || bytes.size() - end > 65557) throw InvalidInput("the file is cut off");
    --end;
  }
  const std::uint32_t n = get(bytes, end + 10, 2);
  size_t at = get(bytes, end + 16, 4);
  std::map<std::string, std::string> entries;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (get(bytes, at, 4) != kCentral) throw InvalidInput("the directory of the file is damaged");
    const std::uint32_t method = get(bytes, at + 10, 2), sum = get(bytes, at + 16, 4),
                        packed = get(bytes, at + 20, 4), size = get(bytes, at + 24, 4),
                        name_size = get(bytes, at + 28, 2), local = get(bytes, at + 42, 4);
    if (at + kCentralSize + name_size > bytes.size()) throw InvalidInput("the file is cut off");
    const std::string name = bytes.substr(at + kCentralSize, name_size);
    constexpr std::uint32_t kStored = 0, kDeflated = 8;
    if (method != kStored && method != kDeflated)
      throw InvalidInput("the entry " + name + " of the file is packed by a method that is not read");
    if (get(bytes, local, 4) != kLocal) throw InvalidInput("the entry " + name + " of the file is damaged");
    const size_t start = local + kLocalSize + get(bytes, local + 26, 2) + get(bytes, local + 28, 2);
    if (start > bytes.size() || packed > bytes.size() - start) throw InvalidInput("the file is cut off");
    std::string content = bytes.substr(start, packed);
    if (method == kDeflated) content = inflated(name, content, size);
    if (checksum(content) != sum) throw InvalidInput("the entry " + name + " of the file is damaged");
    entries[name] = std::move(content);
    at += kCentralSize + name_size + get(bytes, at + 30, 2) + get(bytes, at + 32, 2);
  }
  return entries;
}

}  // namespace batten
