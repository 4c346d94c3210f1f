#include "batten/render/camera.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

TEST(PictureCamera, ShowsAllPointsAndTouchesTheFrame) {
  const Points points = fixtures::blob(8).positions;
  for (const bool perspective : {true, false})
    for (const double azimuth : {0.0, 77.0, 200.0}) {
      const PictureCamera camera(points, View{azimuth, 31, perspective}, 10, 20, 300, 200);
      double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Vector3d p = camera.project(camera.to_camera(points.row(i)));
        low_x = std::min(low_x, p.x());
        high_x = std::max(high_x, p.x());
        low_y = std::min(low_y, p.y());
        high_y = std::max(high_y, p.y());
        EXPECT_GT(p.z(), 0);
        EXPECT_LT(p.z(), 1);
      }
      EXPECT_GE(low_x, 10 - 1e-9);
      EXPECT_LE(high_x, 310 + 1e-9);
      EXPECT_GE(low_y, 20 - 1e-9);
      EXPECT_LE(high_y, 220 + 1e-9);
      EXPECT_NEAR(std::max((high_x - low_x) / 300, (high_y - low_y) / 200), 1, 1e-9);
    }
}

// x to the right, z up from the front; y up from the top; a left hand is never shown.
TEST(PictureCamera, NamedViewsFaceTheRightWay) {
  Points cube(2, 3);
  cube << -1, -1, -1, 1, 1, 1;
  const auto seen = [&](const char* name, const Vector3d& direction) {
    View view = parse_view(name);
    view.perspective = false;
    return PictureCamera(cube, view, 0, 0, 100, 100).to_camera(direction);
  };
  EXPECT_LT((seen("front", Vector3d::UnitX()) - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((seen("front", Vector3d::UnitZ()) - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((seen("top", Vector3d::UnitX()) - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((seen("top", Vector3d::UnitY()) - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((seen("right", Vector3d::UnitX()) - Vector3d::UnitZ()).norm(), 1e-12);
  for (const char* name : {"three-quarter", "back", "left", "bottom", "30,-60"}) {
    const View view = parse_view(name);
    EXPECT_NEAR(PictureCamera(cube, view, 0, 0, 9, 9).rotation().determinant(), 1, 1e-12) << name;
  }
}

// The axis that points up is drawn upright, whichever it is.
TEST(PictureCamera, AnyAxisMayPointUp) {
  Points cube(2, 3);
  cube << -1, -1, -1, 1, 1, 1;
  for (int axis = 0; axis < 3; ++axis) {
    View view = parse_view("front");
    view.up_axis = axis;
    const PictureCamera camera(cube, view, 0, 0, 9, 9);
    EXPECT_LT((camera.rotation() * Vector3d::Unit(axis) - Vector3d::UnitY()).norm(), 1e-12);
    EXPECT_NEAR(camera.rotation().determinant(), 1, 1e-12);
  }
}

// A ray through the pixel of a point passes the point.
TEST(PictureCamera, RaysInvertTheProjection) {
  const Points points = fixtures::blob(4).positions;
  for (const bool perspective : {true, false}) {
    const PictureCamera camera(points, View{20, 30, perspective}, 0, 0, 320, 200);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Vector3d p = camera.to_camera(points.row(i));
      const Vector3d pixel = camera.project(p);
      Vector3d origin, direction;
      camera.ray(pixel.x(), pixel.y(), origin, direction);
      const double t = (p.z() - origin.z()) / direction.z();
      EXPECT_LT((origin + t * direction - p).norm(), 1e-12);
    }
  }
}

TEST(PictureCamera, RefusesBadViews) {
  for (const char* bad : {"", "side", "10", "10,", "10,91", "nan,0", "1,2,3"})
    EXPECT_THROW(parse_view(bad), InvalidInput) << bad;
  EXPECT_THROW(PictureCamera(Points(0, 3), View{}, 0, 0, 9, 9), InvalidInput);
  View view;
  view.zoom = 0;
  EXPECT_THROW(PictureCamera(Points::Zero(1, 3), view, 0, 0, 9, 9), InvalidInput);
}

}  // namespace
}  // namespace batten
