#include "model_file.hpp"

#include <cstring>
#include <string_view>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/mesh/areas.hpp"

namespace batten::cli {

namespace {

// Sixth powers of lengths occur (squared volumes): they must stay numbers.
constexpr double kSmallestSize = 1e-45, kLargestSize = 1e45;

/// True when a line of the text starts with an `f` and a blank: an OBJ with faces.
bool has_faces(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
    if (at + 1 < text.size() && text[at] == 'f' && (text[at + 1] == ' ' || text[at + 1] == '\t')) return true;
    at = text.find('\n', at);
    if (at == std::string_view::npos) return false;
    ++at;
  }
  return false;
}

}  // namespace

Model read_model(const std::string& path, std::vector<std::string>& warnings) {
  const std::string extension = file_extension(path);
  if (extension == "rawnet" || extension == "csv")
    throw FileError(path, 0,
                    "this is a scan, without positions; make a network of it first with `batten network`");
  Model model;
  model.path = path;
  std::vector<std::string> told;
  if (extension == "net" || extension == "json" || extension == "txt" || extension == "lop") {
    model.network = read_network(path, &told);
  } else if (extension == "obj") {
    std::string content = read_file(path);
    if (has_faces(content))
      model.mesh = parse_mesh(std::move(content), path, &told);
    else
      model.network = parse_network(std::move(content), path, &told);
  } else {
    model.mesh = read_mesh(path, &told);
  }
  for (const std::string& warning : told) warnings.push_back(concat(path, ": ", warning));
  return model;
}

TriangleMesh read_mesh_to_process(const std::string& path, std::vector<std::string>& warnings) {
  TriangleMesh mesh = read_mesh(path, &warnings);
  if (mesh.n_triangles() == 0)
    throw InvalidInput(concat(path, ": there are no faces, so nothing to process"));
  const double size = (mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff()).maxCoeff();
  if (size > 0 && !(size > kSmallestSize && size < kLargestSize))
    throw InvalidInput(concat(path, ": the mesh is ", size,
                              " large, where squares and volumes are out of the range of numbers; "
                              "give it in another unit"));
  if (!(face_areas(mesh.positions, mesh.triangles).maxCoeff() > 0))
    throw InvalidInput(concat(path, ": no face has an area; check the positions"));
  return mesh;
}

Shape shape_of(const TriangleMesh& mesh) {
  return {mesh.positions, mesh.triangles, Segments(0, 2)};
}

Shape shape_of(const CurveNetwork& network) {
  Eigen::Index n = 0;
  for (const NetworkCurve& curve : network.curves) n += static_cast<Eigen::Index>(curve.vertices.size()) - 1;
  Shape shape{network.positions, Triangles(0, 3), Segments(n, 2)};
  Eigen::Index s = 0;
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i)
      shape.segments.row(s++) << curve.vertices[i], curve.vertices[i + 1];
  return shape;
}

Shape shape_of(const Model& model) {
  return model.mesh ? shape_of(*model.mesh) : shape_of(*model.network);
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
