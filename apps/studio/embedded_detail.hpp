#pragma once
#include <cstddef>

// What embed_page writes: the table of the files of the page, and all their bytes one after the other.
namespace batten::studio {

struct EmbeddedFile {
  const char* path;
  const char* tag;
  std::size_t begin, size;
  std::size_t gzip_begin, gzip_size;  ///< of size 0 where packing saves nothing
};

extern const EmbeddedFile* const embedded_files;
extern const std::size_t n_embedded_files;
extern "C" const char batten_studio_page[];

}  // namespace batten::studio
