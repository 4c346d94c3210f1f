#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// The mesh formats that are read and written. The exact grammar of each is in docs/files.md.
enum class MeshFormat {
  Ply,      ///< keeps everything; positions and values as double
  Obj,      ///< positions and normals
  Off,      ///< positions and normals (NOFF)
  Stl,      ///< corners only, in single precision when binary
  Gltf,     ///< read as .gltf and .glb, written as .glb: positions, normals and colours, in metres, single
            ///< precision
  ThreeMf,  ///< for printers: positions, read into metres from the unit of the file, written in millimetres
};

/// Reads a triangle mesh: PLY (ascii, binary of either byte order), OBJ, OFF, STL (ascii or binary), glTF
/// or 3MF, packed with gzip or not. The format is told by the content where that shows it, else by the
/// extension. Polygons are split into triangles; normals per vertex are brought to unit length.
/// @param warnings receives what a reader must tell: polygons that were split, parts that were left out.
/// @throws FileError naming the line (text) or the element (binary), what was expected and the remedy.
TriangleMesh read_mesh(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// read_mesh() of bytes in memory; `path` gives the extension and stands in errors.
TriangleMesh parse_mesh(std::string content, const std::string& path,
                        std::vector<std::string>* warnings = nullptr);

/// @throws FileError naming the accepted extensions when that of `path` is none of them.
MeshFormat mesh_format(std::string_view path);

/// Options of write_mesh().
struct MeshWriteOptions {
  /// Text instead of bytes, for PLY and STL (the others are text always). Numbers read back exactly.
  bool ascii = false;
  /// What a length of 1 of the mesh is, for the formats that have a unit: glTF and 3MF. Above 0.
  double metres_per_unit = 1;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Writes a mesh in the format of the extension. PLY keeps normals and values per vertex bit for bit.
/// @throws FileError when the file cannot be written; InvalidInput when an index is out of range.
void write_mesh(const std::string& path, const TriangleMesh& mesh, const MeshWriteOptions& options = {});

/// The bytes that write_mesh() puts into the file.
std::string format_mesh(const TriangleMesh& mesh, MeshFormat format, const MeshWriteOptions& options = {});

/// Whether a format holds faces of more than three corners.
bool holds_polygons(MeshFormat format);
/// Whether the numbers of a format have a unit.
bool has_unit(MeshFormat format);

/// What a mesh would lose in a format, in words; empty when nothing.
std::vector<std::string> losses_in_format(const TriangleMesh& mesh, MeshFormat format,
                                          const MeshWriteOptions& options = {});

}  // namespace batten
