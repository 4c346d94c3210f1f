// Based on H 6.4; the split is in face_split.cpp, the flow in curvature_flow.cpp.
#include "batten/modelling/diffusion_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/modelling/cage_fit_detail.hpp"
#include "batten/modelling/coons.hpp"
#include "batten/modelling/curvature_flow_detail.hpp"
#include "batten/modelling/face_parts_detail.hpp"
#include "batten/modelling/face_split_detail.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Rings of faces around the touched ones that the flow moves at once; more follow where the change goes on.
constexpr int kFirstRings = 1;
/// The weights by which a cage follows its limit points fall to 1e-5 over so many quads.
constexpr int kReachOfCage = 8;

/// A flow that has moved so many times farther than before in one round runs away: it goes back to where it
/// was, and on with a smaller time step, so many times at most.
constexpr double kDivergence = 4;
constexpr int kMostSlowdowns = 4;

/// What the surface knows of an edge of the model, to see whether it has changed, and its vertices.
struct EdgeRecord {
  bool alive = false, drawn = true;
  SharedPolyline polyline;
  std::array<int, 2> vertices{-1, -1};
  std::array<bool, 2> has_face{false, false};
  double sharpness = 0;
  int parts = 1;  // each is split as often as the faces are
  std::vector<int> chain;

  bool same_place(const SketchEdge& edge) const {
    return alive && edge.alive && polyline == edge.polyline && vertices == edge.vertices;
  }
  bool same(const SketchEdge& edge) const {
    return same_place(edge) && drawn == edge.drawn && sharpness == edge.sharpness &&
           has_face[0] == (edge.faces[0] >= 0) && has_face[1] == (edge.faces[1] >= 0);
  }
  bool is_border() const { return !has_face[0] || !has_face[1]; }
};

struct FaceRecord {
  bool alive = false;
  /// Its part of the surface is not (yet) what the model asks for.
  bool stale = false;
  /// Has four corners: its inner vertices are put onto a Coons patch, which start_flow() may give up.
  bool is_coons = false;
  bool is_projection = false;  // as in FaceSplit
  /// The flow would fold it: it stays as it started.
  bool frozen = false;
  std::vector<int> sides, inner;
  detail::FaceSides measures;
  std::vector<std::array<int, 4>> quads;
  /// Edges of quads that are sharp in the cage, though nothing was drawn: at corners between sharp sides the
  /// rules of Catmull–Clark are those of convex corners, and fold the surface where the face is concave. So
  /// the cut from there divides it into corners that are not.
  std::vector<std::array<int, 2>> relief;
  detail::PlanePoints domain;
  std::vector<std::array<int, 4>> domain_quads;  // the same quads in rows of `domain`
  Box box{Vector3d::Zero(), Vector3d::Zero()};
};

/// The Coons patch of a loop laid out on the unit square: its four sides are the points between the corners
/// of the square. It follows tubes, which a plate through few curves does not.
/// @param square of the loop, n × 2, by arc length between the corners; points, n × 3. Both
/// counter-clockwise.
CoonsPatch patch_over_square(const detail::PlanePoints& square, const Points& points) {
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

/// The plane in which a surface lies at a vertex of the model, from the drawn curves that meet there: its
/// unit normal, with either sign; zero where they do not tell.
Vector3d normal_at(const PolylineMesh& mesh, int vertex) {
  constexpr int kSamples = 16;
  const Vector3d here = mesh.vertex(vertex).position;
  // Where all curves leave in one direction, their further course tells: a hole is nearly flat.
  for (const int reach : {1, kSamples}) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const int e : mesh.vertex(vertex).edges) {
      const SketchEdge& edge = mesh.edge(e);
      if (!edge.drawn) continue;
      const Points samples = edge.polyline->sampled(kSamples);
      const bool forward = edge.vertices[0] == vertex;
      for (int k = 1; k <= reach; ++k) {
        const Vector3d offset = samples.row(forward ? k : kSamples - k).transpose() - here;
        if (const double length = offset.norm(); length > 0) spread += offset * offset.transpose() / length;
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    if (axes.eigenvalues()(1) > 0.05 * axes.eigenvalues()(2)) return axes.eigenvectors().col(0);
  }
  return Vector3d::Zero();
}

/// Points along a curve that a tool has made between two vertices: the cubic that leaves and reaches them in
/// the planes of the surface there. A straight line (H 6.4.2) would cut through a round body.
Points course_of_tie(const PolylineMesh& mesh, const SketchEdge& edge, int n) {
  Points points = edge.polyline->sampled(n);
  const Vector3d from = points.row(0), to = points.row(n), chord = to - from;
  std::array<Vector3d, 2> tangents;
  for (size_t k = 0; k < 2; ++k) {
    const Vector3d normal = normal_at(mesh, edge.vertices[k]), in_plane = chord - chord.dot(normal) * normal;
    tangents[k] =
        in_plane.norm() > 0.2 * chord.norm() ? (chord.norm() * in_plane.normalized()).eval() : chord;
  }
  for (int i = 1; i < n; ++i) {
    const double t = static_cast<double>(i) / n, s = 1 - t;
    points.row(i) = s * s * (1 + 2 * t) * from + t * t * (1 + 2 * s) * to + t * s * s * tangents[0] -
                    t * t * s * tangents[1];
  }
  return points;
}

}  // namespace

