#include <png.h>

#include "batten/core/error.hpp"
#include "batten/render/image.hpp"

namespace batten {

std::string encode_png(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = bytes.size();
  const bool done =
      png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr) != 0;
  png_image_free(&header);
  if (!done) throw Error("the picture could not be compressed as PNG");
  bytes.resize(size);
  return bytes;
}

}  // namespace batten
