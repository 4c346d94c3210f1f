#include <algorithm>
#include <memory>
#include <utility>

#include "batten/core/index.hpp"
#include "batten/modelling/coons.hpp"
#include "batten/modelling/edge_courses_detail.hpp"
#include "batten/modelling/surface_records_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// The Coons patch of a loop laid out on the unit square: its four sides are the points between the corners
/// of the square. It follows tubes, which a plate through few curves does not.
/// @param square of the loop, n × 2, by arc length between the corners; points, n × 3. Both
/// counter-clockwise.
CoonsPatch patch_over_square(const PlanePoints& square, const Points& points) {
  static const std::array<Eigen::RowVector2d, 4> kCorners{Eigen::RowVector2d(0, 0), Eigen::RowVector2d(1, 0),
                                                          Eigen::RowVector2d(1, 1), Eigen::RowVector2d(0, 1)};
  const Index n = square.rows();
  std::array<Index, 4> at_corner{};
  for (Index i = 0; i < n; ++i)
    for (size_t c = 0; c < 4; ++c)
      if ((square.row(i) - kCorners[c]).norm() < 1e-12) at_corner[c] = i;
  std::array<SharedPolyline, 4> sides;
  for (size_t c = 0; c < 4; ++c) {
    const Index count = (at_corner[(c + 1) % 4] - at_corner[c] + n) % n;
    Points side(count + 1, 3);
    for (Index i = 0; i <= count; ++i) side.row(i) = points.row((at_corner[c] + i) % n);
    sides[c] = std::make_shared<Polyline>(std::move(side));
  }
  return CoonsPatch(std::move(sides));
}

/// What decides into how many parts the sides of a face are divided.
FaceSides measures_of(const PolylineMesh& mesh, const SketchFace& face) {
  constexpr int kSamplesPerEdge = 8;
  FaceSides measures;
  std::vector<Points> sides;
  for (const int side : face.sides) {
    const SketchEdge& edge = mesh.edge(edge_of(side));
    Points samples = course_of_edge(mesh, edge, kSamplesPerEdge);
    if (side & 1) samples = samples.colwise().reverse().eval();
    measures.edges.push_back(edge_of(side));
    measures.lengths.push_back(polyline_length(samples));
    sides.push_back(std::move(samples));
  }
  measures.corners = corners_of_quadrilateral(sides);
  measures.parts = parts_at_concave_corners(sides);
  return measures;
}

}  // namespace

int SurfaceRecords::add(const Vector3d& position) {
  int v = static_cast<int>(positions.size());
  if (unused.empty()) {
    positions.push_back(position), targets.push_back(position), cage.push_back(position);
    started.push_back(position);
    local.push_back(-1);
  } else {
    v = unused.back();
    unused.pop_back();
    positions[at(v)] = targets[at(v)] = cage[at(v)] = position;
  }
  return v;
}

void SurfaceRecords::release(std::vector<int>& vertices) {
  unused.insert(unused.end(), vertices.rbegin(), vertices.rend());
  vertices.clear();
}

std::vector<int> SurfaceRecords::along(int side) const {
  std::vector<int> chain = edges[at(edge_of(side))].chain;
  if (side & 1) std::reverse(chain.begin(), chain.end());
  return chain;
}

/// Takes over what is new in a model, step by step.
class Adoption {
 public:
  Adoption(SurfaceRecords& own, const PolylineMesh& mesh) : own_(own), mesh_(mesh) {
    own_.edges.resize(std::max(own_.edges.size(), mesh.edges().size()));
    own_.faces.resize(std::max(own_.faces.size(), mesh.faces().size()));
    own_.of_vertex.resize(std::max(own_.of_vertex.size(), mesh.vertices().size()), -1);
  }

  void run() {
    find_new_faces();
    count_parts();
    drop_edges();
    follow_vertices();
    follow_edges();
    for (const size_t f : new_faces_)
      if (face_now(f).alive) own_.split(own_.faces[f], face_now(f));
  }

