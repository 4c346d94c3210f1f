#pragma once
#include <string>
#include <vector>

#include "batten/camera/wand.hpp"

namespace batten {

/// Reads blobs of two cameras (docs/files.md#blobs), one JSON object per line:
/// `{"time": s, "camera": "left"|"right", "blobs": [[u, v], …]}`; what a blob holds beyond u and v is not
/// read. Rows of other kinds (inertial readings, buttons) and a first line with the format are passed over.
///
/// Frames of both cameras that were taken within `most_apart` seconds of each other become one; the others
/// are left out, because a wand in motion is elsewhere at another time.
/// @throws FileError with file, line and remedy; also where no frames of both cameras belong together.
std::vector<WandFrame> read_wand(const std::string& path, double most_apart = 0.001);
/// The same from memory; `name` stands for the path in errors.
std::vector<WandFrame> parse_wand(std::string text, const std::string& name, double most_apart = 0.001);

}  // namespace batten
