#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/render/jpeg_detail.hpp"

namespace batten::detail {

namespace {

/// libjpeg reports damage by calling back, and wants to be left by a long jump.
struct ErrorManager {
  jpeg_error_mgr standard;  // first, so that libjpeg's pointer to it is one to this
  std::jmp_buf place;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr state) {
  auto* manager = reinterpret_cast<ErrorManager*>(state->err);
  manager->standard.format_message(state, manager->message);
  std::longjmp(manager->place, 1);
}

void keep_silent(j_common_ptr) {}

/// Calls libjpeg. Nothing in here has a destructor: a long jump would pass it by. @return whether it went
/// well.
bool decode(const std::string& bytes, GreyImage& image, ErrorManager& manager, bool& too_large) {
  jpeg_decompress_struct state{};
  state.err = jpeg_std_error(&manager.standard);
  manager.standard.error_exit = leave;
  manager.standard.output_message = keep_silent;
  if (setjmp(manager.place) != 0) {
    jpeg_destroy_decompress(&state);
    return false;
  }
  jpeg_create_decompress(&state);
  jpeg_mem_src(&state, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&state, TRUE);
  too_large = state.image_width > static_cast<JDIMENSION>(kLargestPhotograph) ||
              state.image_height > static_cast<JDIMENSION>(kLargestPhotograph);
  if (!too_large) {
    state.out_color_space = JCS_GRAYSCALE;
    jpeg_start_decompress(&state);
    image.width = static_cast<int>(state.output_width);
    image.height = static_cast<int>(state.output_height);
    image.pixels.resize(static_cast<std::size_t>(state.output_width) * state.output_height);
    while (state.output_scanline < state.output_height) {
      JSAMPROW row = &image.pixels[static_cast<std::size_t>(state.output_scanline) * state.output_width];
      jpeg_read_scanlines(&state, &row, 1);
    }
    jpeg_finish_decompress(&state);
  }
  jpeg_destroy_decompress(&state);
  return true;
}

}  // namespace

GreyImage decode_jpeg(const std::string& bytes, const std::string& name) {
  GreyImage image;
  ErrorManager manager{};
  bool too_large = false;
  if (!decode(bytes, image, manager, too_large))
    throw FileError(name, 0, concat("is no JPEG that can be read: ", manager.message));
  if (too_large)
    throw FileError(name, 0, concat("is larger than ", kLargestPhotograph, " pixels along a side"));
  // Damage in the middle is only warned of: half of the picture would be grey then.
  if (manager.standard.num_warnings > 0) throw FileError(name, 0, "is a damaged JPEG; copy it again");
  return image;
}

}  // namespace batten::detail