 private:
  // A model that was undone may have fewer curves than before: what is not in it is not alive.
  const SketchEdge& edge_now(size_t e) const {
    static const SketchEdge no_edge;
    return e < mesh_.edges().size() ? mesh_.edges()[e] : no_edge;
  }
  const SketchFace& face_now(size_t f) const {
    static const SketchFace no_face;
    return f < mesh_.faces().size() ? mesh_.faces()[f] : no_face;
  }
  const SketchVertex& vertex_now(size_t v) const {
    static const SketchVertex no_vertex;
    return v < mesh_.vertices().size() ? mesh_.vertices()[v] : no_vertex;
  }

  bool is_new(size_t f) const {
    const FaceRecord& face = own_.faces[f];
    const SketchFace& now = face_now(f);
    if (face.alive != now.alive) return true;
    if (!now.alive) return false;
    return face.sides != now.sides || std::any_of(now.sides.begin(), now.sides.end(), [&](int side) {
             return !own_.edges[at(edge_of(side))].same(edge_now(at(edge_of(side))));
           });
  }

  void forget(size_t f) {
    own_.release(own_.faces[f].inner);
    own_.faces[f] = FaceRecord();
  }

  void find_new_faces() {
    for (size_t f = 0; f < own_.faces.size(); ++f)
      if (is_new(f)) new_faces_.push_back(f);
    for (const size_t f : new_faces_) {
      forget(f);
      if (face_now(f).alive) own_.faces[f].measures = measures_of(mesh_, face_now(f));
    }
  }

  /// Faces whose sides have other numbers of parts than before are split anew.
  void count_parts() {
    std::vector<const FaceSides*> measures(own_.faces.size(), nullptr);
    for (size_t f = 0; f < own_.faces.size(); ++f)
      if (face_now(f).alive) measures[f] = &own_.faces[f].measures;
    parts_ = parts_of_edges(own_.edges.size(), measures);
    for (size_t e = 0; e < own_.edges.size(); ++e) {
      if (!own_.edges[e].alive || !edge_now(e).alive || own_.edges[e].parts == parts_[e]) continue;
      for (const int f : edge_now(e).faces)
        if (f >= 0 && own_.faces[at(f)].alive) {
          FaceSides kept = std::move(own_.faces[at(f)].measures);
          forget(at(f));
          own_.faces[at(f)].measures = std::move(kept);
          new_faces_.push_back(at(f));
        }
    }
    std::sort(new_faces_.begin(), new_faces_.end());
  }

  void drop_edges() {
    for (size_t e = 0; e < own_.edges.size(); ++e) {
      EdgeRecord& edge = own_.edges[e];
      if (!edge.alive || (edge.same_place(edge_now(e)) && edge.parts == parts_[e])) continue;
      std::vector<int> inner(edge.chain.begin() + 1, edge.chain.end() - 1);
      own_.release(inner);
      edge = EdgeRecord();
    }
  }

  void follow_vertices() {
    for (size_t v = 0; v < own_.of_vertex.size(); ++v) {
      const SketchVertex& now = vertex_now(v);
      int& place = own_.of_vertex[v];
      if (place >= 0 && !now.alive) {
        own_.unused.push_back(place);
        place = -1;
      } else if (now.alive && place < 0) {
        place = own_.add(now.position);
      } else if (now.alive && own_.targets[at(place)] != now.position) {
        own_.positions[at(place)] = own_.targets[at(place)] = own_.cage[at(place)] = now.position;
      }
    }
  }

