#include "batten/render/photograph.hpp"

#include <cctype>

#include <png.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/render/jpeg_detail.hpp"

namespace batten {

namespace {

void check_size(unsigned long width, unsigned long height, const std::string& name) {
  constexpr auto kLargest = static_cast<unsigned long>(detail::kLargestPhotograph);
  if (width < 1 || height < 1 || width > kLargest || height > kLargest)
    throw FileError(name, 0,
                    concat("is an image of ", width, " x ", height, " pixels; 1 to ", kLargest,
                           " along each side can be read"));
}

GreyImage decode_png(const std::string& bytes, const std::string& name) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) == 0)
    throw FileError(name, 0, concat("is no PNG that can be read: ", header.message));
  header.format = PNG_FORMAT_GRAY;
  GreyImage image;
  try {
    check_size(header.width, header.height, name);
    image.width = static_cast<int>(header.width);
    image.height = static_cast<int>(header.height);
    image.pixels.resize(PNG_IMAGE_SIZE(header));
  } catch (...) {
    png_image_free(&header);
    throw;
  }
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&header, &black, image.pixels.data(), 0, nullptr) == 0)
    throw FileError(name, 0, concat("is no PNG that can be read: ", header.message));
  return image;
}

/// "P5", width, height and the largest value, separated by blanks and comments; then one byte per pixel.
GreyImage decode_pgm(const std::string& bytes, const std::string& name) {
  std::size_t place = 2;
  const auto next = [&]() -> unsigned long {
    while (place < bytes.size() &&
           (bytes[place] == '#' || std::isspace(static_cast<unsigned char>(bytes[place])))) {
      if (bytes[place] == '#')
        while (place < bytes.size() && bytes[place] != '\n') ++place;
      else
        ++place;
    }
    unsigned long value = 0;
    const std::size_t first = place;
    while (place < bytes.size() && place < first + 6 && bytes[place] >= '0' && bytes[place] <= '9')
      value = 10 * value + static_cast<unsigned long>(bytes[place++] - '0');
    if (place == first) throw FileError(name, 0, "is a damaged PGM: its size is missing");
    return value;
  };
  const unsigned long width = next(), height = next(), most = next();
  check_size(width, height, name);
  if (most != 255) throw FileError(name, 0, "is a PGM of other than 8 bits per pixel; convert it to PNG");
  ++place;
  const std::size_t n = static_cast<std::size_t>(width) * height;
  if (place > bytes.size() || bytes.size() - place < n)
    throw FileError(name, 0, "is a damaged PGM: pixels are missing");
  GreyImage image;
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.pixels.assign(bytes.begin() + static_cast<std::ptrdiff_t>(place),
                      bytes.begin() + static_cast<std::ptrdiff_t>(place + n));
  return image;
}

}  // namespace

GreyImage read_photograph(const std::string& path) {
  return parse_photograph(read_file(path), path);
}

GreyImage parse_photograph(const std::string& bytes, const std::string& name) {
  if (bytes.rfind("\x89PNG", 0) == 0) return decode_png(bytes, name);
  if (bytes.rfind("\xff\xd8", 0) == 0) return detail::decode_jpeg(bytes, name);
  if (bytes.rfind("P5", 0) == 0) return decode_pgm(bytes, name);
  throw FileError(name, 0, "is no image that can be read; use PNG, JPEG or binary PGM");
}

}  // namespace batten
