#pragma once
#include "command.hpp"

#include <optional>
#include <string>
#include <vector>

#include "batten/io/mesh_attributes.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::cli {

/// What a file holds: a mesh or a curve network, never both.
struct Model {
  std::string path;
  std::optional<TriangleMesh> mesh;
  MeshAttributes attributes;  ///< of the mesh
  std::optional<CurveNetwork> network;

  const Points& positions() const { return mesh ? mesh->positions : network->positions; }
};

/// Reads a mesh or a network. The extension decides; an .obj is a mesh when it has faces.
/// @throws FileError as the readers; for a scan, with the advice to make a network of it first.
Model read_model(const std::string& path, std::vector<std::string>& warnings);

/// Reads a mesh to be processed, with what its file says beyond the triangles. A soup of triangles is welded;
/// with `repair` everything is mended that `batten repair` mends without options. What was done is told in
/// the warnings.
/// @throws FileError as the readers; InvalidInput with what mesh_problem() says.
MeshFile read_mesh_to_process(const std::string& path, std::vector<std::string>& warnings, bool repair,
                              const Progress& progress);

/// Writes a mesh made of `input` with the attributes of that: as they are where `same_faces`, else those of
/// carried_attributes(). What is dropped on the way and what the format cannot hold of them is told.
void write_made_mesh(const std::string& path, TriangleMesh mesh, const MeshFile& input, bool same_faces,
                     Outcome& outcome);

/// Adds --repair.
void add_repair_flag(CLI::App& command, bool& repair);

/// The triangles of a mesh, or the segments of a network.
Shape shape_of(const Model& model);

/// File, kind and counts, for the JSON object.
Json describe(const Model& model);

}  // namespace batten::cli
