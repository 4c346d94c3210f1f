#pragma once
#include <vector>

#include "batten/surfacing/fairing_detail.hpp"
#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// Extends the last range by a vertex beyond it, or begins another.
void append(std::vector<VertexRange>& ranges, Eigen::Index vertex);

struct MovedVertices {
  std::vector<int> vertices;  ///< that may have changed, increasing
  int parts_solved = 0;
};

/// Moves of a surface that has been built: the displacement of its curves spread biharmonically over the
/// patches around them gives positions and normals, and the change of their curvature target the correction
/// (both linear, so that this is the fit of (4.20–4.26) to the surface as it was built plus what has
/// changed). All lengths are in diameters.
class SurfaceMover {
 public:
  /// @param systems with the metric of the surface; kept by reference, as `triangles`. @param positions,
  /// normals of the surface as built. @param network its first vertices as they were given.
  SurfaceMover(FairingSystems& systems, const Triangles& triangles, bool metric_from_layout,
               SurfaceMethod method, const Points& positions, const Points& normals,
               const ScaledNetwork& network);

  /// @param network_positions, network_normals of the network's vertices.
  /// @throws SolverFailure; positions and normals are then as before.
  MovedVertices move(const Points& network_positions, const Points& network_normals,
                     const SurfaceMoveOptions& options);

  const Points& positions() const { return positions_; }
  const Points& normals() const { return normals_; }
  Soundness soundness() const;

 private:
  /// Free vertices that hang together, the held ones around them, and the triangles with such a vertex.
  struct Part {
    std::vector<int> vertices, rim, triangles;
    Soundness soundness;
  };

  void find_parts();
  /// Of the network's vertices in positions and, where some are turned, normals: n × 3 or n × 6.
  Eigen::MatrixXd displacement_of(const Points& network_positions, const Points& network_normals,
                                  bool positions_only) const;
  std::vector<int> parts_to_solve(const Eigen::MatrixXd& displacement, SurfaceReach reach) const;
  void spread(const std::vector<int>& parts, Eigen::MatrixXd& displacement);
  Points turned_normals(const std::vector<int>& vertices, const Eigen::MatrixXd& displacement) const;
  /// The displacement n × 3 that takes the change of the curvature target into account.
  Eigen::MatrixXd fitted(const std::vector<int>& parts, const std::vector<int>& vertices,
                         const Points& normals, const Eigen::MatrixXd& displacement);
  void judge(const std::vector<int>& parts);

  FairingSystems& systems_;
  const Triangles& triangles_;
  bool metric_from_layout_;
  SurfaceMethod method_;
  Points given_positions_, given_normals_;  ///< of the network
  Points built_positions_, built_normals_, built_target_;
  std::vector<Part> parts_;
  std::vector<int> loose_triangles_;  ///< all of whose corners are held
  Soundness loose_soundness_;
  Points positions_, normals_;
  std::vector<int> moved_, turned_;  ///< parts whose positions, normals are not those that were built
};

}  // namespace batten::detail
