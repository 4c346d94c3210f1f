#pragma once
#include <string>
#include <vector>

#include "batten/session/object.hpp"

namespace batten {

/// The content of a file as an object of a project.
struct OpenedFile {
  std::string name;  ///< of the file, without folder and extension
  std::string unit;  ///< as the file says, or empty
  Content content;
  std::vector<std::string> warnings;
};

/// A file in memory as an object: a scan (.rawnet, .csv and sensor logs), a network (.net, .json, .lop, .txt,
/// .obj with lines), a mesh (.ply, .obj, .off, .stl, .glb, .gltf, .3mf) or a calibration (.json). Not
/// projects and journals, which hold many objects.
/// @param name gives the extension and stands in errors.
/// @throws FileError naming the place and the remedy.
OpenedFile open_file(std::string bytes, const std::string& name);

}  // namespace batten
