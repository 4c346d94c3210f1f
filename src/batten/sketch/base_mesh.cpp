#include "batten/sketch/base_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/sketch/coons.hpp"

namespace batten {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPointsOfTie = 32;  ///< segments of its polyline

size_t at(int i) {
  return static_cast<size_t>(i);
}

SharedPolyline along(const PolylineMesh& mesh, int side) {
  const SharedPolyline& polyline = mesh.edge(edge_of(side)).polyline;
  return (side & 1) != 0 ? reversed(*polyline) : polyline;
}

/// The faces that ties join to `start`, and the ties.
void faces_around_hole(const PolylineMesh& mesh, int start, std::vector<char>& seen, std::vector<int>& faces,
                       std::vector<int>& ties) {
  faces = {start};
  seen[at(start)] = 1;
  for (size_t k = 0; k < faces.size(); ++k)
    for (const int side : mesh.face(faces[k]).sides) {
      if (mesh.edge(edge_of(side)).drawn) continue;
      if ((side & 1) == 0 || mesh.face_of(opposite_side(side)) < 0) ties.push_back(edge_of(side));
      const int next = mesh.face_of(opposite_side(side));
      if (next < 0 || seen[at(next)] != 0) continue;
      seen[at(next)] = 1;
      faces.push_back(next);
    }
}

/// The closed walks of drawn sides around some faces.
std::vector<std::vector<int>> loops_around(const PolylineMesh& mesh, const std::vector<int>& faces) {
  std::map<int, int> side_from;  // per vertex the side that leaves it; an outline that touches itself is none
  for (const int f : faces)
    for (const int side : mesh.face(f).sides)
      if (mesh.edge(edge_of(side)).drawn && !side_from.insert({mesh.start_of(side), side}).second) return {};
  std::vector<std::vector<int>> loops;
  while (!side_from.empty()) {
    std::vector<int>& loop = loops.emplace_back();
    auto next = side_from.begin();
    while (next != side_from.end()) {
      loop.push_back(next->second);
      side_from.erase(next);
      next = side_from.find(mesh.end_of(loop.back()));
    }
    if (mesh.end_of(loop.back()) != mesh.start_of(loop.front())) return {};
  }
  return loops;
}

double length_of(const PolylineMesh& mesh, const std::vector<int>& loop) {
  double sum = 0;
  for (const int side : loop) sum += mesh.edge(edge_of(side)).polyline->length();
  return sum;
}

/// Curves for the ties of the holes: per edge of the model, null for those that are kept.
std::vector<SharedPolyline> laid_ties(const PolylineMesh& mesh) {
  std::vector<SharedPolyline> laid(mesh.edges().size());
  std::vector<char> seen(mesh.faces().size(), 0);
  for (size_t f = 0; f < mesh.faces().size(); ++f) {
    if (!mesh.faces()[f].alive || seen[f] != 0) continue;
    std::vector<int> faces, ties;
    faces_around_hole(mesh, static_cast<int>(f), seen, faces, ties);
    if (ties.empty()) continue;
    std::vector<std::vector<int>> loops = loops_around(mesh, faces);
    // Later edits may have cut the ring open; then the ties stay straight.
    if (loops.size() != 2) continue;
    const std::vector<int>& outer =
        length_of(mesh, loops[0]) > length_of(mesh, loops[1]) ? loops[0] : loops[1];
    std::vector<SharedPolyline> sides;
    std::map<int, int> corner_of;
    for (const int side : outer) {
      corner_of[mesh.start_of(side)] = static_cast<int>(sides.size());
      sides.push_back(along(mesh, side));
    }
    const FacePatch patch = associate_quad(sides);
    for (const int tie : ties) {
      const SketchEdge& edge = mesh.edge(tie);
      std::array<Vector2d, 2> ends;
      for (size_t k = 0; k < 2; ++k) {
        const auto corner = corner_of.find(edge.vertices[k]);
        ends[k] = corner != corner_of.end() ? patch.parameters[at(corner->second)]
                                            : patch.patch.nearest(mesh.vertex(edge.vertices[k]).position);
      }
      Points points = patch.patch.along(ends[0], ends[1], kPointsOfTie);
      // The hole need not lie on the patch: what is missing at the ends is spread over the tie.
      const Eigen::RowVector3d first = edge.polyline->front().transpose() - points.row(0);
      const Eigen::RowVector3d last = edge.polyline->back().transpose() - points.row(kPointsOfTie);
      for (int i = 0; i <= kPointsOfTie; ++i) {
        const double t = static_cast<double>(i) / kPointsOfTie;
        points.row(i) += (1 - t) * first + t * last;
      }
      points.row(0) = edge.polyline->front().transpose();
      points.row(kPointsOfTie) = edge.polyline->back().transpose();
      laid[at(tie)] = std::make_shared<Polyline>(std::move(points));
    }
  }
  return laid;
}

}  // namespace

