#include <algorithm>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// What a model amounts to, and whether it is sound.
namespace batten {

namespace {

int count_alive(const auto& elements) {
  return static_cast<int>(
      std::count_if(elements.begin(), elements.end(), [](const auto& e) { return e.alive; }));
}

}  // namespace

SketchCounts PolylineMesh::counts() const {
  SketchCounts counts;
  counts.vertices = count_alive(vertices_);
  counts.edges = count_alive(edges_);
  counts.faces = count_alive(faces_);
  std::vector<char> curve_seen(at(n_curves_), 0), side_seen(2 * edges_.size(), 0);
  DisjointSets connected(static_cast<int>(vertices_.size()));
  for (size_t e = 0; e < edges_.size(); ++e) {
    const SketchEdge& edge = edges_[e];
    if (!edge.alive) continue;
    if (!curve_seen[at(edge.curve)]) ++counts.curves;
    curve_seen[at(edge.curve)] = 1;
    connected.unite(edge.vertices[0], edge.vertices[1]);
    for (const bool backwards : {false, true}) {
      const int side = side_of(static_cast<int>(e), backwards);
      if (face_of(side) >= 0 || side_seen[at(side)]) continue;
      ++counts.boundary_loops;
      for (const int s : opening(side)) side_seen[at(s)] = 1;
    }
  }
  for (size_t v = 0; v < vertices_.size(); ++v)
    if (vertices_[v].alive && connected.root(static_cast<int>(v)) == static_cast<int>(v)) ++counts.components;
  counts.genus = (2 * counts.components - counts.boundary_loops - counts.euler_characteristic()) / 2;
  return counts;
}

std::string PolylineMesh::problem_of_edge(int number) const {
  const auto i = at(number);
  const SketchEdge& edge = edges_[i];
  if (!edge.alive) return {};
  const std::string name = concat("e", i);
  const auto [a, b] = edge.vertices;
  for (const int v : {a, b}) {
    if (v < 0 || at(v) >= vertices_.size() || !vertex(v).alive)
      return concat(name, " ends at v", v, ", which does not exist");
    const auto& around = vertex(v).edges;
    if (std::count(around.begin(), around.end(), static_cast<int>(i)) != 1)
      return concat("v", v, " does not list ", name);
  }
  if (a == b) return concat(name, " begins and ends at v", a);
  if (!edge.polyline || edge.polyline->n_points() < 2) return concat(name, " has no polyline");
  if (!edge.polyline->points().allFinite()) return concat(name, " has a point that is not finite");
  if (edge.polyline->front() != vertex(a).position || edge.polyline->back() != vertex(b).position)
    return concat("the polyline of ", name, " does not run from v", a, " to v", b);
  if (edge.curve < 0 || edge.curve >= n_curves_) return concat(name, " belongs to no curve");
  if (edge.faces[0] < 0 && edge.faces[1] < 0) return concat(name, " has no face");
  if (edge.faces[0] >= 0 && edge.faces[0] == edge.faces[1])
    return concat(name, " has f", edge.faces[0], " on both sides");
  for (const bool backwards : {false, true}) {
    const int f = edge.faces[backwards ? 1 : 0];
    if (f < 0) continue;
    if (at(f) >= faces_.size() || !face(f).alive)
      return concat(name, " names f", f, ", which does not exist");
    const auto& sides = face(f).sides;
    if (std::count(sides.begin(), sides.end(), side_of(static_cast<int>(i), backwards)) != 1)
      return concat("f", f, " does not walk along ", name);
  }
  return {};
}

std::string PolylineMesh::problem_of_face(int number) const {
  const auto i = at(number);
  const SketchFace& face = faces_[i];
  if (!face.alive) return {};
  if (face.sides.size() < 2) return concat("f", i, " has fewer than two sides");
  std::vector<int> corners;
  for (size_t k = 0; k < face.sides.size(); ++k) {
    const int side = face.sides[k], next = face.sides[(k + 1) % face.sides.size()];
    if (side < 0 || at(edge_of(side)) >= edges_.size() || !edge(edge_of(side)).alive)
      return concat("f", i, " walks along an edge that does not exist");
    if (face_of(side) != static_cast<int>(i)) return concat("e", edge_of(side), " does not name f", i);
    if (end_of(side) != start_of(next)) return concat("f", i, " is not closed at v", end_of(side));
    corners.push_back(start_of(side));
  }
  std::sort(corners.begin(), corners.end());
  if (const auto twice = std::adjacent_find(corners.begin(), corners.end()); twice != corners.end())
    return concat("f", i, " visits v", *twice, " twice");
  return {};
}

std::string PolylineMesh::problem_of_vertex(int number) const {
  const auto i = at(number);
  const SketchVertex& vertex = vertices_[i];
  if (!vertex.alive) return {};
  if (vertex.edges.size() < 2) return concat("v", i, " has fewer than two edges");
  for (const int e : vertex.edges)
    if (e < 0 || at(e) >= edges_.size() || !edge(e).alive ||
        (edge(e).vertices[0] != static_cast<int>(i) && edge(e).vertices[1] != static_cast<int>(i)))
      return concat("v", i, " lists e", e, ", which does not end there");
  // Faces around the vertex form one fan: turn around it from a border, or from anywhere, and count edges.
  const auto leaving = [&](int e) { return side_of(e, edge(e).vertices[0] != static_cast<int>(i)); };
  int start = leaving(vertex.edges.front());
  for (const int e : vertex.edges)
    if (face_of(opposite_side(leaving(e))) < 0) start = leaving(e);  // nothing lies before it
  size_t turned = 0;
  int side = start;
  do {
    ++turned;
    const int f = face_of(side);
    if (f < 0) break;
    const auto& sides = face(f).sides;
    const auto at = std::find(sides.begin(), sides.end(), side) - sides.begin();
    side = opposite_side(sides[(static_cast<size_t>(at) + sides.size() - 1) % sides.size()]);
  } while (side != start && turned <= vertex.edges.size());
  if (turned != vertex.edges.size()) return concat("the faces around v", i, " do not form one fan");
  return {};
}

std::string PolylineMesh::broken_invariant() const {
  std::string problem;
  for (int e = 0; e < static_cast<int>(edges_.size()) && problem.empty(); ++e) problem = problem_of_edge(e);
  for (int f = 0; f < static_cast<int>(faces_.size()) && problem.empty(); ++f) problem = problem_of_face(f);
  for (int v = 0; v < static_cast<int>(vertices_.size()) && problem.empty(); ++v)
    problem = problem_of_vertex(v);
  return problem;
}

std::string PolylineMesh::broken_by_edit() const {
  std::string problem;
  std::vector<int> vertices;
  for (const auto& [v, before] : change_.vertices.before) vertices.push_back(v);
  for (const auto& [e, before] : change_.edges.before) {
    if (problem.empty()) problem = problem_of_edge(e);
    if (edge(e).alive) vertices.insert(vertices.end(), edge(e).vertices.begin(), edge(e).vertices.end());
  }
  for (const auto& [f, before] : change_.faces.before)
    if (problem.empty()) problem = problem_of_face(f);
  for (const int v : vertices)
    if (problem.empty()) problem = problem_of_vertex(v);
  return problem;
}

}  // namespace batten
