#pragma once
#include <functional>
#include <optional>
#include <string>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// A function of space and its gradient.
struct ScalarField {
  std::function<double(const Eigen::Vector3d&)> value;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> gradient;
};

/// Options of level_set(). Lengths in the unit of the points.
struct LevelSetOptions {
  double edge_length = 0;      ///< of the triangles, about; above 0
  double flatness = 0.08;      ///< how far a triangle may lie from the surface, ÷ edge_length; above 0
  double smallest_angle = 25;  ///< of the triangles in degrees; 0 to 30
  bool closed = true;  ///< f = 0 closes within the margin: no opening is left while triangles close it
  double max_triangles = 20e6;  ///< more are refused before any is made, by an estimate

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Triangles of the surface f = 0 near given points of it, by Delaunay refinement ([boissonnat2005]): as even
/// as smallest_angle says, manifold, facing along the gradient. Every seed becomes a vertex where it was, so
/// seeds along curves should lie edge_length apart. Parts of the surface without a seed may be missing.
/// @param seeds n × 3, on f = 0 or near it; 4 or more that do not lie in a plane. @param margin how far the
/// surface may reach out of the box of the seeds; it is open where it would go farther.
/// O(n log n) with some 200 values of f for each triangle. Where triangles so even cannot be had (f = 0 meets
/// itself, or ends in a spike), they are as uneven as they come.
/// @throws InvalidInput where options.problem() names one, for fewer seeds and too many triangles, and where
/// no triangles of that size follow the surface; Cancelled.
TriangleMesh level_set(const ScalarField& field, const Points& seeds, double margin,
                       const LevelSetOptions& options, const Progress& progress = {});

}  // namespace batten