  void follow_edges() {
    for (size_t e = 0; e < own_.edges.size(); ++e) {
      const SketchEdge& now = edge_now(e);
      EdgeRecord& edge = own_.edges[e];
      if (!now.alive || edge.same(now)) continue;
      if (!edge.alive) {
        edge.parts = parts_[e];
        const int count = edge.parts << own_.options.splits;
        const Points samples = course_of_edge(mesh_, now, count);
        edge.chain.push_back(own_.of_vertex[at(now.vertices[0])]);
        for (int k = 1; k < count; ++k) edge.chain.push_back(own_.add(samples.row(k)));
        edge.chain.push_back(own_.of_vertex[at(now.vertices[1])]);
      }
      edge.alive = true;
      edge.drawn = now.drawn;
      edge.polyline = now.polyline;
      edge.vertices = now.vertices;
      edge.has_face = {now.faces[0] >= 0, now.faces[1] >= 0};
      edge.sharpness = now.sharpness;
    }
  }

  SurfaceRecords& own_;
  const PolylineMesh& mesh_;
  std::vector<size_t> new_faces_;
  std::vector<int> parts_;  ///< per edge
};

void SurfaceRecords::adopt(const PolylineMesh& mesh) {
  Adoption(*this, mesh).run();
}

void SurfaceRecords::mark_sharp_cuts(FaceRecord& face, const std::vector<int>& vertices,
                                     const std::vector<std::array<int, 2>>& cuts) const {
  const auto is_sharp_corner = [&](int v) {  // a vertex of the boundary
    for (size_t k = 0; k < face.sides.size(); ++k) {
      const size_t before = (k + face.sides.size() - 1) % face.sides.size();
      if (along(face.sides[k]).front() == vertices[at(v)])
        return edges[at(edge_of(face.sides[k]))].sharpness >= 1 &&
               edges[at(edge_of(face.sides[before]))].sharpness >= 1;
    }
    return false;
  };
  for (const auto& [corner, next] : cuts)
    if (is_sharp_corner(corner)) face.relief.push_back({vertices[at(corner)], vertices[at(next)]});
}

void SurfaceRecords::split(FaceRecord& face, const SketchFace& now) {
  face.alive = face.stale = true;
  face.sides = now.sides;
  std::vector<Points> sides;
  std::vector<int> vertices;
  for (const int side : now.sides) {
    const std::vector<int> chain = along(side);
    const Index n = Index{1} << options.splits;
    for (size_t first = 0; first + 1 < chain.size(); first += static_cast<size_t>(n)) {
      Points points(n + 1, 3);
      for (Index k = 0; k <= n; ++k)
        points.row(k) = targets[at(chain[first + static_cast<size_t>(k)])].transpose();
      sides.push_back(std::move(points));
    }
    vertices.insert(vertices.end(), chain.begin(), chain.end() - 1);
  }
  FaceSplit made = split_face_into_quads(sides, options.splits);
  for (Index v = made.n_boundary; v < made.domain.rows(); ++v) {
    face.inner.push_back(add(Vector3d::Zero()));
    vertices.push_back(face.inner.back());
  }
  face.quads.reserve(made.quads.size());
  for (const std::array<int, 4>& quad : made.quads)
    face.quads.push_back(
        {vertices[at(quad[0])], vertices[at(quad[1])], vertices[at(quad[2])], vertices[at(quad[3])]});
  mark_sharp_cuts(face, vertices, made.cuts);
  face.is_coons = made.square.rows() > 0;
  if (face.is_coons) {
    Points loop(made.n_boundary, 3);
    for (int v = 0; v < made.n_boundary; ++v) loop.row(v) = targets[at(vertices[at(v)])].transpose();
    const CoonsPatch coons = patch_over_square(made.square.topRows(made.n_boundary), loop);
    for (Index v = made.n_boundary; v < made.domain.rows(); ++v)
      positions[at(vertices[static_cast<size_t>(v)])] = coons.at(made.square(v, 0), made.square(v, 1));
  }
  face.is_projection = made.is_projection;
  face.domain = std::move(made.domain);
  face.domain_quads = std::move(made.quads);
}

}  // namespace batten::detail
