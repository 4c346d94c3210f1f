#include "batten/modelling/base_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/modelling/coons.hpp"

namespace batten {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPointsOfTie = 32;  ///< segments of its polyline

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

/// A face in which holes were cut, as it was before.
struct Whole {
  std::shared_ptr<const CoonsPatch> patch;
  std::map<int, Vector2d> parameters;  ///< per vertex of the model
};

/// A line over a patch between two points that need not lie on it: what is missing at the ends is spread.
SharedPolyline line_over(const CoonsPatch& patch, const Vector2d& from, const Vector2d& to,
                         const Vector3d& first, const Vector3d& last) {
  Points points = patch.along(from, to, kPointsOfTie);
  const Eigen::RowVector3d off_first = first.transpose() - points.row(0);
  const Eigen::RowVector3d off_last = last.transpose() - points.row(kPointsOfTie);
  for (int i = 0; i <= kPointsOfTie; ++i) {
    const double t = static_cast<double>(i) / kPointsOfTie;
    points.row(i) += (1 - t) * off_first + t * off_last;
  }
  points.row(0) = first.transpose();
  points.row(kPointsOfTie) = last.transpose();
  return std::make_shared<Polyline>(std::move(points));
}

/// Curves for the ties of the holes: per edge of the model, null for those that are kept.
/// @param wholes per face of the model the whole that it is a part of, or null.
std::vector<SharedPolyline> laid_ties(const PolylineMesh& mesh,
                                      std::vector<std::shared_ptr<const Whole>>& wholes) {
  std::vector<SharedPolyline> laid(mesh.edges().size());
  wholes.assign(mesh.faces().size(), nullptr);
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
    const auto whole = std::make_shared<Whole>();
    whole->patch = std::make_shared<CoonsPatch>(patch.patch);
    for (const auto& [vertex, corner] : corner_of) whole->parameters[vertex] = patch.parameters[at(corner)];
    for (const int face : faces) {
      wholes[at(face)] = whole;
      for (const int side : mesh.face(face).sides) {
        const int v = mesh.start_of(side);
        if (whole->parameters.count(v) == 0)
          whole->parameters[v] = patch.patch.nearest(mesh.vertex(v).position);
      }
    }
    for (const int tie : ties) {
      const SketchEdge& edge = mesh.edge(tie);
      laid[at(tie)] =
          line_over(patch.patch, whole->parameters.at(edge.vertices[0]),
                    whole->parameters.at(edge.vertices[1]), edge.polyline->front(), edge.polyline->back());
    }
  }
  return laid;
}

/// Makes a base mesh step by step.
class BaseMeshMaker {
 public:
  BaseMeshMaker(const PolylineMesh& mesh, SplitSearch search) : mesh_(mesh), search_(search) {}

  BaseMesh run() {
    take_vertices();
    find_halved();
    take_edges();
    for (size_t f = 0; f < mesh_.faces().size(); ++f)
      if (mesh_.faces()[f].alive) divide_face(static_cast<int>(f));
    return std::move(base_);
  }

 private:
  /// A face of the model: its sides in the base mesh, and what its inside follows.
  struct Inside {
    std::vector<int> sides;
    std::vector<SharedPolyline> curves;  ///< per side
    std::vector<int> corners;            ///< per side, where it begins
    std::shared_ptr<const CoonsPatch> patch;
    std::vector<Vector2d> parameters;  ///< per corner, where there is a patch
    std::vector<char> is_line;         ///< per side: it runs along a line of the patch
  };

  int add(int from, int to, SharedPolyline polyline, double sharpness, bool drawn) {
    base_.edges.push_back({from, to, std::move(polyline), sharpness, drawn});
    return static_cast<int>(base_.edges.size()) - 1;
  }

  void take_vertices() {
    vertex_of_.assign(mesh_.vertices().size(), -1);
    for (size_t v = 0; v < mesh_.vertices().size(); ++v) {
      if (!mesh_.vertices()[v].alive) continue;
      vertex_of_[v] = static_cast<int>(base_.positions.size());
      base_.positions.push_back(mesh_.vertices()[v].position);
    }
  }

  /// Edges of faces with two sides are halved.
  void find_halved() {
    is_halved_.assign(mesh_.edges().size(), 0);
    bool has_faces = false;
    for (const SketchFace& face : mesh_.faces()) {
      if (!face.alive) continue;
      has_faces = true;
      if (face.sides.size() == 2)
        for (const int side : face.sides) is_halved_[at(edge_of(side))] = 1;
    }
    if (!has_faces) throw InvalidInput("the model has no faces; insert a closed curve first");
  }

  void take_edges() {
    const std::vector<SharedPolyline> ties = laid_ties(mesh_, wholes_);
    base_.edges_of_edge.resize(mesh_.edges().size());
    for (size_t e = 0; e < mesh_.edges().size(); ++e) {
      const SketchEdge& edge = mesh_.edges()[e];
      if (!edge.alive) continue;
      const SharedPolyline polyline = ties[e] ? ties[e] : edge.polyline;
      const int from = vertex_of_[at(edge.vertices[0])], to = vertex_of_[at(edge.vertices[1])];
      const double middle = polyline->length() / 2;
      if (is_halved_[e] != 0 && middle > 0) {
        const int between = static_cast<int>(base_.positions.size());
        base_.positions.push_back(polyline->at(middle));
        const auto [first, second] = cut(*polyline, middle, base_.positions.back());
        base_.edges_of_edge[e] = {add(from, between, first, edge.sharpness, edge.drawn),
                                  add(between, to, second, edge.sharpness, edge.drawn)};
      } else {
        base_.edges_of_edge[e] = {add(from, to, polyline, edge.sharpness, edge.drawn)};
      }
    }
  }

