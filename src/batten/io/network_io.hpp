#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "batten/network/curve_network.hpp"

namespace batten {

/// The formats of curve networks. The exact grammar of each is in docs/files.md.
enum class NetworkFormat {
  Net,           ///< .net of S: positions, normals, boundary flags
  Obj,           ///< .obj with v, vn and l; names and flags as `o` and `g`
  Json,          ///< .json: everything, lossless
  CurveText,     ///< .txt: `CURVE k` and one point per line (read only)
  BSplines,      ///< .lop: a loop of B-spline curves, sampled when read (read only)
  CurvesOnMesh,  ///< .json of curves given by faces and barycentric coordinates of a mesh beside it (read
                 ///< only)
};

/// Reads a curve network. The format is that of the content where it shows, else by the extension.
/// Normals are brought to unit length. Curves share a vertex only where the file says so by index, save in
/// formats without indices (.txt, .lop), where a curve that ends on its own first point is closed and, in
/// .lop, each curve begins at the end of the one before.
/// @param warnings receives what a reader has to report: segments that were joined, parts that were left out.
/// @throws FileError naming the line, what was expected and the remedy.
CurveNetwork read_network(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// read_network() of bytes in memory; `path` gives the extension, stands in errors and is where the mesh of
/// CurvesOnMesh is looked for.
CurveNetwork parse_network(std::string content, const std::string& path,
                           std::vector<std::string>* warnings = nullptr);

/// Whether a file holds curves and no faces: by its extension (lower case, without a dot), an OBJ by its
/// content.
bool holds_network(std::string_view extension, std::string_view content);

/// The format that write_network() takes for a path: .net, .obj or .json.
/// @throws FileError naming these extensions when that of `path` is none of them.
NetworkFormat network_format(std::string_view path);

/// Writes a network as .net, .obj or .json, by extension. Numbers read back bit for bit.
/// @throws FileError when the file cannot be written; InvalidInput when an index is out of range.
void write_network(const std::string& path, const CurveNetwork& network);

/// The same as .json with the standard deviation of each vertex, in the unit of the network, under
/// "uncertainty". @pre the path is one of .json. @throws as write_network(); InvalidInput on another size.
void write_uncertain_network(const std::string& path, const CurveNetwork& network,
                             const Eigen::VectorXd& uncertainty);
/// What write_uncertain_network() wrote of it, per vertex of the file; empty where the file is of another
/// format or has none. @throws FileError as read_network().
Eigen::VectorXd read_network_uncertainty(const std::string& path);

/// The text that write_network() puts into the file. @pre format is Net, Obj or Json.
std::string format_network(const CurveNetwork& network, NetworkFormat format);

/// What a network would lose in a format, in words; empty when nothing.
std::vector<std::string> losses_in_format(const CurveNetwork& network, NetworkFormat format);

}  // namespace batten
