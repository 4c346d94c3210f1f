#pragma once
#include <string>
#include <vector>

#include "batten/camera/blobs.hpp"

namespace batten {

/// Reads what two cameras saw of a pen (docs/files.md, "Blobs"): one JSON object a line, the first of which
/// names the format. A frame may name an image instead of blobs. Frames, readings and events are put in order
/// of time; a last line that was not finished is left out with a note.
/// @param notes  takes what was left out
/// @throws FileError naming the line: no JSON, a field that is missing or of the wrong kind, numbers that are
/// not finite, a covariance that is none, a version that is newer than this program.
BlobRecording read_blobs(const std::string& path, std::vector<std::string>* notes = nullptr);
/// The same from memory; `name` stands for the path in errors.
BlobRecording parse_blobs(std::string text, const std::string& name,
                          std::vector<std::string>* notes = nullptr);

/// What parse_blobs() reads back as exactly the same.
std::string format_blobs(const BlobRecording& recording);
/// @throws FileError.
void write_blobs(const BlobRecording& recording, const std::string& path);

/// Reads poses of a pen over time: comma-separated values with the columns time_s, x, y, z (of the tip,
/// metres), dx, dy, dz (from the tip to the other end; made of unit length) and drawing (0 or 1), in any
/// order; others are passed over, and so are rows without numbers, in which a tracker had lost the pen.
/// @throws FileError naming the line.
std::vector<TimedPose> read_pen_poses(const std::string& path);
std::vector<TimedPose> parse_pen_poses(std::string text, const std::string& name);

/// The text that parse_pen_poses() reads.
std::string format_pen_poses(const std::vector<TimedPose>& poses);

}  // namespace batten
