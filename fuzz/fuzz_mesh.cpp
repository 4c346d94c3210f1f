#include <cstdint>
#include <string>

#include "batten/core/error.hpp"
#include "batten/io/cage_io.hpp"
#include "batten/io/mesh_io.hpp"

/// Whatever the bytes, under every extension: a mesh and a cage that can be written, or a sentence about the
/// file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string content(data, data + size);
  for (const char* name : {"input.ply", "input.obj", "input.off", "input.stl", "input.glb"}) {
    try {
      const batten::TriangleMesh mesh = batten::parse_mesh(content, name);
      batten::format_mesh(mesh, batten::MeshFormat::Ply);
    } catch (const batten::FileError&) {
      // The expected answer to broken input; anything else ends the run.
    }
    try {
      const batten::ControlCage cage = batten::parse_cage(content, name);
      batten::parse_cage(batten::format_cage(cage, "output.obj"), "output.obj");
    } catch (const batten::FileError&) {
    }
  }
  return 0;
}
