#include "batten/session/project.hpp"

#include <cstdint>
#include <cstring>
#include <limits>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/session/archive_detail.hpp"
#include "batten/session/edit_json.hpp"
#include "batten/session/journal.hpp"

namespace batten {

namespace {

using Json = nlohmann::ordered_json;

void put_number(std::string& out, double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<char>((bits >> (8 * i)) & 0xff));
}

void put_points(std::string& out, const Points& points) {
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (int k = 0; k < 3; ++k) put_number(out, points(i, k));
}

/// Takes doubles from the front of the stored coordinates.
class Coordinates {
 public:
  explicit Coordinates(const std::string& bytes) : bytes_(bytes) {}
  Points take(std::int64_t rows) {
    if (rows < 0 || static_cast<std::uint64_t>(rows) > (bytes_.size() - at_) / 24)
      throw InvalidInput("there are fewer coordinates than the model needs");
    Points points(rows, 3);
    for (Eigen::Index i = 0; i < rows; ++i)
      for (int k = 0; k < 3; ++k) {
        std::uint64_t bits = 0;
        for (int b = 0; b < 8; ++b)
          bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[at_++])) << (8 * b);
        std::memcpy(&points(i, k), &bits, sizeof bits);
      }
    return points;
  }

 private:
  const std::string& bytes_;
  size_t at_ = 0;
};

}  // namespace

std::string format_project(const Project& project) {
  const PolylineMesh& mesh = project.document.mesh();
  Json json = Json::object();
  json["batten_project"] = 1;
  json["unit"] = project.unit;
  json["curves"] = mesh.n_curves();
  std::string coordinates;
  // Removed elements are null: numbers stay what they were.
  Json& vertices = json["vertices"] = Json::array();
  for (const SketchVertex& vertex : mesh.vertices()) {
    if (!vertex.alive) {
      vertices.push_back(nullptr);
      continue;
    }
    vertices.push_back({{"edges", vertex.edges}, {"seam", vertex.is_seam}});
    put_points(coordinates, Points(vertex.position.transpose()));
  }
  Json& edges = json["edges"] = Json::array();
  for (const SketchEdge& edge : mesh.edges()) {
    if (!edge.alive) {
      edges.push_back(nullptr);
      continue;
    }
    edges.push_back({{"vertices", edge.vertices},
                     {"faces", edge.faces},
                     {"curve", edge.curve},
                     {"sharpness", edge.sharpness},
                     {"drawn", edge.drawn},
                     {"points", edge.polyline->n_points()}});
    put_points(coordinates, edge.polyline->points());
  }
  Json& faces = json["faces"] = Json::array();
  for (const SketchFace& face : mesh.faces())
    if (face.alive)
      faces.push_back(face.sides);
    else
      faces.push_back(nullptr);
  std::string journal = format_session_header(project.unit) + '\n';
  for (const Edit& edit : project.document.log()) journal += format_edit(edit) + '\n';
  return detail::format_archive(
      {{"project.json", json.dump(1) + '\n'}, {"coordinates.f64", coordinates}, {"journal.jsonl", journal}});
}

void write_project(const std::string& path, const Project& project) {
  const std::string bytes = format_project(project);
  if (bytes.size() >= std::numeric_limits<std::uint32_t>::max())
    throw FileError(path, 0, "the project is larger than 4 GB; draw strokes with fewer points");
  write_file(path, bytes);
}

Project parse_project(const std::string& bytes, const std::string& path, std::vector<std::string>* warnings) {
  Project project;
  PolylineMesh mesh;
  std::vector<SessionEdit> edits;
  try {
    const auto entries = detail::parse_archive(bytes);
    for (const char* name : {"project.json", "coordinates.f64", "journal.jsonl"})
      if (entries.count(name) == 0) throw InvalidInput(concat("the entry ", name, " is missing"));
    const Json json = Json::parse(entries.at("project.json"));
    if (json.at("batten_project") != 1)
      throw InvalidInput("version 1 of the project format is known, this is another");
    project.unit = json.at("unit").get<std::string>();
    Coordinates coordinates(entries.at("coordinates.f64"));
    std::vector<SketchVertex> vertices;
    for (const Json& stored : json.at("vertices")) {
      SketchVertex& vertex = vertices.emplace_back();
      if (stored.is_null()) continue;
      vertex.alive = true;
      vertex.edges = stored.at("edges").get<std::vector<int>>();
      vertex.is_seam = stored.at("seam").get<bool>();
      vertex.position = coordinates.take(1).row(0);
    }
    std::vector<SketchEdge> edges;
    for (const Json& stored : json.at("edges")) {
      SketchEdge& edge = edges.emplace_back();
      if (stored.is_null()) continue;
      edge.alive = true;
      edge.vertices = stored.at("vertices").get<std::array<int, 2>>();
      edge.faces = stored.at("faces").get<std::array<int, 2>>();
      edge.curve = stored.at("curve").get<int>();
      edge.sharpness = stored.at("sharpness").get<double>();
      edge.drawn = stored.at("drawn").get<bool>();
      const auto n = stored.at("points").get<std::int64_t>();
      if (n < 2) throw InvalidInput("an edge has fewer than two points");
      edge.polyline = std::make_shared<Polyline>(coordinates.take(n));
    }
    std::vector<SketchFace> faces;
    for (const Json& stored : json.at("faces")) {
      SketchFace& face = faces.emplace_back();
      if (stored.is_null()) continue;
      face.alive = true;
      face.sides = stored.get<std::vector<int>>();
    }
    // Every curve was made with an edge; more would only be a way to ask for memory.
    if (json.at("curves").get<std::int64_t>() < 0 ||
        json.at("curves").get<std::int64_t>() > static_cast<std::int64_t>(edges.size()))
      throw InvalidInput("there are more curves than edges");
    mesh = PolylineMeshReader::assemble(std::move(vertices), std::move(edges), std::move(faces),
                                        json.at("curves").get<int>());
    edits = parse_session(entries.at("journal.jsonl"), "journal.jsonl").edits;
  } catch (const Json::exception& error) {
    throw FileError(path, 0, concat("project.json is damaged: ", error.what()));
  } catch (const InvalidInput& error) {
    throw FileError(path, 0, error.what());
  }
  bool same = false;
  try {
    for (const SessionEdit& edit : edits) project.document.apply(edit.edit);
    same = project.document.mesh() == mesh;
  } catch (const RefusedEdit&) {
    same = false;
  }
  if (!same) {
    std::vector<Edit> log;
    log.reserve(edits.size());
    for (const SessionEdit& edit : edits) log.push_back(edit.edit);
    project.document = Document::restored(std::move(mesh), std::move(log));
    if (warnings)
      warnings->push_back(
          concat(path,
                 ": its journal does not lead to the stored model, which holds; what was done "
                 "before cannot be undone"));
  }
  return project;
}

Project read_project(const std::string& path, std::vector<std::string>* warnings) {
  return parse_project(read_file(path), path, warnings);
}

}  // namespace batten
