#pragma once
#include <string>

#include "batten/camera/grey_image.hpp"

// Reading of JPEG; not part of the library's interface.
namespace batten::detail {

/// Largest side of an image that is read.
constexpr int kLargestPhotograph = 16384;

/// The image in the bytes of a JPEG file. Without libjpeg there is jpeg_absent.cpp in its place.
/// @throws FileError naming `name` when it is damaged or too large.
GreyImage decode_jpeg(const std::string& bytes, const std::string& name);

}  // namespace batten::detail
