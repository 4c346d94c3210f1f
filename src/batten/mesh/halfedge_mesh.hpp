#pragma once
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// What becomes of vertices at which several fans of triangles meet in a point.
enum class NonManifoldVertices {
  Refuse,  ///< an error that names the vertex
  Split,   ///< every fan gets a vertex of its own (see HalfedgeMesh::source_vertex)
};

/// A triangle mesh whose connectivity can be edited: edges collapsed, flipped and split.
///
/// Half-edge h = 3f + k runs from corner k of face f to the next corner, counter-clockwise; next and previous
/// need no memory. On a border the opposite half-edge is kNone. Numbers of vertices and faces stay valid
/// through every operation: what is removed leaves a hole, new ones are put at the end, compacted() closes
/// the holes. The surface stays an oriented manifold with border: can_collapse() and can_flip() say where an
/// operation would break that. Edges can be marked (features); the marks follow the operations.
class HalfedgeMesh {
 public:
  static constexpr int kNone = -1;

  HalfedgeMesh() = default;
  /// @throws InvalidInput naming the face, edge or vertex: an index out of range, a repeated corner, a
  /// coordinate that is not finite, an edge with more than two faces or with two faces of opposite
  /// orientation, a vertex where several fans meet (unless they are split).
  HalfedgeMesh(const Points& positions, const Triangles& triangles,
               NonManifoldVertices vertices = NonManifoldVertices::Refuse);

  // Sizes. Capacities count the holes: valid numbers are below them.
  int n_vertices() const { return n_vertices_; }
  int n_faces() const { return n_faces_; }
  int vertex_capacity() const { return static_cast<int>(outgoing_.size()); }
  int face_capacity() const { return static_cast<int>(origin_.size()) / 3; }
  int halfedge_capacity() const { return static_cast<int>(origin_.size()); }
  bool has_face(int f) const { return origin_[3 * f] != kNone; }
  bool has_halfedge(int h) const { return origin_[h] != kNone; }
  /// False for removed vertices and for those that no face uses.
  bool has_vertex(int v) const { return outgoing_[v] != kNone; }

  // Steps.
  static int face(int h) { return h / 3; }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int prev(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int opposite(int h) const { return opposite_[h]; }
  int from(int h) const { return origin_[h]; }
  int to(int h) const { return origin_[next(h)]; }
  /// The third corner of the face of h.
  int tip(int h) const { return origin_[prev(h)]; }
  /// A half-edge from v; at a border vertex the one on the border, so that counter-clockwise steps from it
  /// see every face around v.
  int outgoing(int v) const { return outgoing_[v]; }
  /// The next half-edge from the same vertex, counter-clockwise; kNone past the last on a border.
  int rotated(int h) const { return opposite_[prev(h)]; }

  bool is_border_edge(int h) const { return opposite_[h] == kNone; }
  bool is_border_vertex(int v) const { return opposite_[outgoing_[v]] == kNone; }
  /// One half-edge per edge: the only one on a border, else the larger number.
  bool is_representative(int h) const { return origin_[h] != kNone && h > opposite_[h]; }
  /// Half-edge from u to v, or kNone.
  int find(int u, int v) const;
  /// Number of edges at v.
  int valence(int v) const;
  bool is_marked(int h) const { return marked_[h] != 0; }
  /// Marks the edge of h, both half-edges.
  void set_marked(int h, bool marked);

  /// Calls visit(h) for every half-edge h from v, counter-clockwise: one per face around v.
  template <typename Visit>
  void for_each_outgoing(int v, Visit&& visit) const {
    const int first = outgoing_[v];
    int h = first;
    do {
      visit(h);
      h = rotated(h);
    } while (h != kNone && h != first);
  }
  /// Calls visit(u) for every neighbour u of v, counter-clockwise.
  template <typename Visit>
  void for_each_neighbour(int v, Visit&& visit) const {
    const int first = outgoing_[v];
    int h = first;
    for (;;) {
      visit(to(h));
      const int turned = rotated(h);
      if (turned == first) return;
      if (turned == kNone) {
        visit(tip(h));
        return;
      }
      h = turned;
    }
  }

  // Geometry.
  const Eigen::Vector3d& position(int v) const { return positions_[v]; }
  void set_position(int v, const Eigen::Vector3d& p) { positions_[v] = p; }
  /// Normal of length twice the area.
  Eigen::Vector3d area_normal(int f) const {
    const Eigen::Vector3d& a = positions_[origin_[3 * f]];
    const Eigen::Vector3d u = positions_[origin_[3 * f + 1]] - a, v = positions_[origin_[3 * f + 2]] - a;
    return {u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x()};
  }

  // Operations.
  /// The link condition for collapsing h (from → to): the surface stays a manifold of the same topology.
  bool can_collapse(int h) const;
  /// Removes from(h) and the one or two faces at the edge; to(h) stays where it is. @pre can_collapse(h)
  /// @return to(h).
  int collapse(int h);
  /// Whether the edge can be turned within its two faces: not on a border, not marked, and the new edge does
  /// not exist yet. Geometry is the caller's to judge.
  bool can_flip(int h) const;
  /// Turns the edge of h: it then joins the two tips. Afterwards h and its opposite are the turned edge, and
  /// the two faces keep their numbers. @pre can_flip(h)
  void flip(int h);
  /// Puts a vertex on the edge of h and cuts its one or two faces. The part of h at from(h) keeps the number
  /// h; marks pass to both parts. @return the new vertex.
  int split_edge(int h, const Eigen::Vector3d& p);

  /// The vertex of the input that v stood for, or kNone for a vertex made by a split of an edge.
  int source_vertex(int v) const { return source_[v]; }

  /// The mesh without holes.
  struct Compact {
    Points positions;
    Triangles triangles;
    std::vector<int> vertices;  ///< per compact vertex its number in the half-edge mesh, increasing
    std::vector<int> faces;     ///< per compact face its number in the half-edge mesh, increasing
    std::vector<int> index;     ///< per vertex of the half-edge mesh its compact number, or kNone
  };
  /// Linear time.
  Compact compacted() const;

  /// The first breach of the invariants in words, or an empty string. For tests; linear time.
  std::string_view breach() const;

 private:
  /// Makes h and o opposite; where one is kNone the other comes to lie on the border.
  void link(int h, int o) {
    if (h != kNone) opposite_[h] = o;
    if (o != kNone) opposite_[o] = h;
  }
  /// Makes h, or the border half-edge found clockwise from it, the outgoing half-edge of its origin.
  void set_outgoing(int h);
  int add_face();

  std::vector<Eigen::Vector3d> positions_;
  std::vector<int> outgoing_;  ///< per vertex
  std::vector<int> source_;    ///< per vertex
  std::vector<int> origin_;    ///< per half-edge
  std::vector<int> opposite_;  ///< per half-edge
  std::vector<char> marked_;   ///< per half-edge
  int n_vertices_ = 0, n_faces_ = 0;
};

}  // namespace batten
