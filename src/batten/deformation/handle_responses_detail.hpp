#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/deformation/constrained_system_detail.hpp"

// Private to the room.
namespace batten::detail {

/// The answers of a mesh to affine moves of its handles. They are linear in the few numbers that describe
/// such a move, translations and turns among them, so that no system is left to solve [botsch2004framework].
class HandleResponses {
 public:
  /// @param system, rest must outlive this.
  /// @param diameter of the mesh.
  HandleResponses(const ConstrainedSystem& system, const Points& rest, const Triangles& triangles,
                  double diameter);

  /// Adds to the rest shape the answer to displacements (c × 3) that are affine on every region of connected
  /// constraints. The first call for a region solves for its response.
  /// @return false, with X undefined, where some region moves otherwise, or there are too many.
  bool respond(const Points& displacements, Points& X) const;

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Constrained vertices that hang together along edges and, as parts of one handle, mostly move as one.
  struct Region {
    std::vector<Eigen::Index> rows;  ///< of the constraints
    Eigen::MatrixXd basis;  ///< rows × r: orthonormal affine functions of the rest positions, r ≤ 4
    std::once_flag once;
    RowMajor response;  ///< n × r: how all vertices answer to the basis; computed when first asked for
  };

  void find_regions(const Triangles& triangles);
  void set_basis(Region& region, double diameter) const;

  const ConstrainedSystem& system_;
  const Points& rest_;
  std::vector<std::unique_ptr<Region>> regions_;  ///< empty where there are too many
};

}  // namespace batten::detail
