#include "batten/render/camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

using Eigen::Vector3d;

namespace {

/// Half the angle of view: narrow, as a product photograph, so that shapes keep their proportions.
const double kTangent = std::tan(radians(11));

}  // namespace

View parse_view(std::string_view text) {
  View view;
  struct Named {
    const char* name;
    double azimuth, elevation;
  };
  for (const Named& named : {Named{"three-quarter", view.azimuth_deg, view.elevation_deg},
                             Named{"front", -90, 0}, Named{"back", 90, 0}, Named{"left", 180, 0},
                             Named{"right", 0, 0}, Named{"top", -90, 90}, Named{"bottom", -90, -90}})
    if (text == named.name) {
      view.azimuth_deg = named.azimuth;
      view.elevation_deg = named.elevation;
      return view;
    }
  const auto fields = split_fields(text, ',');
  if (fields.size() != 2 || !parse_number(fields[0], view.azimuth_deg) ||
      !parse_number(fields[1], view.elevation_deg) || !(std::abs(view.azimuth_deg) <= 3600) ||
      !(std::abs(view.elevation_deg) <= 90))
    throw InvalidInput(
        concat("a view is front, back, left, right, top, bottom, three-quarter or azimuth,elevation "
               "in degrees with the elevation from -90 to 90, got '",
               text, "'"));
  return view;
}

PictureCamera::PictureCamera(const Points& points, const View& view, double left, double top, double width,
                             double height)
    : perspective_(view.perspective) {
  if (!(view.zoom > 0)) throw InvalidInput(concat("the zoom must be above 0, got ", view.zoom));
  const double a = radians(view.azimuth_deg), e = radians(view.elevation_deg);
  if (view.up_axis < 0 || view.up_axis > 2)
    throw InvalidInput(concat("the axis that points up is 0, 1 or 2, got ", view.up_axis));
  const Vector3d up = Vector3d::Unit(view.up_axis), x = Vector3d::Unit((view.up_axis + 1) % 3),
                 y = Vector3d::Unit((view.up_axis + 2) % 3);
  const Vector3d backward = std::cos(e) * (std::cos(a) * x + std::sin(a) * y) + std::sin(e) * up;
  const Vector3d right = -std::sin(a) * x + std::cos(a) * y;
  rotation_.row(0) = right.transpose();
  rotation_.row(1) = Vector3d(backward.y() * right.z() - backward.z() * right.y(),
                              backward.z() * right.x() - backward.x() * right.z(),
                              backward.x() * right.y() - backward.y() * right.x())
                         .transpose();
  rotation_.row(2) = backward.transpose();

  Points seen(points.rows(), 3);
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (points.row(i).allFinite()) seen.row(n++) = points.row(i) * rotation_.transpose();
  if (n == 0) throw InvalidInput("there is nothing to draw: no point with finite coordinates");
  seen.conservativeResize(n, 3);
  const Vector3d low = seen.colwise().minCoeff(), high = seen.colwise().maxCoeff();
  const Vector3d middle = 0.5 * (low + high);
  target_ = rotation_.transpose() * middle;
  seen.rowwise() -= middle.transpose();
  double extent = (high - low).norm();
  if (!(extent > 0)) extent = 1;

  // The narrower side of the picture sees kTangent; the viewer goes back until everything is in sight.
  const double side = std::min(width, height);
  const double reach_x = kTangent * width / side, reach_y = kTangent * height / side;
  double shift_x = 0, shift_y = 0;
  distance_ = 0.6 * extent;
  for (Eigen::Index i = 0; i < n; ++i)
    distance_ = std::max({distance_, seen(i, 2) + std::abs(seen(i, 0)) / reach_x,
                          seen(i, 2) + std::abs(seen(i, 1)) / reach_y});
  Vector3d low_seen = Vector3d::Constant(std::numeric_limits<double>::infinity()), high_seen = -low_seen;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double w = perspective_ ? distance_ - seen(i, 2) : 1;
    const Vector3d p(seen(i, 0) / w, seen(i, 1) / w, seen(i, 2));
    low_seen = low_seen.cwiseMin(p);
    high_seen = high_seen.cwiseMax(p);
  }
  // Centre what is seen and fill the frame.
  const Vector3d size = high_seen - low_seen;
  scale_ = std::min(size.x() > 0 ? width / size.x() : 1e300, size.y() > 0 ? height / size.y() : 1e300);
  if (scale_ >= 1e300) scale_ = side / extent * (perspective_ ? distance_ : 1);
  scale_ *= view.zoom;
  shift_x = 0.5 * (low_seen.x() + high_seen.x());
  shift_y = 0.5 * (low_seen.y() + high_seen.y());
  centre_x_ = left + 0.5 * width - scale_ * shift_x;
  centre_y_ = top + 0.5 * height + scale_ * shift_y;
  far_ = raw_depth(low_seen.z() - 0.05 * extent);
  depth_range_ = raw_depth(high_seen.z() + 0.05 * extent) - far_;
}

Vector3d PictureCamera::project(const Vector3d& p) const {
  const double w = perspective_ ? distance_ - p.z() : 1;
  return {centre_x_ + scale_ * p.x() / w, centre_y_ - scale_ * p.y() / w,
          (raw_depth(p.z()) - far_) / depth_range_};
}

Vector3d PictureCamera::towards_viewer(const Vector3d& p) const {
  return perspective_ ? (Vector3d(0, 0, distance_) - p).normalized() : Vector3d(0, 0, 1);
}

void PictureCamera::ray(double pixel_x, double pixel_y, Vector3d& origin, Vector3d& direction) const {
  const double x = (pixel_x - centre_x_) / scale_, y = (centre_y_ - pixel_y) / scale_;
  if (perspective_) {
    origin = Vector3d(x * distance_, y * distance_, 0);
    direction = Vector3d(x, y, -1);
  } else {
    origin = Vector3d(x, y, 0);
    direction = Vector3d(0, 0, -1);
  }
}

double PictureCamera::pixel_size(const Vector3d& p) const {
  return (perspective_ ? distance_ - p.z() : 1) / scale_;
}

}  // namespace batten
