// Run by the build: the files of a folder as one file of bytes and a source that holds them.
//
//   embed_page FOLDER BYTES SOURCE
//
// BYTES has every file as it is and, where that is shorter by a tenth, packed with gzip. SOURCE takes it in
// by .incbin, which costs the compiler nothing; an array of numbers would cost it a minute.
#include "studio/page_tag_detail.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include <zlib.h>

namespace {

namespace fs = std::filesystem;

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 15 + 16, kBest = 9, kMemory = 8;
  if (deflateInit2(&stream, kBest, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot begin");
  std::string packed(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("zlib cannot end");
  return packed;
}

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const fs::path& path, const std::string& content) {
  std::ofstream out(path, std::ios::binary);
  out << content;
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

void embed(const fs::path& folder, const fs::path& bytes_path, const fs::path& source_path) {
  std::vector<fs::path> paths;
  if (fs::is_directory(folder))
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && !entry.is_symlink()) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::string all, table;
  for (const fs::path& path : paths) {
    const std::string bytes = read(path);
    const std::string packed = gzip(bytes);
    const bool pays = packed.size() < bytes.size() / 10 * 9;
    const std::size_t begin = all.size(), gzip_begin = begin + bytes.size();
    all += bytes;
    if (pays) all += packed;
    table += "    {R\"path(" + fs::relative(path, folder).generic_string() + ")path\", \"" +
             batten::studio::content_tag(bytes) + "\", " + std::to_string(begin) + ", " +
             std::to_string(bytes.size()) + ", " + std::to_string(gzip_begin) + ", " +
             std::to_string(pays ? packed.size() : 0) + "},\n";
  }
  write(bytes_path, all);
  write(source_path,
        "#include \"studio/embedded_detail.hpp\"\n\n"
        "asm(R\"(\n  .section .rodata\n  .global batten_studio_page\n  .balign 16\nbatten_studio_page:\n"
        "  .incbin \"" +
            fs::absolute(bytes_path).string() +
            "\"\n  .byte 0\n  .previous\n)\");\n\n"
            "namespace batten::studio {\n\nnamespace {\nconst EmbeddedFile table[] = {\n" +
            table +
            "    {\"\", \"\", 0, 0, 0, 0}};\n}  // namespace\n\n"
            "const EmbeddedFile* const embedded_files = table;\n"
            "const std::size_t n_embedded_files = " +
            std::to_string(paths.size()) + ";\n\n}  // namespace batten::studio\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: embed_page FOLDER BYTES SOURCE\n"), 2;
  try {
    embed(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "embed_page: %s\n", error.what());
    return 1;
  }
  return 0;
}
