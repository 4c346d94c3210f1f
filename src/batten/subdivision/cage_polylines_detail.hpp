#pragma once
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

// Polylines that edges of a cage follow: n × 3, n at least 2. Each call is linear in n. Private to the room.
namespace batten::detail {

/// The length of a polyline up to each of its points.
std::vector<double> lengths_along(const Points& points);

/// The point of a polyline at a fraction of its length, 0 to 1.
Eigen::RowVector3d point_along(const Points& points, double fraction);

/// Where on a polyline, as a fraction of its length, the point nearest to `query` lies; one half when the
/// polyline has no length.
double nearest_fraction(const Points& points, const Eigen::RowVector3d& query);

/// The two parts of a polyline, cut at a fraction of its length. Their points are those of the polyline and,
/// once in each, the point at the cut.
std::pair<Points, Points> cut_polyline(const Points& points, double fraction);

}  // namespace batten::detail
