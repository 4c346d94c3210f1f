#pragma once
#include <string>
#include <string_view>

namespace batten {

/// Whether a path means standard input or output: "-", or "FORMAT:-" with the extension of a format, as
/// "ply:-".
bool is_standard_stream(std::string_view path);

/// file_extension() of a file to read. For "-" the extension of the format that standard input shows by its
/// content; empty where it shows none. Reads all of standard input, which is kept for the readers that
/// follow.
/// @throws FileError where standard input cannot be read.
std::string input_extension(const std::string& path);

/// file_extension() of a file to write; `standard` for "-".
std::string output_extension(std::string_view path, std::string_view standard);

/// The extension of the format that a content shows by how it begins ("ply", "off", "stl", "obj", "json",
/// "net", "rawnet", "csv", "txt", "jsonl", "batten"), or nothing.
std::string extension_of_content(std::string_view content);

/// All of standard input, unpacked where it is compressed with gzip; read once.
/// @throws FileError where it cannot be read.
const std::string& standard_input();

/// Whether a file was written to standard output, where nothing else belongs then.
bool standard_output_taken();

/// Writes to standard output, and takes it. @throws FileError where it cannot be written.
void write_standard_output(std::string_view bytes);

}  // namespace batten
