#pragma once
#include <string>
#include <vector>

#include "batten/mesh/control_cage.hpp"

namespace batten {

/// Reads a cage for subdivision: the polygons of a PLY, OBJ, OFF or STL file as they are, none of them split.
/// OBJ also says what is sharp and what is curved:
///
///     t crease 2/1/0 4 7 2.5     the edge between vertices 4 and 7, counted from 0, with sharpness 2.5
///     t corner 1/1/0 4 10        vertex 4; 10 and more is sharp for ever
///     l 1 9 10 2                 the polyline of the edge between vertices 1 and 2, counted from 1
///
/// (the tags are those of OpenSubdiv's example shapes). A polyline may run along several edges; it is cut at
/// the vertices of faces. Vertices that no face uses are left out and the others renumbered in their order.
/// @param warnings receives what was left out.
/// @throws FileError naming the line, what was expected and the remedy.
ControlCage read_cage(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// read_cage() of bytes in memory; `path` gives the extension and stands in errors.
ControlCage parse_cage(std::string content, const std::string& path,
                       std::vector<std::string>* warnings = nullptr);

/// Writes a cage without splitting its polygons: OBJ with its tags and polylines, PLY and OFF with the faces
/// alone. STL is refused, as it holds triangles only.
/// @param normals n × 3 unit normals to write per vertex, or none.
/// @throws FileError when the file cannot be written or has another extension; InvalidInput when an index is
/// out of range.
void write_cage(const std::string& path, const ControlCage& cage, const Points& normals = Points(0, 3));

/// The bytes that write_cage() puts into the file.
std::string format_cage(const ControlCage& cage, const std::string& path,
                        const Points& normals = Points(0, 3));

}  // namespace batten
