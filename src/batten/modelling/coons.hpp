#pragma once
#include <array>
#include <vector>

#include <Eigen/Core>

#include "batten/curves/polyline.hpp"

namespace batten {

/// The bilinearly blended Coons patch ([coons1967]; H 6.1.2) of four curves that form a closed loop: the
/// surface x(u, v), u and v in [0, 1], that goes through them and mixes opposite ones linearly. Each curve is
/// taken over the fraction of its length.
class CoonsPatch {
 public:
  /// @param sides one after the other around the patch: along v = 0 with u, along u = 1 with v, along v = 1
  /// against u, along u = 0 against v. A side without length stands for a corner of a triangle.
  /// @pre each side begins where the one before it ends.
  explicit CoonsPatch(std::array<SharedPolyline, 4> sides) : sides_(std::move(sides)) {}

  /// The point x(u, v), u and v in [0, 1].
  Eigen::Vector3d at(double u, double v) const;
  /// `n` + 1 points over the straight line between two places of the parameter square; the ends are those of
  /// the patch.
  Points along(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int n) const;
  /// The parameters of a point of the patch near `query`: the best of a grid, improved by Gauss–Newton steps
  /// as far as they come nearer (H 5.2.2 solves the same conditions).
  Eigen::Vector2d nearest(const Eigen::Vector3d& query) const;

 private:
  std::array<SharedPolyline, 4> sides_;
};

/// The Coons patch of a face with two sides or more (H 6.1).
struct FacePatch {
  CoonsPatch patch;
  /// Per corner of the face (corner k is where side k begins) its (u, v), on the border of the square.
  std::vector<Eigen::Vector2d> parameters;
  /// The face has four sides but for joints where one goes on into the next, as where a curve ends on the
  /// border of a tube: the patch is then as good as that of a face of four sides, however bent.
  bool has_four_corners = false;

  /// Whether both corners lie on one side of the square, so that the patch runs along the border between
  /// them.
  bool on_one_side(int corner, int other) const;
};

/// Associates a quad with a face: the four corners with the smallest internal angles (the first ones where
/// angles are equal) become those of the quad, and the sides between them are joined into one. A triangle
/// gets a side without length at the corner whose two sides are most alike in length; the sides of a face of
/// two are halved.
/// @param sides two or more, one after the other around the face.
FacePatch associate_quad(const std::vector<SharedPolyline>& sides);

/// The corner of a triangle at which its patch has a side without length.
int pole_of_triangle(const std::array<double, 3>& side_lengths);

/// Twice the vector area of a closed loop of polylines, about a point: normal to the face, counter-clockwise.
Eigen::Vector3d doubled_area(const std::vector<SharedPolyline>& sides);

}  // namespace batten
