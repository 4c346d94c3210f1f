#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/halfedge_mesh.hpp"

namespace batten {

/// One feature curve of a surface: a polyline between two different corners, given by arc length.
struct FeatureChain {
  std::vector<int> vertices;    ///< of the input, from corner to corner
  std::vector<double> lengths;  ///< arc length at each vertex, from 0
  std::vector<Eigen::Vector3d> points;

  double length() const { return lengths.back(); }
  /// The point at an arc length, 0 … length().
  Eigen::Vector3d at(double s) const;
};

/// The creases and borders of a surface, cut at corners into chains.
struct FeatureChains {
  std::vector<FeatureChain> chains;
  /// Per vertex of the input: its chain, kNone elsewhere and at corners.
  std::vector<int> chain_of_vertex;
  /// Per vertex of the input: its arc length on that chain.
  std::vector<double> place_of_vertex;
  /// Per vertex of the input: 1 at corners, which stay where they are.
  std::vector<char> is_corner;
};

/// How features are found.
struct FeatureOptions {
  /// Edges whose faces meet at a larger angle (between normals) are kept, radians; π or more keeps none but
  /// borders.
  double crease_angle = 0;
  /// A vertex of a curve that turns by more than this is a corner, radians.
  double corner_angle = 0;
  /// Curves that end freely and are shorter than this are taken for noise and dropped; 0 keeps all.
  double least_length = 0;
  /// Creases are followed beyond their ends while they fade, down to this fraction of crease_angle, where
  /// they stand out from the surface beside them; in (0, 1], 1 follows none.
  double fade = 1;
  /// Every vertex on the border is a corner.
  bool hold_border = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Marks borders and creases in `mesh` (which may hold marks: these are kept too) and cuts them into chains
/// at corners: where the number of marked edges is not 2 and where the curve turns sharply. Closed curves
/// without corners get two, since every chain runs between two of them.
FeatureChains mark_features(HalfedgeMesh& mesh, const FeatureOptions& options);

}  // namespace batten
