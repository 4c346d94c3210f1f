#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/halfedge_mesh.hpp"

namespace batten::simplification {

/// Keeps a mesh free of self-intersections while it is edited: a hierarchy of boxes over its faces that grows
/// with every edit, and exact-in-intent tests of new faces against those that stay.
///
/// Boxes never shrink between rebuilds; a rebuild happens by itself when half of the faces are gone.
class FaceTree {
 public:
  explicit FaceTree(const HalfedgeMesh& mesh);

  /// A triangle that is to appear: corner numbers and where they will lie.
  struct Triangle {
    int corner[3];
    Eigen::Vector3d point[3];
  };

  /// Whether the new triangles would touch each other or any face of the mesh, other than along the corners
  /// and edges they share. @param replaced faces that will be gone.
  /// Two triangles that share an edge count as touching only when one is folded onto the other. Crossing is
  /// allowed where it is there already: with a face that one of the replaced crosses, and among the new when
  /// the replaced cross each other.
  bool intersects(const std::vector<Triangle>& triangles, const std::vector<int>& replaced);

  /// To be called after face f changed its corners or their positions, or appeared.
  void update(int f);
  /// Rebuilds when the mesh has lost half of its faces since the last time.
  void rebuild_if_thinned();

 private:
  struct Node {
    float low[3], high[3];
    float normal_low[3], normal_high[3];  ///< bounds of the unit normals of its faces
    std::int32_t parent, left, right;     ///< of a leaf: left = first in faces_, right = −count
  };
  struct Bounds {
    float low[3], high[3];
    bool misses(const float* l, const float* h) const {
      return l[0] > high[0] || h[0] < low[0] || l[1] > high[1] || h[1] < low[1] || l[2] > high[2] ||
             h[2] < low[2];
    }
  };
  static constexpr std::size_t kMaxStar = 64;  ///< triangles of a query whose boxes are kept
  /// What intersects() asks.
  struct Query {
    const std::vector<Triangle>& triangles;
    const std::vector<int>& replaced;
    Eigen::Vector3f side = Eigen::Vector3f::Zero();  ///< the mean normal of the new triangles
    bool graph = false;                              ///< old and new triangles all look to that side
    bool skip = false;                               ///< boxes whose faces all look there too need no visit
    Bounds all{};                                    ///< of the new triangles, and with `skip` of the old
    std::array<Bounds, kMaxStar> bounds{};           ///< of each of the new
  };
  static Bounds bounds_of(const Eigen::Vector3d (&corners)[3]);
  Query query_of(const std::vector<Triangle>& triangles, const std::vector<int>& replaced);
  void bound(Query& query) const;
  bool may_meet(const Query& query, const Node& node) const;
  bool meets(const Query& query, int f);
  std::vector<Triangle> as_they_are(const std::vector<int>& faces) const;
  void rebuild();
  void set_normal(int f);
  std::int32_t build_node(std::int32_t begin, std::int32_t end, std::int32_t parent);

  const HalfedgeMesh& mesh_;
  std::vector<Node> nodes_;
  std::vector<int> faces_;
  std::vector<int> leaf_;                ///< per face, −1 where none
  std::vector<Eigen::Vector3f> normal_;  ///< per face, unit
  std::vector<std::uint32_t> excluded_;  ///< per face: stamp of the query that leaves it out
  std::vector<std::uint32_t> ring_;      ///< per vertex: stamp of the query whose triangles touch it
  std::uint32_t stamp_ = 0;
  /// One closed surface: along any line its faces look up and down in turn.
  bool alternates_ = false;
  int built_faces_ = 0;
  std::vector<std::int32_t> stack_;
};

/// Whether two triangles touch other than along what they share by number; see FaceTree::intersects().
bool triangles_touch(const FaceTree::Triangle& s, const FaceTree::Triangle& t);

}  // namespace batten::simplification
