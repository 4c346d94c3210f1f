#pragma once
#include <string>
#include <vector>

#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

/// What an OBJ file holds, for meshes and for curve networks alike. Indices are 0-based and checked.
struct ObjContent {
  std::vector<double> positions, normals;  // 3 each
  std::vector<int> face_offsets{0};
  std::vector<int> face_vertices;
  std::vector<int> face_normals;  // per corner, −1 where the file gives none
  std::vector<double> texture;    // 2 each
  std::vector<int> face_texture;  // per corner, −1 where the file gives none
  std::vector<double> colours;    // 3 for each vertex that has them behind its coordinates, 0 to 1
  MeshAttributes::Labels objects, groups, materials;  // per face
  std::vector<std::string> libraries;
  struct Line {
    std::string object;  // the last `o`
    std::string group;   // the last `g`
    std::vector<int> vertices;
    long line = 0;
  };
  std::vector<Line> lines;
  std::vector<RawMesh::Tag> tags;     // `t`: subdivision tags
  std::vector<std::string> comments;  // those that begin with `# batten`, without that
  std::vector<std::string> warnings;
  long n_points = 0;  // `p` statements
};

/// @throws FileError at the line of the first statement that is wrong.
ObjContent parse_obj(std::string content, const std::string& path);

}  // namespace batten::detail
