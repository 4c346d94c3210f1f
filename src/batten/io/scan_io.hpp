#pragma once
#include <string>

#include "batten/io/file.hpp"
#include "batten/scan/scan.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten {

/// Reads a rawnet file (S code 5.6): orientations and distances along curves, as text.
///
/// Per curve: boundary flag, closed flag, number of nodes, positions of the nodes among the readings (from
/// 1), numbers of the nodes (from 0 or from 1, kept as they are; "?" for nodes without one), number of
/// readings, and per reading a line `distance tangent(3) normal(3)`. `#` starts a comment; blank lines are
/// skipped. The comments `# unit: mm`,
/// `# tangents: to-next`, `# tangents: at-sample` and (in a curve) `# name: …` are understood.
/// A file that starts with 0 has the number of curves on the next line, then the path of one file per curve,
/// relative to its own folder.
///
/// Vectors are normalised. The result satisfies check_scan(); numbers of nodes may miss where there is a "?".
/// @param numbers MayMiss: also where nodes are not marked at all, so that the curves are not connected.
/// @throws FileError with file and line, what was expected and the remedy.
Scan read_rawnet(const std::string& path, NodeNumbers numbers = NodeNumbers::Needed);
/// The same from memory; `name` stands for the path in errors. Lists of files per curve are refused.
Scan parse_rawnet(std::string text, const std::string& name, NodeNumbers numbers = NodeNumbers::Needed);

/// Writes a rawnet file that read_rawnet() reads back as exactly the same scan; numbers of nodes may miss.
/// @throws FileError, or InvalidInput as check_scan().
void write_rawnet(const Scan& scan, const std::string& path);
/// The text that write_rawnet() puts into the file. @throws InvalidInput as check_scan().
std::string format_rawnet(const Scan& scan);

/// Reads a scan from either kind of file: rawnet, or a sensor log (*.csv, or any text file that begins with
/// the names of its columns), whose readings become orientations by scan_from_log().
/// @param options used for sensor logs alone. @param columns of logs of other programs, as read_sensor_log().
/// @param numbers as read_rawnet() takes it; logs number their nodes.
/// @throws FileError with file, line where there is one, and the remedy; InvalidInput as parse_log_columns().
LogScan read_scan(const std::string& path, const LogScanOptions& options = {},
                  const std::string& columns = {}, NodeNumbers numbers = NodeNumbers::Needed);
/// The same from memory; `name` stands for the path in errors.
LogScan parse_scan(std::string text, const std::string& name, const LogScanOptions& options = {},
                   const std::string& columns = {}, NodeNumbers numbers = NodeNumbers::Needed);

}  // namespace batten
