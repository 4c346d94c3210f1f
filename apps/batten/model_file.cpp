#include "model_file.hpp"

#include "commands/mesh_file.hpp"

#include <cstring>
#include <string_view>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/pipeline/shape_comparison.hpp"

namespace batten::cli {

namespace {

void take(MeshFile&& file, Model& model) {
  model.mesh = std::move(file.mesh);
  model.attributes = std::move(file.attributes);
}

}  // namespace

Model read_model(const std::string& path, std::vector<std::string>& warnings) {
  const std::string extension = input_extension(path);
  if (extension == "rawnet" || extension == "csv")
    throw FileError(path, 0,
                    "this is a scan, without positions; make a network of it first with `batten network`");
  Model model;
  model.path = path;
  std::vector<std::string> told;
  std::string content = read_file(path);
  if (holds_network(extension, content))
    model.network = parse_network(std::move(content), path, &told);
  else
    take(parse_mesh_file(std::move(content), path, &told), model);
  for (const std::string& warning : told) warnings.push_back(concat(path, ": ", warning));
  return model;
}

MeshFile read_mesh_to_process(const std::string& path, std::vector<std::string>& warnings, bool repair,
                              const Progress& progress) {
  MeshFile file = read_mesh_file(path, &warnings);
  commands::prepare_mesh(path, file, warnings, repair, progress);
  return file;
}

void write_made_mesh(const std::string& path, TriangleMesh mesh, const MeshFile& input, bool same_faces,
                     Outcome& outcome) {
  const MeshFile made = commands::made_file(std::move(mesh), input, same_faces, outcome.warnings);
  for (const std::string& loss : losses_in_format(made.attributes, mesh_format(path)))
    outcome.warnings.push_back(concat(path, ": ", loss));
  write_mesh_file(path, made);
}

void add_repair_flag(CLI::App& command, bool& repair) {
  command.add_flag("--repair", repair, "Mend the input first, as batten repair does");
}

Shape shape_of(const Model& model) {
  return model.mesh ? batten::shape_of(*model.mesh) : batten::shape_of(*model.network);
}

Json describe(const Model& model) {
  Json json = Json::object();
  json["file"] = model.path;
  json["kind"] = model.mesh ? "mesh" : "network";
  json["vertices"] = model.positions().rows();
  if (model.mesh)
    json["faces"] = model.mesh->n_triangles();
  else
    json["curves"] = model.network->curves.size();
  return json;
}

}  // namespace batten::cli
