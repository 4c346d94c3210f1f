#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/camera/calibration.hpp"

namespace batten {

/// Reads a stereo rig (docs/files.md#rigs). Figures of the calibration that the file does not give are 0.
/// @throws FileError with file, place and remedy: no JSON, no rig, a newer version, numbers out of range.
CalibratedRig read_rig(const std::string& path);
/// The same from memory; `name` stands for the path in errors.
CalibratedRig parse_rig(const std::string& text, const std::string& name);

/// Writes a rig that read_rig() reads back bit for bit.
/// @throws FileError; InvalidInput as problem() of the rig.
void write_rig(const CalibratedRig& rig, const std::string& path);

/// Size of an image, pixels.
struct ImageSize {
  int width = 0, height = 0;
};

/// Reads "640x480". @throws InvalidInput naming the form, unless both are 1 to 100000.
ImageSize parse_image_size(const std::string& text);

/// What is known of a file of corners beforehand.
struct CornersOptions {
  Board board;
  /// Of the images; nothing takes the one that the file names, else the smallest usual size that holds all
  /// corners, with a warning.
  std::optional<ImageSize> size;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Reads the corners of a board in pairs of images: rows `pair,camera,corner,col,row,x_px,y_px` (camera is
/// left or right; corner is not needed) or, without a line that names the columns, `pair,camera,col,row,x,y`.
///
/// **Pixels in the file are those of most programs, OpenCV among them: the centre of the first pixel is
/// (0, 0).** They become ours by adding 0.5. Comments `# image_size: 640x480` are understood.
/// @param warnings may be null.
/// @throws FileError with file and line: a corner beyond the board, twice, or outside of the image.
BoardPairs read_corners(const std::string& path, const CornersOptions& options,
                        std::vector<std::string>* warnings = nullptr);
/// The same from memory; `name` stands for the path in errors.
BoardPairs parse_corners(std::string text, const std::string& name, const CornersOptions& options,
                         std::vector<std::string>* warnings = nullptr);

/// Writes corners that read_corners() reads back; corners that were not seen have no row.
/// @throws FileError; InvalidInput as problem() of the pairs, or where the images of both cameras differ in
/// size.
void write_corners(const BoardPairs& pairs, const std::string& path);

}  // namespace batten