  Inside inside_of(const SketchFace& face) const {
    Inside own;
    std::vector<int>& sides = own.sides;
    for (const int side : face.sides) {
      std::vector<int> pieces = base_.edges_of_edge[at(edge_of(side))];
      const bool backwards = (side & 1) != 0;
      if (backwards) std::reverse(pieces.begin(), pieces.end());
      for (const int piece : pieces) sides.push_back(side_of(piece, backwards));
    }
    for (const int side : sides) {
      const BaseEdge& edge = base_.edges[at(edge_of(side))];
      own.curves.push_back(base_.polyline_of(side));
      own.corners.push_back((side & 1) != 0 ? edge.to : edge.from);
    }
    own.is_line.assign(sides.size(), 1);
    return own;
  }

  /// The inside follows the patch of the whole: that of the face before a hole was cut, or of the divided
  /// face, whose diagonals then do not show.
  void follow_patch(int f, Inside& own, FaceDiagonals& diagonals) const {
    const SketchFace& face = mesh_.faces()[at(f)];
    const auto n = static_cast<int>(own.sides.size());
    if (wholes_[at(f)] && face.sides.size() == own.sides.size()) {
      own.patch = wholes_[at(f)]->patch;
      for (const int side : face.sides)
        own.parameters.push_back(wholes_[at(f)]->parameters.at(mesh_.start_of(side)));
      for (int k = 0; k < n; ++k) {
        // Drawn sides run along the border of the patch or around the hole.
        const Vector2d &p = own.parameters[at(k)], &q = own.parameters[at((k + 1) % n)];
        const bool along_border =
            (p.x() == q.x() && (p.x() == 0 || p.x() == 1)) || (p.y() == q.y() && (p.y() == 0 || p.y() == 1));
        own.is_line[at(k)] = !mesh_.edge(edge_of(face.sides[at(k)])).drawn || along_border;
      }
      for (Diagonal& diagonal : diagonals.diagonals)
        diagonal.polyline =
            line_over(*own.patch, own.parameters[at(diagonal.from)], own.parameters[at(diagonal.to)],
                      own.curves[at(diagonal.from)]->front(), own.curves[at(diagonal.to)]->front());
    } else if (diagonals.patch) {
      own.patch = std::make_shared<CoonsPatch>(diagonals.patch->patch);
      own.parameters = diagonals.patch->parameters;
    }
  }

  void divide_face(int f) {
    Inside own = inside_of(mesh_.faces()[at(f)]);
    const auto n = static_cast<int>(own.sides.size());
    const FaceSplit split = split_face(own.curves, search_);
    FaceDiagonals diagonals = diagonals_of_split(own.curves, split);
    follow_patch(f, own, diagonals);
    std::map<std::pair<int, int>, int> diagonal_between;
    for (const Diagonal& diagonal : diagonals.diagonals)
      diagonal_between[{diagonal.from, diagonal.to}] =
          add(own.corners[at(diagonal.from)], own.corners[at(diagonal.to)], diagonal.polyline, 0, false);
    for (const std::vector<int>& part : split.parts) {
      BaseFace& made = base_.faces.emplace_back();
      made.face = f;
      made.patch = own.patch;
      for (size_t k = 0; k < part.size(); ++k) {
        const int i = part[k], j = part[(k + 1) % part.size()];
        const auto found = diagonal_between.find(std::minmax(i, j));
        const bool is_side = (i + 1) % n == j || found == diagonal_between.end();
        made.sides.push_back(is_side ? own.sides[at(i)] : side_of(found->second, i > j));
        if (own.patch) {
          made.parameters.push_back(own.parameters[at(i)]);
          made.is_line.push_back(is_side ? own.is_line[at(i)] : char(1));
        }
      }
    }
    if (split.parts.size() > 1) {
      ++base_.n_divided;
      base_.n_diagonals += static_cast<int>(diagonal_between.size());
      base_.cost = base_.cost + split.cost;
    }
  }

  const PolylineMesh& mesh_;
  SplitSearch search_;
  BaseMesh base_;
  std::vector<int> vertex_of_;                        ///< per vertex of the model, or −1
  std::vector<char> is_halved_;                       ///< per edge of the model
  std::vector<std::shared_ptr<const Whole>> wholes_;  ///< per face of the model, or none
};

}  // namespace

SharedPolyline BaseMesh::polyline_of(int side) const {
  const SharedPolyline& polyline = edges[at(edge_of(side))].polyline;
  return (side & 1) != 0 ? reversed(*polyline) : polyline;
}

BaseMesh triquadrified(const PolylineMesh& mesh, SplitSearch search) {
  return BaseMeshMaker(mesh, search).run();
}

}  // namespace batten
