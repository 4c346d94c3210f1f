#pragma once
#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/curves/bspline.hpp"
#include "batten/modelling/quad_layout_detail.hpp"
#include "batten/subdivision/bspline_surface.hpp"

namespace batten::detail {

/// The clamped cubic B-splines of evenly spread knots that are not zero at t in [0, 1], and their derivatives
/// by t.
CubicBasis spline_basis(double t, int spans);

/// Four times 0, four times 1 and the ends of the spans between.
std::vector<double> clamped_knots(int spans);

/// Bicubic B-spline faces over the quads of a layout, with the control points of corners and sides shared.
/// Opposite sides of a quad have as many spans.
class SplineControls {
 public:
  explicit SplineControls(QuadLayout layout);

  int spans_of_edge(int edge) const;
  int spans_u(const LayoutQuad& quad) const { return spans_of_edge(quad.edges[0]); }
  int spans_v(const LayoutQuad& quad) const { return spans_of_edge(quad.edges[1]); }

  /// Numbers the control points for the spans there are; all lie at the origin then.
  void number_controls();
  /// Number of control point (i, j) of a quad, i along u.
  int control(std::size_t q, int i, int j) const;
  /// Number of control point i inside an edge, counted from its first corner, both ends included.
  int control_of_edge(int edge, int i) const;
  /// Whether side k of a quad has the direction of its edge.
  bool runs_along(const LayoutQuad& quad, int k) const;

  PatchPoint evaluate_at(std::size_t q, double u, double v) const;
  /// The unit normal at t along side k of a quad; zero where the face has none.
  Eigen::Vector3d normal_at(std::size_t q, int k, double t) const;
  /// The largest angle between the normals of both faces along an edge, radians; 0 at sharp edges and
  /// borders.
  double jump_at(std::size_t e) const;

 protected:
  QuadLayout layout_;
  std::vector<int> class_;  ///< per edge: of those with as many spans, the number of one
  std::vector<int> spans_;  ///< per class
  Points controls_;

 private:
  int on_side(const LayoutQuad& quad, int k, int i) const;

  std::vector<int> first_of_edge_, first_of_quad_;  ///< numbers of the control points inside
};

}  // namespace batten::detail
