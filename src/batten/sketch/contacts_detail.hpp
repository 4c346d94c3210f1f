#pragma once
#include <string>
#include <vector>

#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/stroke.hpp"

// Private to the room: where strokes meet the curves of a model.
namespace batten::detail {

/// A pair (new point, old point) of H 5.2.1.
struct StrokeContact {
  double arc = 0;                                      ///< along the stroke
  int vertex = -1;                                     ///< the old point is this vertex, or
  int edge = -1;                                       ///< a point of this edge
  double edge_arc = 0;                                 ///< at this arc length
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< the old point
  double distance = 0;                                 ///< between the two
};

/// A pair of segments, one of a line and one of an edge, where they come nearest.
struct Hit {
  double arc = 0;  ///< along the line
  int edge = -1;
  double edge_arc = 0;  ///< along the edge
  double distance = 0;
};
/// All pairs of segments of line and model within `snap`, in order along the line.
std::vector<Hit> find_hits(const PolylineMesh& mesh, const Polyline& line, double snap);

/// All contacts of a stroke within `snap`, in order along it. Places nearer than `snap` to a vertex count as
/// that vertex, and edges that meet there are met there alone. Places of the model nearer to each other than
/// 2 · snap are two contacts where the stroke leads from the one to the other; where an end of it lies beside
/// both, the nearer one is its end. Costs as much as the part of the model near the stroke.
/// @throws RefusedEdit when the stroke runs along a curve, or past two curves between which it cannot choose.
std::vector<StrokeContact> find_contacts(const PolylineMesh& mesh, const Stroke& stroke, double snap);

/// The place of the model nearest to a point. @pre the model is not empty.
struct NearestPlace {
  int edge = -1;
  double edge_arc = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double distance = 0;
};
NearestPlace nearest_place(const PolylineMesh& mesh, const Eigen::Vector3d& point);
/// A little less than the distance of a point from a box, so that rounding never makes it more than the
/// computed distance of what is in the box.
double distance_below(const Box& box, const Eigen::Vector3d& point);

/// Turns contacts into vertices of the model, splitting edges. One per contact, in the same order.
std::vector<int> contact_vertices(PolylineMesh& mesh, const std::vector<StrokeContact>& contacts);

/// The curve of a contact, for sentences: "c3" or "v5".
std::string name_of(const PolylineMesh& mesh, const StrokeContact& contact);
/// A length as sentences give it: three digits.
std::string text_of_length(double length);

/// Makes seam vertices vanish that are not needed any more: those of the given curves.
void dissolve_seams(PolylineMesh& mesh, const std::vector<int>& vertices);

/// A coarse triangulation of a face: a fan around the centroid of its outline. Good enough to tell how far
/// something is from a face, and which of two faces is larger.
struct FaceFan {
  Points outline;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double area = 0;
  double distance(const Eigen::Vector3d& point) const;
};
FaceFan face_fan(const PolylineMesh& mesh, const std::vector<int>& walk);

}  // namespace batten::detail
