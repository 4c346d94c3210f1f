#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/modelling/coons.hpp"
#include "batten/modelling/triquadrification.hpp"

// Private to the room.
namespace batten::detail {

/// A face as the searches for its division see it.
class SplitOutline {
 public:
  explicit SplitOutline(const std::vector<SharedPolyline>& sides);

  int n() const { return n_; }
  const Eigen::Vector3d& corner(int k) const { return corners_[at(k)]; }
  /// Whether the face is taken to lie over a plane: its outline, seen along the normal, does not cross
  /// itself, it is not bent as far as half a tube, and it is not a bent face of four corners, between which
  /// its patch is known better. Then inside and outside are known.
  bool is_simple() const { return is_simple_; }
  /// Whether the outline, seen along the normal, is not convex. @pre is_simple().
  bool has_reflex_corner() const;
  Eigen::Vector2d flat(const Eigen::Vector3d& p) const {
    return {(p - origin_).dot(first_), (p - origin_).dot(second_)};
  }

  /// Flaws of the diagonal between two corners; sides have none.
  int flaws_of_diagonal(int i, int j) const;

  /// Whether a curve seen along the normal leaves the face between its ends. @pre is_simple().
  bool leaves(const Points& curve) const;

  /// What one part costs, without its diagonals.
  SplitCost cost_of_part(const int* part, int size) const;

  /// Heights over the plane of the face at points of it, from those of the outline.
  Points lifted(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int n_segments) const;

 private:
  /// A diagonal over the Coons patch of a face that is not taken to lie over a plane, from one corner to the
  /// other.
  struct Over {
    Eigen::Vector3d swept, leaving;
    bool along_border = false;
  };

  size_t entry(int i, int j) const { return at(i) * at(n_) + at(j); }

  /// Takes diagonals as lines of the Coons patch of the associated quad: straight ones would cut through the
  /// face.
  void follow_patch(const FacePatch& quad);

  Eigen::Vector3d leaving(int from, int to) const;

  bool is_bent() const;

  bool is_side(int i, int j) const { return (i + 1) % n_ == j; }
  Eigen::Vector3d direction(int from, int to) const { return (corner(to) - corner(from)).stableNormalized(); }

  static double interior_angle(const Eigen::Vector3d& next, const Eigen::Vector3d& last,
                               const Eigen::Vector3d& normal);

  bool contains(const Eigen::Vector2d& q) const;

  double clearance(const Eigen::Vector2d& q) const;

  bool crosses_outline(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;

  int n_;
  Eigen::Vector3d normal_, origin_, first_, second_;
  std::vector<Eigen::Vector3d> corners_, out_, back_, swept_;
  std::vector<Eigen::Vector2d> outline_;
  std::vector<double> heights_;
  bool is_simple_ = false;
  mutable std::vector<int> leaves_;
  std::vector<Over> diagonals_;  ///< per pair of corners; empty for faces over a plane
};

}  // namespace batten::detail
