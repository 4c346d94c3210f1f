#include "batten/engine/saved_file.hpp"

#include <algorithm>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"

namespace batten {

std::vector<std::string> formats_of(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::Scan:
      return {"rawnet"};
    case ObjectKind::Network:
      return {"json", "net", "obj"};
    case ObjectKind::Mesh:
      return {"ply", "obj", "stl", "3mf", "glb", "off"};
    default:
      return {};
  }
}

SavedFile save_file(const Content& content, const std::string& extension, const std::string& unit) {
  const std::vector<std::string> formats = formats_of(kind_of(content));
  std::string known;
  for (const std::string& format : formats) known += (known.empty() ? "" : ", ") + format;
  if (std::find(formats.begin(), formats.end(), extension) == formats.end())
    throw InvalidInput(concat("a ", word_of(kind_of(content)), " cannot be saved as '", extension, "'; ",
                              known.empty() ? "save the project" : concat("it can be saved as ", known)));
  SavedFile file;
  if (const auto* scan = std::get_if<SharedScan>(&content)) {
    file.bytes = format_rawnet(**scan);
  } else if (const auto* network = std::get_if<SharedNetwork>(&content)) {
    const NetworkFormat format = network_format("x." + extension);
    file.warnings = losses_in_format(**network, format);
    file.bytes = format_network(**network, format);
  } else if (const auto* mesh = std::get_if<SharedMesh>(&content)) {
    const MeshFormat format = mesh_format("x." + extension);
    MeshWriteOptions options;
    if (!unit.empty()) options.metres_per_unit = parse_length("1" + unit).value;
    file.warnings = losses_in_format(**mesh, format, options);
    file.bytes = format_mesh(**mesh, format, options);
  }
  return file;
}

}  // namespace batten
