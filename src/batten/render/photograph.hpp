#pragma once
#include <string>

#include "batten/camera/grey_image.hpp"

namespace batten {

/// Reads what a camera saw from a file: PNG, JPEG or binary PGM, told apart by content. Colours become
/// brightness (the luma of the format); an alpha channel is laid upon black.
/// @throws FileError when the file is missing, damaged, of another kind or larger than 16384 pixels along a
/// side; for a JPEG also where the program was built without libjpeg, with the remedy.
GreyImage read_photograph(const std::string& path);
/// The same from memory; `name` stands for the path in errors.
GreyImage parse_photograph(const std::string& bytes, const std::string& name);

}  // namespace batten
