#include <cstdint>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/content_json_detail.hpp"
#include "batten/session/json_fields_detail.hpp"

namespace batten::detail {

namespace {

/// Takes points from the front of the stored coordinates.
class Coordinates {
 public:
  explicit Coordinates(Points points) : points_(std::move(points)) {}
  Points take(std::int64_t rows) {
    if (rows < 0 || rows > points_.rows() - at_)
      throw InvalidInput("there are fewer coordinates than the model needs");
    at_ += static_cast<Eigen::Index>(rows);
    return points_.middleRows(at_ - static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(rows));
  }

 private:
  Points points_;
  Eigen::Index at_ = 0;
};

/// The entries of a list, null ones among them: elements that were removed.
Json::List entries_of(const Fields& fields, const char* name) {
  const Json& value = fields.require(name);
  if (!value.is_list()) fields.fail(name, "a list");
  Json::List entries;
  entries.reserve(value.size());
  for (std::size_t i = 0; i < value.size(); ++i) entries.push_back(value.at(i));
  return entries;
}

std::array<int, 2> pair_of(const Fields& fields, const char* name) {
  const std::vector<int> pair = fields.integers(fields.require(name), name);
  if (pair.size() != 2) fields.fail(name, "two whole numbers");
  return {pair[0], pair[1]};
}

SketchVertex vertex_of(const Json& stored, Coordinates& coordinates) {
  SketchVertex vertex;
  if (stored.is_null()) return vertex;
  const Fields fields(stored, "a vertex of the model", {"edges", "seam"});
  vertex.alive = true;
  vertex.edges = fields.integers(fields.require("edges"), "edges");
  vertex.is_seam = fields.flag("seam");
  vertex.position = coordinates.take(1).row(0);
  return vertex;
}

SketchEdge sketch_edge_of(const Json& stored, Coordinates& coordinates) {
  SketchEdge edge;
  if (stored.is_null()) return edge;
  const Fields fields(stored, "an edge of the model",
                      {"vertices", "faces", "curve", "sharpness", "drawn", "points"});
  edge.alive = true;
  edge.vertices = pair_of(fields, "vertices");
  edge.faces = pair_of(fields, "faces");
  edge.curve = fields.integer_of(fields.require("curve"), "curve");
  edge.sharpness = fields.number_of(fields.require("sharpness"), "sharpness");
  edge.drawn = fields.flag("drawn");
  const int n = fields.integer_of(fields.require("points"), "points");
  if (n < 2) throw InvalidInput("an edge has fewer than two points");
  edge.polyline = std::make_shared<Polyline>(coordinates.take(n));
  return edge;
}

}  // namespace

Json json_of_model(const PolylineMesh& model) {
  Json::Numbers coordinates;
  const auto put_points = [&](const Points& points) {
    coordinates.insert(coordinates.end(), points.data(), points.data() + points.size());
  };
  // Removed elements are null: numbers stay what they were.
  Json::List vertices, edges, faces;
  for (const SketchVertex& vertex : model.vertices()) {
    Json& stored = vertices.emplace_back();
    if (!vertex.alive) continue;
    stored.add("edges", flat_list(vertex.edges));
    stored.add("seam", vertex.is_seam);
    put_points(vertex.position.transpose());
  }
  for (const SketchEdge& edge : model.edges()) {
    Json& stored = edges.emplace_back();
    if (!edge.alive) continue;
    stored.add("vertices", flat_list(std::vector<int>(edge.vertices.begin(), edge.vertices.end())));
    stored.add("faces", flat_list(std::vector<int>(edge.faces.begin(), edge.faces.end())));
    stored.add("curve", edge.curve);
    stored.add("sharpness", edge.sharpness);
    stored.add("drawn", edge.drawn);
    stored.add("points", static_cast<double>(edge.polyline->n_points()));
    put_points(edge.polyline->points());
  }
  for (const SketchFace& face : model.faces()) faces.push_back(face.alive ? flat_list(face.sides) : Json());
  Json json;
  json.add("curves", model.n_curves());
  json.add("vertices", std::move(vertices));
  json.add("edges", std::move(edges));
  json.add("faces", std::move(faces));
  json.add("coordinates", std::move(coordinates));
  return json;
}

PolylineMesh model_of(const Json& json) {
  const Fields fields(json, "the model", {"curves", "vertices", "edges", "faces", "coordinates"});
  Coordinates coordinates(fields.rows(fields.require("coordinates"), "coordinates"));
  std::vector<SketchVertex> vertices;
  for (const Json& stored : entries_of(fields, "vertices"))
    vertices.push_back(vertex_of(stored, coordinates));
  std::vector<SketchEdge> edges;
  for (const Json& stored : entries_of(fields, "edges")) edges.push_back(sketch_edge_of(stored, coordinates));
  std::vector<SketchFace> faces;
  for (const Json& stored : entries_of(fields, "faces")) {
    SketchFace& face = faces.emplace_back();
    face.alive = !stored.is_null();
    if (face.alive) face.sides = fields.integers(stored, "faces");
  }
  // Every curve was made with an edge; more would only be a way to ask for memory.
  const int n_curves = fields.integer_of(fields.require("curves"), "curves");
  if (n_curves < 0 || static_cast<std::size_t>(n_curves) > edges.size())
    throw InvalidInput("there are more curves than edges");
  return PolylineMeshReader::assemble(std::move(vertices), std::move(edges), std::move(faces), n_curves);
}

}  // namespace batten::detail
