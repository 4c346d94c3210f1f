#pragma once
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/simulation/polyline_crossings_detail.hpp"
#include "batten/simulation/spline_curve_detail.hpp"

// From polylines on a mesh to the knots and normals of smooth curves. Private to the room.
namespace batten::detail {

/// Points of a polyline at even distances between its crossings, which are all among them.
struct SectionKnots {
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<int> nodes;  ///< which crossing; −1 away from them
};

/// The knots of a closed line with crossings begin at the first of them.
/// @param places of the crossings on this line, in its order. @param spacing wanted, above 0.
SectionKnots place_knots(const MeshPolyline& line, const std::vector<CrossingPlace>& places,
                         const std::vector<MeshCrossing>& crossings, double spacing);

/// Gives every curve normals that agree at the crossings with those of the curves that cross there. The
/// normals of crossings turn to right angles with both curves.
/// @param warnings gain how many crossings are flat.
void set_consistent_normals(const std::vector<std::shared_ptr<SplineCurve>>& curves,
                            const std::vector<SectionKnots>& knots, std::vector<MeshCrossing>& crossings,
                            std::vector<std::string>& warnings);

}  // namespace batten::detail
