#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// The image of a curve in its least-squares plane (H 5.1.1): the plane holds the axis and lies closest to
/// the curve; points are brought into it and then mirrored at the axis.
Points mirrored(const Points& points, const Vector3d& on_axis, const Vector3d& axis) {
  // The normal of the plane: least variance among the directions square to the axis.
  const Points moved = points.rowwise() - on_axis.transpose();
  const Vector3d across = axis.unitOrthogonal(), beside = axis.cross(across);
  Eigen::Matrix<double, Eigen::Dynamic, 2> square(points.rows(), 2);
  square.col(0) = moved * across;
  square.col(1) = moved * beside;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(square.transpose() * square);
  const Eigen::Vector2d largest = solver.eigenvectors().col(1);
  const Vector3d in_plane = across * largest(0) + beside * largest(1);
  Points image(points.rows(), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector3d p = moved.row(i);
    image.row(i) = (on_axis + axis * axis.dot(p) - in_plane * in_plane.dot(p)).transpose();
  }
  return image;
}

/// @throws RefusedEdit when the axis is not two different finite points.
std::pair<Vector3d, Vector3d> axis_of(const std::optional<Points>& axis, const Points& points) {
  Points ends(2, 3);
  if (axis)
    ends = *axis;
  else
    ends << points.row(0), points.row(points.rows() - 1);
  if (ends.rows() != 2 || !ends.allFinite() ||
      !((ends.row(1) - ends.row(0)).norm() > 1e-12 * ends.cwiseAbs().maxCoeff()))
    throw RefusedEdit(axis ? "the two points of the axis are one or not finite"
                           : "the ends of the curve lie on each other and give no axis",
                      "give an axis of two different points");
  return {ends.row(0), (ends.row(1) - ends.row(0)).normalized()};
}

}  // namespace

EditReport mirror_curve(PolylineMesh& mesh, int curve, const std::optional<Points>& axis,
                        const InsertOptions& options) {
  detail::require_curve(mesh, curve);
  const Points points = polyline_of_curve(mesh, curve)->points();
  const auto [on_axis, direction] = axis_of(axis, points);
  DrawnStroke image{mirrored(points, on_axis, direction), false};
  const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  double furthest = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    furthest = std::max(furthest, (points.row(i).transpose() - on_axis).cross(direction).norm());
  if (furthest < 1e-9 * size)
    throw RefusedEdit(concat("c", curve, " lies on the axis, so its image is c", curve, " itself"),
                      "give an axis beside the curve");
  InsertOptions used = options;
  used.snap = detail::snap_or_default(mesh, image.points, options);
  return insert_curve(mesh, image, used);
}

EditReport mirror_stroke(PolylineMesh& mesh, const DrawnStroke& stroke, const std::optional<Points>& axis,
                         const InsertOptions& options) {
  const double snap = detail::snap_or_default(mesh, stroke.points, options);
  if (stroke.points.rows() < 2)
    throw RefusedEdit("the stroke has fewer than two points", "draw a longer stroke");
  if (!stroke.points.allFinite())
    throw RefusedEdit("a point of the stroke is not finite", "leave this point out");
  const auto [on_axis, direction] = axis_of(axis, stroke.points);
  const Points image = mirrored(stroke.points, on_axis, direction);
  const Eigen::Index n = stroke.points.rows();
  for (const Eigen::Index end : {Eigen::Index{0}, n - 1}) {
    const double gap = (stroke.points.row(end) - image.row(end)).norm();
    if (gap > 2 * snap)
      throw RefusedEdit(
          concat("the stroke ", end == 0 ? "starts " : "ends ", detail::text_of_length(gap / 2),
                 " from the axis, more than the snapping distance of ", detail::text_of_length(snap)),
          "draw it from the axis to the axis, or leave the axis out");
  }
  // There and back; the ends, which lie on the axis, are counted once.
  DrawnStroke whole;
  whole.closed = true;
  whole.points.resize(2 * n - 2, 3);
  whole.points.topRows(n) = stroke.points;
  whole.points.bottomRows(n - 2) = image.middleRows(1, n - 2).colwise().reverse();
  if (n < 3) throw RefusedEdit("the stroke is a straight line on the axis", "draw it beside the axis");
  return insert_curve(mesh, whole, options);
}

}  // namespace batten