SharedPolyline BaseMesh::polyline_of(int side) const {
  const SharedPolyline& polyline = edges[at(edge_of(side))].polyline;
  return (side & 1) != 0 ? reversed(*polyline) : polyline;
}

BaseMesh triquadrified(const PolylineMesh& mesh, SplitSearch search) {
  BaseMesh base;
  std::vector<int> vertex_of(mesh.vertices().size(), -1);
  for (size_t v = 0; v < mesh.vertices().size(); ++v) {
    if (!mesh.vertices()[v].alive) continue;
    vertex_of[v] = static_cast<int>(base.positions.size());
    base.positions.push_back(mesh.vertices()[v].position);
  }
  std::vector<char> is_halved(mesh.edges().size(), 0);
  bool has_faces = false;
  for (const SketchFace& face : mesh.faces()) {
    if (!face.alive) continue;
    has_faces = true;
    if (face.sides.size() == 2)
      for (const int side : face.sides) is_halved[at(edge_of(side))] = 1;
  }
  if (!has_faces) throw InvalidInput("the model has no faces; insert a closed curve first");

  const std::vector<SharedPolyline> ties = laid_ties(mesh);
  base.edges_of_edge.resize(mesh.edges().size());
  const auto add = [&](int from, int to, SharedPolyline polyline, double sharpness, bool drawn) {
    base.edges.push_back({from, to, std::move(polyline), sharpness, drawn});
    return static_cast<int>(base.edges.size()) - 1;
  };
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const SketchEdge& edge = mesh.edges()[e];
    if (!edge.alive) continue;
    const SharedPolyline polyline = ties[e] ? ties[e] : edge.polyline;
    const int from = vertex_of[at(edge.vertices[0])], to = vertex_of[at(edge.vertices[1])];
    const double middle = polyline->length() / 2;
    if (is_halved[e] != 0 && middle > 0) {
      const int between = static_cast<int>(base.positions.size());
      base.positions.push_back(polyline->at(middle));
      const auto [first, second] = cut(*polyline, middle, base.positions.back());
      base.edges_of_edge[e] = {add(from, between, first, edge.sharpness, edge.drawn),
                               add(between, to, second, edge.sharpness, edge.drawn)};
    } else {
      base.edges_of_edge[e] = {add(from, to, polyline, edge.sharpness, edge.drawn)};
    }
  }

  for (size_t f = 0; f < mesh.faces().size(); ++f) {
    const SketchFace& face = mesh.faces()[f];
    if (!face.alive) continue;
    std::vector<int> sides;
    for (const int side : face.sides) {
      std::vector<int> pieces = base.edges_of_edge[at(edge_of(side))];
      const bool backwards = (side & 1) != 0;
      if (backwards) std::reverse(pieces.begin(), pieces.end());
      for (const int piece : pieces) sides.push_back(side_of(piece, backwards));
    }
    const auto n = static_cast<int>(sides.size());
    std::vector<SharedPolyline> curves;
    std::vector<int> corners;
    for (const int side : sides) {
      const BaseEdge& edge = base.edges[at(edge_of(side))];
      curves.push_back(base.polyline_of(side));
      corners.push_back((side & 1) != 0 ? edge.to : edge.from);
    }
    const FaceSplit split = split_face(curves, search);
    std::map<std::pair<int, int>, int> diagonal_between;
    for (const Diagonal& diagonal : diagonals_of_split(curves, split))
      diagonal_between[{diagonal.from, diagonal.to}] =
          add(corners[at(diagonal.from)], corners[at(diagonal.to)], diagonal.polyline, 0, false);
    for (const std::vector<int>& part : split.parts) {
      BaseFace& own = base.faces.emplace_back();
      own.face = static_cast<int>(f);
      for (size_t k = 0; k < part.size(); ++k) {
        const int i = part[k], j = part[(k + 1) % part.size()];
        const auto found = diagonal_between.find(std::minmax(i, j));
        own.sides.push_back((i + 1) % n == j || found == diagonal_between.end()
                                ? sides[at(i)]
                                : side_of(found->second, i > j));
      }
    }
    if (split.parts.size() > 1) {
      ++base.n_divided;
      base.n_diagonals += static_cast<int>(diagonal_between.size());
      base.cost = base.cost + split.cost;
    }
  }
  return base;
}

}  // namespace batten
