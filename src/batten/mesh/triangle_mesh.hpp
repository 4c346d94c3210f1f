#pragma once
#include <map>
#include <string>
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten {

/// A triangle mesh as plain arrays. Nothing is cached: the arrays may be edited freely.
struct TriangleMesh {
  Points positions;     ///< n × 3, in the unit of the file
  Triangles triangles;  ///< m × 3, counter-clockwise seen from outside
  /// n × 3 unit normals given with the mesh (by a file, by the surfacing), or 0 × 3.
  Points normals;
  /// Further values per vertex by name (PLY properties such as "quality"), each of length n.
  std::map<std::string, Eigen::VectorXd> vertex_values;

  Eigen::Index n_vertices() const { return positions.rows(); }
  Eigen::Index n_triangles() const { return triangles.rows(); }
};

/// A mesh of polygons with any number of sides: face f has the corners offsets[f] … offsets[f + 1] − 1.
struct PolygonMesh {
  Points positions;
  std::vector<int> corners;
  std::vector<int> offsets{0};

  Eigen::Index n_faces() const { return static_cast<Eigen::Index>(offsets.size()) - 1; }
};

/// Splits every polygon into triangles, by the ear that leaves the best angles where it is not convex.
/// @throws InvalidInput naming the first face with fewer than three corners or an index out of range.
TriangleMesh triangulated(const PolygonMesh& mesh);

/// Two triangles of every quad, cut along the diagonal from its first corner, in the order of the quads.
/// @pre every face has four corners.
Triangles cut_at_first_corners(const PolygonMesh& quads);

/// Length of the diagonal of the axis-aligned bounding box: "the diameter" (docs/methods.md#conventions). 0
/// without points.
double bounding_box_diagonal(const Points& points);

}  // namespace batten