struct EditedSurface::Implementation {
  DiffusionOptions options;
  // Vertices keep their places while faces come and go around them.
  std::vector<Vector3d> positions, targets, cage;
  std::vector<Vector3d> started;  // where the flow began
  std::vector<int> unused;
  std::vector<int> of_vertex;  // per vertex of the model its place, or −1
  std::vector<EdgeRecord> edges;
  std::vector<FaceRecord> faces;
  std::vector<int> local;  // scratch: per vertex its number in a part, −1 outside of part()
  double diameter = 0;
  SurfaceUpdate last;

  int add(const Vector3d& position) {
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

  bool holds(const EdgeRecord& edge) const {
    return edge.is_border() || (edge.drawn && options.fidelity == 0);
  }

  /// The vertices along a side, in its sense.
  std::vector<int> along(int side) const {
    std::vector<int> chain = edges[at(edge_of(side))].chain;
    if (side & 1) std::reverse(chain.begin(), chain.end());
    return chain;
  }

  void release(std::vector<int>& vertices) {
    unused.insert(unused.end(), vertices.rbegin(), vertices.rend());
    vertices.clear();
  }

  /// Takes over what is new in the model; faces that it touches become stale.
  void adopt(const PolylineMesh& mesh) {
    edges.resize(std::max(edges.size(), mesh.edges().size()));
    faces.resize(std::max(faces.size(), mesh.faces().size()));
    of_vertex.resize(std::max(of_vertex.size(), mesh.vertices().size()), -1);
    const SketchEdge no_edge;
    const SketchFace no_face;
    const SketchVertex no_vertex;
    const auto edge_now = [&](size_t e) -> const SketchEdge& {
      return e < mesh.edges().size() ? mesh.edges()[e] : no_edge;
    };
    const auto face_now = [&](size_t f) -> const SketchFace& {
      return f < mesh.faces().size() ? mesh.faces()[f] : no_face;
    };
    const auto vertex_now = [&](size_t v) -> const SketchVertex& {
      return v < mesh.vertices().size() ? mesh.vertices()[v] : no_vertex;
    };
    const auto is_new = [&](size_t f) {
      const FaceRecord& face = faces[f];
      const SketchFace& now = face_now(f);
      if (face.alive != now.alive) return true;
      if (!now.alive) return false;
      return face.sides != now.sides || std::any_of(now.sides.begin(), now.sides.end(), [&](int side) {
               return !edges[at(edge_of(side))].same(edge_now(at(edge_of(side))));
             });
    };
    std::vector<size_t> new_faces;
    for (size_t f = 0; f < faces.size(); ++f)
      if (is_new(f)) new_faces.push_back(f);
    const auto forget = [&](size_t f) {
      release(faces[f].inner);
      faces[f] = FaceRecord();
    };
    for (const size_t f : new_faces) {
      forget(f);
      if (face_now(f).alive) faces[f].measures = measures_of(mesh, face_now(f));
    }
    std::vector<const detail::FaceSides*> measures(faces.size(), nullptr);
    for (size_t f = 0; f < faces.size(); ++f)
      if (face_now(f).alive) measures[f] = &faces[f].measures;
    const std::vector<int> parts = detail::parts_of_edges(edges.size(), measures);
    // Faces whose sides have other numbers of parts than before are split anew.
    for (size_t e = 0; e < edges.size(); ++e) {
      if (!edges[e].alive || !edge_now(e).alive || edges[e].parts == parts[e]) continue;
      for (const int f : edge_now(e).faces)
        if (f >= 0 && faces[at(f)].alive) {
          detail::FaceSides kept = std::move(faces[at(f)].measures);
          forget(at(f));
          faces[at(f)].measures = std::move(kept);
          new_faces.push_back(at(f));
        }
    }
    std::sort(new_faces.begin(), new_faces.end());
    const int n = 1 << options.splits;
    for (size_t e = 0; e < edges.size(); ++e)
      if (edges[e].alive && !(edges[e].same_place(edge_now(e)) && edges[e].parts == parts[e])) {
        std::vector<int> inner(edges[e].chain.begin() + 1, edges[e].chain.end() - 1);
        release(inner);
        edges[e] = EdgeRecord();
      }
    for (size_t v = 0; v < of_vertex.size(); ++v) {
      const SketchVertex& now = vertex_now(v);
      int& place = of_vertex[v];
      if (place >= 0 && !now.alive) {
        unused.push_back(place);
        place = -1;
      } else if (now.alive && place < 0) {
        place = add(now.position);
      } else if (now.alive && targets[at(place)] != now.position) {
        positions[at(place)] = targets[at(place)] = cage[at(place)] = now.position;
      }
    }
    for (size_t e = 0; e < edges.size(); ++e) {
      const SketchEdge& now = edge_now(e);
      EdgeRecord& edge = edges[e];
      if (!now.alive || edge.same(now)) continue;
      if (!edge.alive) {
        edge.parts = parts[e];
        const int count = n * edge.parts;
        const Points samples = now.drawn ? now.polyline->sampled(count) : course_of_tie(mesh, now, count);
        edge.chain.push_back(of_vertex[at(now.vertices[0])]);
        for (int k = 1; k < count; ++k) edge.chain.push_back(add(samples.row(k)));
        edge.chain.push_back(of_vertex[at(now.vertices[1])]);
      }
      edge.alive = true;
      edge.drawn = now.drawn;
      edge.polyline = now.polyline;
      edge.vertices = now.vertices;
      edge.has_face = {now.faces[0] >= 0, now.faces[1] >= 0};
      edge.sharpness = now.sharpness;
    }
    for (const size_t f : new_faces)
      if (face_now(f).alive) split(faces[f], face_now(f));
  }

  detail::FaceSides measures_of(const PolylineMesh& mesh, const SketchFace& face) const {
    constexpr int kSamples = 8;
    detail::FaceSides measures;
    std::vector<Points> sides;
    for (const int side : face.sides) {
      const SketchEdge& edge = mesh.edge(edge_of(side));
      Points samples = edge.drawn ? edge.polyline->sampled(kSamples) : course_of_tie(mesh, edge, kSamples);
      if (side & 1) samples = samples.colwise().reverse().eval();
      measures.edges.push_back(edge_of(side));
      measures.lengths.push_back(detail::polyline_length(samples));
      sides.push_back(std::move(samples));
    }
    measures.corners = detail::corners_of_quadrilateral(sides);
    measures.parts = detail::parts_at_concave_corners(sides);
    return measures;
  }

  void split(FaceRecord& face, const SketchFace& now) {
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
    detail::FaceSplit made = detail::split_face_into_quads(sides, options.splits);
    for (Index v = made.n_boundary; v < made.domain.rows(); ++v) {
      face.inner.push_back(add(Vector3d::Zero()));
      vertices.push_back(face.inner.back());
    }
    face.quads.reserve(made.quads.size());
    for (const std::array<int, 4>& quad : made.quads)
      face.quads.push_back(
          {vertices[at(quad[0])], vertices[at(quad[1])], vertices[at(quad[2])], vertices[at(quad[3])]});
    const auto is_sharp_corner = [&](int v) {  // a vertex of the boundary
      for (size_t k = 0; k < now.sides.size(); ++k) {
        const size_t before = (k + now.sides.size() - 1) % now.sides.size();
        if (along(now.sides[k]).front() == vertices[at(v)])
          return edges[at(edge_of(now.sides[k]))].sharpness >= 1 &&
                 edges[at(edge_of(now.sides[before]))].sharpness >= 1;
      }
      return false;
    };
    for (const auto& [corner, next] : made.cuts)
      if (is_sharp_corner(corner)) face.relief.push_back({vertices[at(corner)], vertices[at(next)]});
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

  /// A set of faces, as marks and as an ascending list.
  struct FaceSet {
    std::vector<char> has;
    std::vector<int> list;
  };

  FaceSet set_of(const std::vector<int>& seeds, const PolylineMesh& mesh) const {
    FaceSet set;
    set.has.assign(faces.size(), 0);
    for (const int f : seeds) include(set, f, mesh);
    std::sort(set.list.begin(), set.list.end());
    return set;
  }

  /// A face, and with it those beyond edges that nothing holds.
  void include(FaceSet& set, int face, const PolylineMesh& mesh) const {
    if (set.has[at(face)]) return;
    set.has[at(face)] = 1;
    std::vector<int> stack{face};
    while (!stack.empty()) {
      const int f = stack.back();
      stack.pop_back();
      set.list.push_back(f);
      for (const int side : mesh.face(f).sides) {
        if (holds(edges[at(edge_of(side))])) continue;
        const int next = mesh.face_of(opposite_side(side));
        if (next < 0 || set.has[at(next)]) continue;
        set.has[at(next)] = 1;
        stack.push_back(next);
      }
    }
  }

  /// Adds all faces that share a vertex with the set. @return whether there were any.
  bool grow(FaceSet& set, const PolylineMesh& mesh) const {
    const std::vector<int> before = set.list;
    for (const int f : before)
      for (const int side : mesh.face(f).sides)
        for (const int e : mesh.vertex(mesh.start_of(side)).edges)
          for (const int next : mesh.edge(e).faces)
            if (next >= 0) include(set, next, mesh);
    std::sort(set.list.begin(), set.list.end());
    return set.list.size() > before.size();
  }

  /// Faces of the set around a vertex form one fan, or all its faces are in the set: adds what is missing, so
  /// that the set is a surface.
  void close_fans(FaceSet& set, const PolylineMesh& mesh) const {
    for (bool added = true; added;) {
      added = false;
      const std::vector<int> before = set.list;
      for (const int f : before)
        for (const int side : mesh.face(f).sides) {
          int sides_in = 0, inner = 0;
          bool all = true;
          const SketchVertex& vertex = mesh.vertex(mesh.start_of(side));
          for (const int e : vertex.edges) {
            int in = 0;
            for (const int next : mesh.edge(e).faces) {
              if (next < 0) continue;
              if (set.has[at(next)])
                ++in;
              else
                all = false;
            }
            sides_in += in;
            inner += in == 2;
          }
          // Every face has two edges at the vertex, so there are sides_in / 2 faces, joined at `inner` edges.
          if (all || sides_in / 2 - inner <= 1) continue;
          for (const int e : vertex.edges)
            for (const int next : mesh.edge(e).faces)
              if (next >= 0 && !set.has[at(next)]) {
                include(set, next, mesh);
                added = true;
              }
        }
    }
    std::sort(set.list.begin(), set.list.end());
  }

  /// The part of the surface over some faces, with vertices numbered from 0.
  struct Part {
    std::vector<int> vertices;       // their places
    std::vector<char> complete;      // per vertex: all its faces are in the part
    std::vector<double> sharpness;   // per vertex, S of (6.5)
    std::vector<char> border, soft;  // per vertex
    std::vector<char> held;          // per vertex: on an edge that holds
    PolygonMesh mesh;
    std::vector<int> face_of_quad;
    std::vector<SharpEdge> sharp_edges;
  };

  Part part(const FaceSet& set, const PolylineMesh& mesh) {
    Part part;
    for (const int f : set.list)
      for (const std::array<int, 4>& quad : faces[at(f)].quads) {
        for (const int v : quad) {
          if (local[at(v)] < 0) {
            local[at(v)] = static_cast<int>(part.vertices.size());
            part.vertices.push_back(v);
          }
          part.mesh.corners.push_back(local[at(v)]);
        }
        part.mesh.offsets.push_back(static_cast<int>(part.mesh.corners.size()));
        part.face_of_quad.push_back(f);
      }
    for (const int f : set.list)
      for (const auto& [corner, next] : faces[at(f)].relief)
        part.sharp_edges.push_back({local[at(corner)], local[at(next)], kInfinitelySharp});
    const size_t n = part.vertices.size();
    part.complete.assign(n, 1);
    part.border.assign(n, 0);
    part.soft.assign(n, 0);
    part.held.assign(n, 0);
    part.sharpness.assign(n, 0);
    std::vector<char> met(n, 0);
    for (const int f : set.list)
      for (const int side : faces[at(f)].sides) {
        const EdgeRecord& edge = edges[at(edge_of(side))];
        const int beyond = mesh.face_of(opposite_side(side));
        const bool complete = beyond < 0 || set.has[at(beyond)], own = !(side & 1) || !complete || beyond < 0;
        for (size_t k = 0; k < edge.chain.size(); ++k) {
          const int v = local[at(edge.chain[k])];
          const auto i = at(v);
          if (!complete) part.complete[i] = 0;
          if (edge.is_border()) part.border[i] = 1;
          if (holds(edge)) part.held[i] = 1;
          if (edge.drawn && options.fidelity > 0) part.soft[i] = 1;
          if (k > 0 && k + 1 < edge.chain.size()) part.sharpness[i] = 2 * edge.sharpness;
          if (own && edge.sharpness > 0 && k + 1 < edge.chain.size())
            part.sharp_edges.push_back(
                {v, local[at(edge.chain[k + 1])], detail::crease_sharpness(edge.sharpness)});
        }
        // S of the vertices of the model, from all of their edges.
        const int vertex = mesh.start_of(side), v = local[at(of_vertex[at(vertex)])];
        if (met[at(v)]) continue;
        met[at(v)] = 1;
        double sum = 0;
        for (const int e : mesh.vertex(vertex).edges) {
          sum += mesh.edge(e).sharpness;
          for (const int face : mesh.edge(e).faces) {
            if (face < 0) part.border[at(v)] = 1;
            if (face >= 0 && !set.has[at(face)]) part.complete[at(v)] = 0;
          }
        }
        part.sharpness[at(v)] = sum;
        (options.fidelity > 0 ? part.soft : part.held)[at(v)] = 1;
      }
    // The tip of a dart (S ≤ 1) stays smooth.
    for (double& s : part.sharpness)
      if (s <= 1) s = 0;
    part.mesh.positions.resize(static_cast<Index>(n), 3);
    for (size_t v = 0; v < n; ++v) {
      part.mesh.positions.row(static_cast<Index>(v)) = positions[at(part.vertices[v])].transpose();
      local[at(part.vertices[v])] = -1;
    }
    return part;
  }

  /// Moves a region, the faces around it held. @return the largest move of a vertex in each face of the
  /// surroundings' neighbours, i.e. of the outermost faces of the region; 0 where the region has no rim.
  double flow(const FaceSet& region, const FaceSet& surroundings, bool start, const PolylineMesh& mesh,
              const Progress& progress) {
    const Part around = part(surroundings, mesh);
    const auto n = around.vertices.size();
    // The same vertices seen from the region alone: those that are complete there may move.
    std::vector<char> movable(n, 0), at_rim(n, 0), frozen(n, 0);
    for (size_t v = 0; v < n; ++v) local[at(around.vertices[v])] = static_cast<int>(v);
    for (const int f : region.list) {
      bool outermost = false;
      for (const int side : mesh.face(f).sides)
        for (const int e : mesh.vertex(mesh.start_of(side)).edges)
          for (const int next : mesh.edge(e).faces)
            outermost = outermost || (next >= 0 && !region.has[at(next)]);
      for (const std::array<int, 4>& quad : faces[at(f)].quads)
        for (const int v : quad) {
          movable[at(local[at(v)])] = 1;
          if (faces[at(f)].frozen) frozen[at(local[at(v)])] = 1;
          if (outermost) at_rim[at(local[at(v)])] = 1;
        }
    }
    for (const int f : surroundings.list)
      if (!region.has[at(f)])
        for (const std::array<int, 4>& quad : faces[at(f)].quads)
          for (const int v : quad) movable[at(local[at(v)])] = 0;
    for (size_t v = 0; v < n; ++v) local[at(around.vertices[v])] = -1;

    detail::FlowMesh flow;
    flow.positions = around.mesh.positions;
    flow.triangles.resize(2 * around.mesh.n_faces(), 3);
    flow.domain.resize(2 * around.mesh.n_faces(), 3);
    flow.patch.resize(static_cast<size_t>(2 * around.mesh.n_faces()));
    Index t = 0, q = 0;
    for (size_t patch = 0; patch < surroundings.list.size(); ++patch) {
      const int f = surroundings.list[patch];
      const FaceRecord& face = faces[at(f)];
      const bool begins = region.has[at(f)] && face.stale;
      flow.patches.push_back({!begins         ? detail::FlowPatch::Begin::Kept
                              : face.is_coons ? detail::FlowPatch::Begin::Coons
                                              : detail::FlowPatch::Begin::Plate,
                              face.is_projection});
      for (const std::array<int, 4>& in_domain : face.domain_quads) {
        const int* c = &around.mesh.corners[static_cast<size_t>(4 * q++)];
        const auto in_space = detail::cut_along_corners({c[0], c[1], c[2], c[3]});
        const auto in_plane = detail::cut_along_corners(in_domain);
        for (size_t k = 0; k < 2; ++k, ++t) {
          flow.patch[static_cast<size_t>(t)] = static_cast<int>(patch);
          for (size_t i = 0; i < 3; ++i) {
            flow.triangles(t, static_cast<Index>(i)) = in_space[k][i];
            flow.domain(t, static_cast<Index>(i)) =
                (face.domain.row(in_plane[k][(i + 1) % 3]) - face.domain.row(in_plane[k][(i + 2) % 3]))
                    .norm();
          }
        }
      }
    }
    flow.fixed.resize(n);
    flow.without_row.resize(n);
    flow.sharpness = around.sharpness;
    flow.soft = around.soft;
    flow.targets.resize(static_cast<Index>(n), 3);
    for (size_t v = 0; v < n; ++v) {
      flow.targets.row(static_cast<Index>(v)) = targets[at(around.vertices[v])].transpose();
      flow.fixed[v] = around.held[v] || around.border[v] || !movable[v];
      flow.without_row[v] = around.border[v] || !around.complete[v];
    }
    if (start) {
      detail::start_flow(flow);
      for (size_t v = 0; v < n; ++v)
        started[at(around.vertices[v])] = flow.positions.row(static_cast<Index>(v));
    }
    for (size_t v = 0; v < n; ++v) {
      if (!frozen[v]) continue;
      flow.fixed[v] = 1;
      flow.positions.row(static_cast<Index>(v)) = started[at(around.vertices[v])].transpose();
      positions[at(around.vertices[v])] = started[at(around.vertices[v])];
    }
    const Points before = flow.positions;
    detail::CurvatureFlow rounds(flow, options);
    Points best = flow.positions;
    double least = std::numeric_limits<double>::infinity();
    int n_slowdowns = 0;
    for (int round = 0; round < options.rounds; ++round) {
      progress.report("flow", static_cast<double>(round) / options.rounds);
      last.last_move = rounds.round().maxCoeff() / diameter;
      ++last.rounds;
      if (last.last_move < least) {
        least = last.last_move;
        best = flow.positions;
      }
      if (last.last_move < options.tolerance) break;
      if (last.last_move < kDivergence * least) continue;
      flow.positions = best;
      if (n_slowdowns++ == kMostSlowdowns) break;
      rounds.slow_down();
    }
    if (least < last.last_move) {
      flow.positions = best;
      last.last_move = least;
    }
    double moved_rim = 0;
    for (size_t v = 0; v < n; ++v) {
      const auto row = static_cast<Index>(v);
      if (at_rim[v]) moved_rim = std::max(moved_rim, (flow.positions.row(row) - before.row(row)).norm());
      if (!flow.fixed[v]) positions[at(around.vertices[v])] = flow.positions.row(row);
    }
    return moved_rim / diameter;
  }

  /// The region and the faces whose boxes meet its own.
  FaceSet near_to(const FaceSet& region) {
    Box all{Vector3d::Constant(std::numeric_limits<double>::infinity()),
            Vector3d::Constant(-std::numeric_limits<double>::infinity())};
    const Box nothing = all;
    for (const int f : region.list) {
      Box& box = faces[at(f)].box;
      box = nothing;
      for (const std::array<int, 4>& quad : faces[at(f)].quads)
        for (const int v : quad) box.include({positions[at(v)], positions[at(v)]});
      all.include(box);
    }
    FaceSet near;
    near.has.assign(faces.size(), 0);
    for (size_t f = 0; f < faces.size(); ++f) {
      if (!faces[f].alive || (!region.has[f] && !all.meets(faces[f].box))) continue;
      near.has[f] = region.has[f] || std::any_of(region.list.begin(), region.list.end(),
                                                 [&](int g) { return faces[at(g)].box.meets(faces[f].box); });
      if (near.has[f]) near.list.push_back(static_cast<int>(f));
    }
    return near;
  }

  /// Freezes the faces of the region that fold or cross others, and puts it back to where the flow began.
  /// @return false where there are none, or all of them are frozen already.
  bool freeze_folded(const FaceSet& region, const PolylineMesh& mesh) {
    const Part parts = part(near_to(region), mesh);
    std::vector<int> folded;
    if (!parts.mesh.positions.allFinite()) {
      folded = region.list;
    } else {
      for (const auto& [one, other] : self_intersections(parts.mesh.positions, detail::cut_quads(parts.mesh)))
        for (const int triangle : {one, other}) folded.push_back(parts.face_of_quad[at(triangle / 2)]);
    }
    bool any = false;
    for (const int f : folded) {
      if (!region.has[at(f)] || faces[at(f)].frozen) continue;
      any = faces[at(f)].frozen = true;
    }
    if (!any) return false;
    for (const int f : region.list)
      if (faces[at(f)].stale)
        for (const std::array<int, 4>& quad : faces[at(f)].quads)
          for (const int v : quad) positions[at(v)] = started[at(v)];
    return true;
  }

  bool is_finite(const FaceSet& region) const {
    for (const int f : region.list)
      for (const std::array<int, 4>& quad : faces[at(f)].quads)
        for (const int v : quad)
          if (!positions[at(v)].allFinite()) return false;
    return true;
  }

  /// Refuses what is unsound in the region.
  void require_sound(const FaceSet& region, const PolylineMesh& mesh) {
    const Part parts = part(near_to(region), mesh);
    Points start(static_cast<Index>(parts.vertices.size()), 3);
    for (size_t v = 0; v < parts.vertices.size(); ++v)
      start.row(static_cast<Index>(v)) = targets[at(parts.vertices[v])].transpose();
    detail::require_sound(parts.mesh, parts.face_of_quad, options.fidelity > 0 ? parts.soft : parts.held,
                          start);
  }

  /// Lets the cage follow the region.
  void fit_cage(const FaceSet& region, const PolylineMesh& mesh) {
    FaceSet around = region;
    for (int reach = 0; reach < kReachOfCage + 1; reach += 1 << options.splits)
      if (!grow(around, mesh)) break;
    close_fans(around, mesh);
    const Part part_of = part(around, mesh);
    ControlCage fitted;
    fitted.mesh = part_of.mesh;
    fitted.sharp_edges = part_of.sharp_edges;
    for (size_t v = 0; v < part_of.vertices.size(); ++v)
      fitted.mesh.positions.row(static_cast<Index>(v)) = cage[at(part_of.vertices[v])].transpose();
    last.cage_fit = detail::fit_limit(fitted, part_of.mesh.positions, part_of.complete,
                                      options.fidelity > 0 ? part_of.soft : part_of.held);
    for (size_t v = 0; v < part_of.vertices.size(); ++v)
      cage[at(part_of.vertices[v])] = fitted.mesh.positions.row(static_cast<Index>(v));
  }
};

EditedSurface::EditedSurface(const DiffusionOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  implementation_->options = options;
}
EditedSurface::~EditedSurface() = default;
EditedSurface::EditedSurface(EditedSurface&&) noexcept = default;
EditedSurface& EditedSurface::operator=(EditedSurface&&) noexcept = default;

SurfaceUpdate EditedSurface::update(const PolylineMesh& mesh, const Progress& progress) {
  Implementation& own = *implementation_;
  double quads = 0;
  for (const SketchFace& face : mesh.faces()) quads += static_cast<double>(face.sides.size());
  quads *= std::pow(4.0, own.options.splits - 1);
  if (quads == 0) throw InvalidInput("the model has no faces; insert a closed curve first");
  if (quads > 2e6)
    throw InvalidInput(concat("the refined mesh would have ", quads, " quads; use fewer splits"));
  own.last = SurfaceUpdate();
  own.diameter = mesh.diameter();
  std::vector<int> stale;
  {
    const ScopedStage stage(own.last.times, "refine");
    own.adopt(mesh);
    for (size_t f = 0; f < own.faces.size(); ++f)
      if (own.faces[f].stale) stale.push_back(static_cast<int>(f));
  }
  if (stale.empty()) return own.last;
  Implementation::FaceSet region = own.set_of(stale, mesh);
  {
    const ScopedStage stage(own.last.times, "flow");
    for (int ring = 0; ring < kFirstRings; ++ring) own.grow(region, mesh);
    for (bool start = true;; start = false) {
      Implementation::FaceSet surroundings = region;
      const bool whole = !own.grow(surroundings, mesh);
      own.close_fans(surroundings, mesh);
      const double rim = own.flow(region, surroundings, start, mesh, progress);
      for (const int f : region.list) own.faces[at(f)].stale = true;
      if (!whole && rim > own.options.tolerance)
        own.grow(region, mesh);
      else if (!own.freeze_folded(region, mesh))
        break;
    }
  }
  {
    const ScopedStage stage(own.last.times, "check");
    if (!own.options.keep_folded || !own.is_finite(region)) own.require_sound(region, mesh);
  }
  for (const int f : stale)
    for (const int v : own.faces[at(f)].inner) own.cage[at(v)] = own.positions[at(v)];
  {
    const ScopedStage stage(own.last.times, "cage");
    own.fit_cage(region, mesh);
  }
  for (const int f : region.list) {
    own.faces[at(f)].stale = false;
    own.last.quads += static_cast<Index>(own.faces[at(f)].quads.size());
  }
  own.last.faces = region.list;
  for (size_t f = 0; f < own.faces.size(); ++f)
    if (own.faces[f].frozen) own.last.not_smoothed.push_back(static_cast<int>(f));
  return own.last;
}

DiffusionSurface EditedSurface::surface(const PolylineMesh& mesh) const {
  const Implementation& own = *implementation_;
  DiffusionSurface surface;
  std::vector<int> number(own.positions.size(), -1), order;
  const auto take = [&](int v) {
    number[at(v)] = static_cast<int>(order.size());
    order.push_back(v);
  };
  for (const int v : own.of_vertex)
    if (v >= 0) take(v);
  for (const EdgeRecord& edge : own.edges)
    for (size_t k = 1; k + 1 < edge.chain.size(); ++k) take(edge.chain[k]);
  for (const FaceRecord& face : own.faces)
    for (const int v : face.inner) take(v);
  surface.on_curve.assign(order.size(), 0);
  surface.vertices_of_edge.resize(mesh.edges().size());
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const EdgeRecord& edge = own.edges[e];
    std::vector<int>& chain = surface.vertices_of_edge[e];
    for (size_t k = 0; k < edge.chain.size(); ++k) {
      chain.push_back(number[at(edge.chain[k])]);
      if (edge.drawn || k == 0 || k + 1 == edge.chain.size()) surface.on_curve[at(chain.back())] = 1;
      if (k > 0 && edge.sharpness > 0)
        surface.refined.sharp_edges.push_back(
            {chain[k - 1], chain[k], detail::crease_sharpness(edge.sharpness)});
    }
  }
  PolygonMesh& refined = surface.refined.mesh;
  refined.positions.resize(static_cast<Index>(order.size()), 3);
  for (size_t v = 0; v < order.size(); ++v)
    refined.positions.row(static_cast<Index>(v)) = own.positions[at(order[v])].transpose();
  for (size_t f = 0; f < own.faces.size(); ++f)
    for (const std::array<int, 4>& quad : own.faces[f].quads) {
      for (const int v : quad) refined.corners.push_back(number[at(v)]);
      refined.offsets.push_back(static_cast<int>(refined.corners.size()));
      surface.face_of_quad.push_back(static_cast<int>(f));
    }
  for (const FaceRecord& face : own.faces)
    for (const auto& [corner, next] : face.relief)
      surface.refined.sharp_edges.push_back({number[at(corner)], number[at(next)], kInfinitelySharp});
  detail::turn_outwards(mesh, refined, surface.face_of_quad);
  surface.cage = surface.refined;
  for (size_t v = 0; v < order.size(); ++v)
    surface.cage.mesh.positions.row(static_cast<Index>(v)) = own.cage[at(order[v])].transpose();
  surface.last_move = own.last.last_move;
  surface.not_smoothed = own.last.not_smoothed;
  surface.cage_fit = own.last.cage_fit;
  surface.times = own.last.times;
  return surface;
}

std::optional<std::string> DiffusionOptions::problem() const {
  if (splits < 1 || splits > 6) return concat("splits must be 1 to 6, got ", splits);
  if (rounds < 0 || rounds > 200) return concat("rounds must be 0 to 200, got ", rounds);
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    return concat("tolerance must be above 0, got ", tolerance);
  if (!(time_step > 0) || !std::isfinite(time_step))
    return concat("time_step must be above 0, got ", time_step);
  if (diffusion_steps < 1 || diffusion_steps > 1000)
    return concat("diffusion_steps must be 1 to 1000, got ", diffusion_steps);
  if (!(similarity > 0) || !std::isfinite(similarity))
    return concat("similarity must be above 0, got ", similarity);
  if (!(fidelity >= 0) || !std::isfinite(fidelity))
    return concat("fidelity must be at least 0, got ", fidelity);
  return std::nullopt;
}

DiffusionSurface diffusion_surface(const PolylineMesh& mesh, const DiffusionOptions& options,
                                   const Progress& progress) {
  EditedSurface edited(options);
  edited.update(mesh, progress);
  return edited.surface(mesh);
}

}  // namespace batten
