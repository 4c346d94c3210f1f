#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/triangle_mesh.hpp"

// Sections and borders of a mesh as polylines on it. Private to the room.
namespace batten::detail {

using MeshEdge = std::pair<int, int>;  ///< its vertices, the smaller one first

/// A polyline on the mesh.
struct MeshPolyline {
  std::string name;
  bool boundary = false;
  bool closed = false;
  int axis = -1;  ///< of the plane; −1 for borders
  double offset = 0;
  std::vector<Eigen::Vector3d> points;   ///< the first is not repeated
  std::vector<Eigen::Vector3d> normals;  ///< from the vertex normals
  std::vector<MeshEdge> edges;  ///< that the points lie on; for borders: the edge from this point to the next
  std::vector<int> faces;       ///< sections: of the piece from this point to the next

  std::size_t n_pieces() const { return closed ? points.size() : points.size() - 1; }
  const Eigen::Vector3d& next(std::size_t piece) const { return points[(piece + 1) % points.size()]; }
  double length() const {
    double sum = 0;
    for (std::size_t k = 0; k < n_pieces(); ++k) sum += (next(k) - points[k]).norm();
    return sum;
  }
};

/// Faces on both sides of every edge.
class MeshEdgeFaces {
 public:
  /// @throws InvalidInput naming faces that make the mesh no oriented manifold.
  explicit MeshEdgeFaces(const TriangleMesh& mesh);

  /// The face beyond an edge of a face, or −1 at a border.
  int across(const MeshEdge& edge, int face) const;

  /// Border loops with the surface on their left, as vertices. At a vertex where several borders touch, the
  /// loops are separated one from the other by walking on from the border edge met first.
  std::vector<std::vector<int>> border_loops() const;

 private:
  // By edge: the face that runs from the smaller vertex to the larger, and the other one. Ordered, so that
  // results do not depend on hashing.
  struct Sides : std::array<int, 2> {
    Sides() : std::array<int, 2>{-1, -1} {}
  };
  std::map<MeshEdge, Sides> faces_;
};

/// The border loops as closed polylines.
/// @param normals of the vertices, n × 3.
std::vector<MeshPolyline> border_polylines(const TriangleMesh& mesh, const Points& normals,
                                           const MeshEdgeFaces& faces);

/// The sections of the mesh with the plane in which the coordinate along `axis` (0 to 2) equals `offset`.
/// @pre no vertex lies in the plane: see clear_offset().
std::vector<MeshPolyline> plane_sections(const TriangleMesh& mesh, const Points& normals,
                                         const MeshEdgeFaces& faces, int axis, double offset);

/// An offset near the wanted one at which the plane passes no vertex: the section is then a clean polyline.
/// @param coordinates of the vertices along the axis. @param size of the mesh; the offset moves by less than
/// a thousandth of it.
double clear_offset(const Eigen::VectorXd& coordinates, double wanted, double size);

}  // namespace batten::detail
