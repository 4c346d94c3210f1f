#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// What a file says of a mesh beyond its TriangleMesh: kept from reading to writing and left alone between.
/// m: number of triangles. Polygons hand on what is theirs to the triangles that they are split into.
struct MeshAttributes {
  /// A scalar property of a PLY element: its name and its type, one of char uchar short ushort int uint float
  /// double.
  struct Property {
    std::string name, type;
  };
  /// The scalar properties of the vertices in the order of the file, coordinates and normals included.
  /// Types are kept on writing where they hold the numbers exactly, else double is written.
  std::vector<Property> vertex_properties;
  /// Scalar properties of the faces, and per property its m values.
  std::vector<Property> face_properties;
  std::vector<Eigen::VectorXd> face_values;

  /// Words and which of them each triangle has; `of_face` has m entries, −1 for none, or is empty.
  struct Labels {
    std::vector<std::string> words;
    std::vector<int> of_face;
  };
  Labels objects, groups, materials;   ///< `o`, `g` and `usemtl` of OBJ, all of the line behind the keyword
  std::vector<std::string> libraries;  ///< `mtllib` of OBJ: files, relative to `folder`

  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> texture;  ///< texture coordinates
  Triangles texture_corners;               ///< m × 3 rows of `texture`, −1 for none; or 0 × 3
  std::vector<std::string> texture_files;  ///< `comment TextureFile` of PLY, relative to `folder`
  std::string folder;                      ///< of the file that was read
};

/// A mesh with what its file says beside it.
struct MeshFile {
  TriangleMesh mesh;
  MeshAttributes attributes;
};

/// read_mesh() that keeps the attributes: of PLY (types and order of properties, scalar properties of faces,
/// lists `texcoord`) and of OBJ (objects, groups, materials, texture coordinates). @throws as read_mesh().
MeshFile read_mesh_file(const std::string& path, std::vector<std::string>* warnings = nullptr);
MeshFile parse_mesh_file(std::string content, const std::string& path,
                         std::vector<std::string>* warnings = nullptr);

/// write_mesh() with the attributes that the format can hold. Files named relative to another folder than
/// that of `path` get their names changed so that they are found. @throws as write_mesh().
void write_mesh_file(const std::string& path, const MeshFile& file, const MeshWriteOptions& options = {});
std::string format_mesh_file(const MeshFile& file, MeshFormat format, const MeshWriteOptions& options = {});

/// What the attributes would lose in a format, in words; empty when nothing.
std::vector<std::string> losses_in_format(const MeshAttributes& attributes, MeshFormat format);

/// The attributes of a mesh for another one on the same surface: values and labels of every triangle are
/// those of the input's triangle nearest to its centre; texture coordinates stay where all three corners are
/// those of that triangle, bit for bit, and are dropped elsewhere. Time O((m + n) log m).
/// @param dropped receives a line when texture coordinates are dropped.
/// @pre both meshes have triangles.
MeshAttributes carried_attributes(const MeshFile& from, const TriangleMesh& to,
                                  std::vector<std::string>& dropped, const Progress& progress = {});

}  // namespace batten
