#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/control_cage.hpp"

namespace batten {

/// A cubic B-spline curve over [0, 1]; its knots are clamped (the first four 0, the last four 1).
struct BsplineCurve {
  std::vector<double> knots;  ///< one for each control point and four more
  Points control_points;
};

/// A bicubic B-spline surface over the unit square, both knot vectors clamped.
struct BsplinePatch {
  std::vector<double> knots_u, knots_v;
  Points control_points;        ///< point (i, j) is row j · n_u() + i, i along u
  std::array<int, 4> vertices;  ///< at (0, 0), (1, 0), (1, 1), (0, 1): counter-clockwise from outside
  std::array<int, 4> edges;     ///< side k runs from vertex k to vertex k + 1
  int face = 0;                 ///< the face of the cage in which it lies
  bool is_exact = true;         ///< equal to the limit surface everywhere
  Eigen::Index n_u() const { return static_cast<Eigen::Index>(knots_u.size()) - 4; }
  Eigen::Index n_v() const { return static_cast<Eigen::Index>(knots_v.size()) - 4; }
};

/// What two patches share, or the border of one.
struct BsplineEdge {
  BsplineCurve curve;  ///< from the first vertex to the second
  std::array<int, 2> vertices;
  std::array<int, 2> patches;  ///< −1 on the border
  bool is_sharp = false;       ///< a crease: the tangent plane may jump
};

/// The limit surface of a Catmull–Clark cage as B-spline patches that share their edges and vertices.
struct BsplineSurface {
  Points vertices;
  std::vector<BsplineEdge> edges;
  std::vector<BsplinePatch> patches;
  int n_components = 0;
  bool is_closed = false;  ///< no edge on a border
  /// Levels of refinement before the patches were made: for faces that are no quads and for semi-sharp
  /// features.
  int levels = 0;
  int isolation = 0;  ///< halvings towards extraordinary vertices, beside which a patch approximates
  /// The largest distance of the limit surface from its patch found there, in the unit of the cage; 0 where
  /// everything is exact.
  double deviation = 0;
  /// The largest angle between the normals of two patches found along an edge that is not sharp, radians; but
  /// for ends at corners, where the limit surface is a cone without a tangent plane.
  double normal_jump = 0;
};

/// Options of limit_bsplines().
struct BsplineOptions {
  /// The distance from the limit surface to keep near extraordinary vertices, relative to the diameter.
  /// Patches are halved towards these vertices until it is kept, at most `most_isolation` times.
  double tolerance = 1e-5;
  int most_isolation = 6;  ///< 2 to 6; each adds rows of control points to patches at extraordinary vertices
  bool smooth_corners = false;  ///< as SubdivisionOptions::smooth_corners

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// One patch per quad of the cage; a face of n ≠ 4 corners gives n patches and makes four of every quad. The
/// patches are the limit surface itself, up to rounding, except in the cell of side 2^−isolation at
/// extraordinary vertices (valence ≠ 4, darts, creases that no B-spline follows). There a bicubic cell
/// continues the exact ones with continuous derivatives, shares its edges with its neighbours, goes through
/// the limit point and has the limit tangent plane there (docs/subdivide.md). Semi-sharp features (finite
/// sharpness) are resolved: the cage is refined as often as the sharpest lasts.
/// @throws InvalidInput as subdivide(), and where resolving would make more than 200,000 patches; Cancelled.
BsplineSurface limit_bsplines(const ControlCage& cage, const BsplineOptions& options = {},
                              const Progress& progress = {});

/// A point of a patch with its derivatives along u and v. @pre u and v are in [0, 1].
struct PatchPoint {
  Eigen::Vector3d position, along_u, along_v;
};
/// The point at (u, v).
PatchPoint evaluate(const BsplinePatch& patch, double u, double v);
/// Parameters (u, v) of the point at t along side k of a patch, from vertex k on. @pre k is 0, 1, 2 or 3.
std::array<double, 2> on_patch_side(int k, double t);
/// A point of a curve. @pre t is in [0, 1].
Eigen::Vector3d evaluate(const BsplineCurve& curve, double t);

}  // namespace batten
