#pragma once
#include <vector>

#include "batten/subdivision/cage_level_detail.hpp"

// The rules of Nuliss, NulissMod and Linear. Private to the room.
namespace batten::detail {

/// Edge points of one level.
struct CageEdgePoints {
  Points points;                 ///< e × 3
  std::vector<double> fraction;  ///< where they cut the polylines
};

CageEdgePoints edge_points(const CageLevel& level, SubdivisionScheme scheme);

/// One point per face. @param coons quads all of whose edges have polylines get the middle of their Coons
/// patch (H 6.3.1).
Points face_points(const CageLevel& level, const CageEdgePoints& edges, SubdivisionScheme scheme, bool coons);

/// The unit normals of the limit surface: at a smooth vertex that of the part which is linear around it.
/// Along each row the odd cubic through the first two neighbours gives the limit slope of the four-point
/// rule.
Points limit_normals(const CageLevel& level);

}  // namespace batten::detail
