#include "batten/camera/camera.hpp"

#include "camera/rigs.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

TEST(Camera, UndistortsEveryPixelOfItsImage) {
  const Camera camera = test::webcam();
  for (int v = 0; v <= camera.height; v += 20)
    for (int u = 0; u <= camera.width; u += 20) {
      const auto ray = undistort(camera, {u, v});
      ASSERT_TRUE(ray.has_value()) << u << ' ' << v;
      EXPECT_LT((to_pixel(camera, distort(camera, *ray)) - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
}

TEST(Camera, ProjectsTheCentreOfTheFirstPixelToOneHalf) {
  Camera camera;
  camera.width = camera.height = 100;
  camera.fx = camera.fy = 50;
  camera.cx = camera.cy = 0.5;
  EXPECT_EQ(project(camera, {0, 0, 3}), Eigen::Vector2d(0.5, 0.5));
  // x to the right, y down: half a metre at one metre is half the focal length.
  EXPECT_EQ(project(camera, {0.5, -0.5, 1}), Eigen::Vector2d(25.5, -24.5));
}

TEST(Camera, JacobianIsThatOfDifferences) {
  const Camera camera = test::webcam();
  const Eigen::Vector3d point(0.31, -0.22, 0.8);
  Eigen::Matrix<double, 2, 3> jacobian;
  project(camera, point, &jacobian);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d difference = (project(camera, point + step) - project(camera, point - step)) / 2e-5;
    EXPECT_LT((jacobian.col(k) - difference).norm(), 1e-5 * difference.norm() + 1e-6);
  }
}

TEST(Camera, PixelsBeyondTheFoldOfTheLensModelBelongToNoRay) {
  Camera camera = test::webcam();
  camera.k1 = -0.5;
  camera.k2 = camera.k3 = camera.p1 = camera.p2 = 0;
  // r (1 − r²/2) grows up to r = √(2/3), where it is 0.5443.
  const double largest = std::sqrt(2.0 / 3) * 2 / 3;
  EXPECT_TRUE(undistort(camera, to_pixel(camera, {0.999 * largest, 0})));
  EXPECT_FALSE(undistort(camera, to_pixel(camera, {1.001 * largest, 0})));
  const auto near = undistort(camera, to_pixel(camera, distort(camera, {0.8, 0})));
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->x(), 0.8, 1e-9);  // not the other solution, 0.83
}

TEST(Camera, FoldsThatALaterTermUndoesStillEndTheImage) {
  Camera camera = test::webcam();
  camera.k1 = -0.6;
  camera.k2 = 0.1;
  camera.k3 = 0.02;
  camera.p1 = camera.p2 = 0;
  for (double r = 0.05; r < 3; r += 0.05) {
    const auto ray = undistort(camera, to_pixel(camera, distort(camera, {r, 0})));
    const double slope = 1 - 1.8 * r * r + 0.5 * std::pow(r, 4) + 0.14 * std::pow(r, 6);
    if (slope > 0.01 && r < 0.8) {
      ASSERT_TRUE(ray) << r;
      EXPECT_NEAR(ray->x(), r, 1e-8);
    } else if (ray) {
      EXPECT_LT(ray->norm(), 0.87) << r;  // the ray before the fold, never one behind it
    }
  }
}

TEST(Camera, ProblemsNameFieldAndValue) {
  EXPECT_EQ(problem(test::webcam()), "");
  Camera camera = test::webcam();
  camera.fy = -3;
  EXPECT_NE(problem(camera).find("fy is -3"), std::string::npos);
  camera = test::webcam();
  camera.width = 0;
  EXPECT_NE(problem(camera).find("width is 0"), std::string::npos);
  camera = test::webcam();
  camera.p2 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(problem(camera).find("p2"), std::string::npos);
}

}  // namespace
}  // namespace batten
