#pragma once
#include <vector>

#include "batten/network/sharp_curves.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::detail {

/// How the vertices of a surface over a network that was cut open along its sharp curves become those of the
/// surface over the network that was given: copies fall on their place, all behind them move up.
class WeldedSides {
 public:
  /// Of a network without sharp curves: every vertex is itself.
  WeldedSides() = default;
  /// @param n_given vertices of the network before it was cut open.
  WeldedSides(const SharpSplit& split, Eigen::Index n_given);

  bool any() const { return n_copies_ > 0; }
  /// The welded vertex of a vertex of the surface.
  int row(int v) const { return v < n_split_ ? place_[static_cast<std::size_t>(v)] : v - n_copies_; }
  /// The normal of a welded vertex: the mean of its sides.
  Eigen::RowVector3d normal(int row, const Points& normals) const;
  /// Welds the mesh of a result, and `on_network`.
  void weld(SurfaceResult& result) const;

 private:
  int n_split_ = 0, n_copies_ = 0, n_given_ = 0;
  std::vector<int> place_;
  std::vector<std::vector<int>> sides_;  ///< per given vertex: its copies, the first aside
};

}  // namespace batten::detail
