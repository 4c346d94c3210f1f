#pragma once
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "batten/mesh/control_cage.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// Models made from cages, with a curve for every edge.
namespace batten::models {

/// The curve from one vertex of a cage to another, ends included.
using CurveOfEdge = std::function<Points(int from, int to)>;

inline PolylineMesh model_of_cage(const PolygonMesh& cage, const CurveOfEdge& curve) {
  std::vector<SketchVertex> vertices(static_cast<size_t>(cage.positions.rows()));
  std::vector<SketchEdge> edges;
  std::vector<SketchFace> faces;
  std::map<std::pair<int, int>, int> edge_between;
  for (Eigen::Index f = 0; f < cage.n_faces(); ++f) {
    const auto begin = static_cast<size_t>(cage.offsets[static_cast<size_t>(f)]),
               end = static_cast<size_t>(cage.offsets[static_cast<size_t>(f) + 1]);
    SketchFace face;
    face.alive = true;
    for (size_t c = begin; c < end; ++c) {
      const int from = cage.corners[c], to = cage.corners[c + 1 < end ? c + 1 : begin];
      const auto [found, is_new] =
          edge_between.insert({std::minmax(from, to), static_cast<int>(edges.size())});
      const int e = found->second;
      if (is_new) {
        SketchEdge edge;
        edge.vertices = {from, to};
        Points points = curve(from, to);
        for (const auto& [v, row] : {std::pair(from, Eigen::Index(0)), std::pair(to, points.rows() - 1)}) {
          SketchVertex& vertex = vertices[static_cast<size_t>(v)];
          if (vertex.edges.empty()) vertex.position = points.row(row);
          points.row(row) = vertex.position.transpose();  // curves that differ by rounding meet exactly
        }
        edge.polyline = std::make_shared<Polyline>(points);
        edge.curve = e;
        edge.alive = true;
        for (const int v : {from, to}) vertices[static_cast<size_t>(v)].edges.push_back(e);
        edges.push_back(edge);
      }
      const bool backwards = edges[static_cast<size_t>(e)].vertices[0] != from;
      edges[static_cast<size_t>(e)].faces[backwards ? 1 : 0] = static_cast<int>(f);
      face.sides.push_back(side_of(e, backwards));
    }
    faces.push_back(face);
  }
  for (SketchVertex& vertex : vertices) vertex.alive = true;
  const int n_curves = static_cast<int>(edges.size());
  return PolylineMeshReader::assemble(std::move(vertices), std::move(edges), std::move(faces), n_curves);
}

}  // namespace batten::models
