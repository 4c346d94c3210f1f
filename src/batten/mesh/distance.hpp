#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Straight segments, one per row: m × 2 indices of their end points.
using Segments = Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// The point of a mesh or of a set of segments nearest to a query.
struct ClosestPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Row of the triangle or segment on which it lies: the lowest among those at exactly the same distance.
  Eigen::Index element = -1;
  /// Weights of the element's corners, each in [0, 1], sum 1; the third is 0 on a segment. Exactly 0 where
  /// the point lies on an edge or a corner.
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  double squared_distance = 0;
};

/// The point of the triangle a b c nearest to q. Triangles without area count as their longest edge.
/// `element` is 0.
ClosestPoint closest_point_on_triangle(const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);
/// The point of the segment a b nearest to q; its length may be zero. `element` is 0.
ClosestPoint closest_point_on_segment(const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                                      const Eigen::Vector3d& b);

/// A hierarchy of boxes over triangles for exact closest-point queries. It keeps its own copy of the corners,
/// so that the mesh may change or go. Copies are cheap and share the hierarchy; queries are safe from any
/// number of threads.
class TriangleTree {
 public:
  /// Time O(m log m), some 200 bytes per triangle.
  /// @throws InvalidInput without triangles, on an index out of range or a coordinate that is not finite,
  /// naming the triangle.
  TriangleTree(const Points& positions, const Triangles& triangles);

  /// The point of the surface nearest to a place; O(log m) as a rule.
  ClosestPoint closest(const Eigen::Vector3d& query) const;
  /// One result per row of `queries`, equal to those of closest(), on all processors.
  std::vector<ClosestPoint> closest(const Points& queries, const Progress& progress = {}) const;

  struct Hierarchy;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
};

/// The same over straight segments: polylines of curve networks, border edges.
class SegmentTree {
 public:
  /// @throws InvalidInput as TriangleTree.
  SegmentTree(const Points& positions, const Segments& segments);

  /// The point of the segments nearest to a place, and one for each row of `queries`.
  ClosestPoint closest(const Eigen::Vector3d& query) const;
  std::vector<ClosestPoint> closest(const Points& queries, const Progress& progress = {}) const;

  struct Hierarchy;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
};

/// Distances alone, one per query.
Eigen::VectorXd distances(const std::vector<ClosestPoint>& closest);

}  // namespace batten
