#pragma once
#include <optional>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/random.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {

/// What can be measured and registered: a surface of triangles, or curves of straight segments where there is
/// no triangle.
struct Shape {
  Points positions;
  Triangles triangles;
  Segments segments;

  bool is_surface() const { return triangles.rows() > 0; }
};

/// Closest points on a shape, whichever kind it is.
class ShapeTree {
 public:
  /// @throws InvalidInput when the shape has neither triangles nor segments, or as TriangleTree.
  explicit ShapeTree(const Shape& shape);

  /// The point of the shape nearest to a place, and one for each row of `queries`.
  ClosestPoint closest(const Eigen::Vector3d& query) const;
  std::vector<ClosestPoint> closest(const Points& queries, const Progress& progress = {}) const;

 private:
  std::optional<TriangleTree> triangles_;
  std::optional<SegmentTree> segments_;
};

/// The vertices that a triangle or segment uses, increasing. Files often hold more.
/// @pre the indices are in range, as for the functions below.
std::vector<int> used_vertices(const Shape& shape);

/// `n` points drawn independently, uniform by area on a surface and by length on curves.
/// @param elements if given, receives the triangle or segment of every point.
/// @throws InvalidInput when the area or length is zero or not finite.
Points sample_uniformly(const Shape& shape, Eigen::Index n, Random& random,
                        std::vector<int>* elements = nullptr);

/// Length of the diagonal of the bounding box of the used vertices: "the diameter"
/// (docs/methods.md#conventions).
double diameter(const Shape& shape);

}  // namespace batten
