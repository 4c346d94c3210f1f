#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/modelling/face_parts_detail.hpp"
#include "batten/modelling/face_split_detail.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// What an EditedSurface keeps from update to update. Private to the room.
namespace batten::detail {

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
  FaceSides measures;
  std::vector<std::array<int, 4>> quads;
  /// Edges of quads that are sharp in the cage, though nothing was drawn: at corners between sharp sides the
  /// rules of Catmull–Clark are those of convex corners, and fold the surface where the face is concave. So
  /// the cut from there divides it into corners that are not.
  std::vector<std::array<int, 2>> relief;
  PlanePoints domain;
  std::vector<std::array<int, 4>> domain_quads;  // the same quads in rows of `domain`
  Box box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

/// A set of faces, as marks and as an ascending list.
struct FaceSet {
  std::vector<char> has;
  std::vector<int> list;
};

/// The part of the surface over some faces, with vertices numbered from 0.
struct SurfacePart {
  std::vector<int> vertices;       // their places
  std::vector<char> complete;      // per vertex: all its faces are in the part
  std::vector<double> sharpness;   // per vertex, S of (6.5)
  std::vector<char> border, soft;  // per vertex
  std::vector<char> held;          // per vertex: on an edge that holds
  PolygonMesh mesh;
  std::vector<int> face_of_quad;
  std::vector<SharpEdge> sharp_edges;
};

/// The refined surface over a model, face by face and edge by edge, and which faces are not yet what the
/// model asks for. Methods that take a `mesh` want the model of the last adopt().
struct SurfaceRecords {
  DiffusionOptions options;
  // Vertices keep their places while faces come and go around them.
  std::vector<Eigen::Vector3d> positions, targets, cage;
  std::vector<Eigen::Vector3d> started;  ///< where the flow began
  std::vector<int> unused;
  std::vector<int> of_vertex;  ///< per vertex of the model its place, or −1
  std::vector<EdgeRecord> edges;
  std::vector<FaceRecord> faces;
  std::vector<int> local;  ///< scratch: per vertex its number in a part, −1 outside of part()

  /// A new vertex. @return its place.
  int add(const Eigen::Vector3d& position);
  /// Gives the places of vertices back, and empties the list.
  void release(std::vector<int>& vertices);
  /// Whether the surface is held at a curve.
  bool holds(const EdgeRecord& edge) const {
    return edge.is_border() || (edge.drawn && options.fidelity == 0);
  }
  /// The vertices along a side, in its sense.
  std::vector<int> along(int side) const;

  /// Takes over what is new in the model; faces that it touches become stale. Looks at every curve and face
  /// once.
  void adopt(const PolylineMesh& mesh);

  FaceSet set_of(const std::vector<int>& seeds, const PolylineMesh& mesh) const;
  /// Adds a face, and with it those beyond edges that nothing holds; leaves the list out of order.
  void include(FaceSet& set, int face, const PolylineMesh& mesh) const;
  /// Adds all faces that share a vertex with the set. @return whether there were any.
  bool grow(FaceSet& set, const PolylineMesh& mesh) const;
  /// Faces of the set around a vertex form one fan, or all its faces are in the set: adds what is missing, so
  /// that the set is a surface.
  void close_fans(FaceSet& set, const PolylineMesh& mesh) const;
  /// The region and the faces whose boxes meet its own.
  FaceSet near_to(const FaceSet& region);
  bool is_finite(const FaceSet& region) const;

  /// Its positions are those of now. O(quads of the set).
  SurfacePart part(const FaceSet& set, const PolylineMesh& mesh);

 private:
  friend class Adoption;
  void split(FaceRecord& face, const SketchFace& now);
  /// Fills in `relief`. @param vertices of the face, the boundary first. @param cuts as in FaceSplit.
  void mark_sharp_cuts(FaceRecord& face, const std::vector<int>& vertices,
                       const std::vector<std::array<int, 2>>& cuts) const;
};

}  // namespace batten::detail
