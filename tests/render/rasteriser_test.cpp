#include "batten/render/rasteriser.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/parallel.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

constexpr int kSize = 120;

/// Straight down onto the square [−1, 1]², which fills the picture: x right, y up.
PictureCamera from_above() {
  const Points square = (Points(4, 3) << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0).finished();
  View view = parse_view("top");
  view.perspective = false;
  return {square, view, 0, 0, kSize, kSize};
}

Colour black(double) {
  return Colour::Zero();
}

/// The pixel that shows a point.
const std::uint8_t* pixel(const Image& image, const PictureCamera& camera, const Vector3d& world) {
  const Vector3d at = camera.project(camera.to_camera(world));
  return image.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
}

/// Share of the light of the picture, of white ones.
double light(const Image& image) {
  double sum = 0;
  for (const std::uint8_t byte : image.pixels) {
    const double s = byte / 255.0;  // sRGB
    sum += s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return sum / static_cast<double>(image.pixels.size());
}

// Half the square is half the light, whatever the samples; the weights that the shader gets are those of the
// point it is asked for.
TEST(Rasterise, CoversATriangleAndInterpolatesOverIt) {
  const PictureCamera camera = from_above();
  Scene scene;
  scene.positions = (Points(3, 3) << -1, -1, 0, 1, -1, 0, 1, 1, 0).finished();
  scene.triangles = (Triangles(1, 3) << 0, 1, 2).finished();
  for (const int samples : {1, 3}) {
    Image image(kSize, kSize, Colour::Zero());
    rasterise(
        image, scene, camera, samples,
        [&](const Hit& hit) -> Colour {
          EXPECT_EQ(hit.triangle, 0);
          EXPECT_EQ(hit.tube, -1);
          EXPECT_NEAR(hit.weights.sum(), 1, 1e-9);
          EXPECT_GE(hit.weights.minCoeff(), -1e-9);
          Vector3d there = Vector3d::Zero();
          for (int k = 0; k < 3; ++k)
            there += hit.weights[k] * camera.to_camera(scene.positions.row(k).transpose());
          EXPECT_LT((there - hit.position).norm(), 1e-9);
          EXPECT_LT((hit.normal - Vector3d::UnitZ()).norm(), 1e-12);
          EXPECT_LT((hit.viewer - Vector3d::UnitZ()).norm(), 1e-12);
          return Colour::Ones();
        },
        black);
    EXPECT_NEAR(light(image), 0.5, 1.0 / kSize) << samples;
  }
}

// The nearer of two hides the other, in whichever order they come; equal ones go to the lower index.
TEST(Rasterise, ShowsTheNearestAndOfEqualOnesTheFirst) {
  const PictureCamera camera = from_above();
  for (const double upper : {-0.3, 0.0, 0.3}) {
    Scene scene;
    scene.positions =
        (Points(6, 3) << -1, -1, 0, 1, -1, 0, 0, 1, 0, -1, -1, upper, 1, -1, upper, 0, 1, upper).finished();
    scene.triangles = (Triangles(2, 3) << 0, 1, 2, 3, 4, 5).finished();
    Image image(kSize, kSize, Colour::Zero());
    rasterise(
        image, scene, camera, 2,
        [](const Hit& hit) -> Colour {
          return hit.triangle == 0 ? Colour(Colour::UnitX()) : Colour(Colour::UnitY());
        },
        black);
    const std::uint8_t* seen = pixel(image, camera, {0, -0.3, 0});
    EXPECT_EQ(seen[0], upper > 0 ? 0 : 255) << upper;
    EXPECT_EQ(seen[1], upper > 0 ? 255 : 0) << upper;
  }
}

// A tube of the radius r over the length l covers 2 r l, with half a disc at each end: π r². What lies before
// it hides it.
TEST(Rasterise, TubesHaveTheirWidthAndAreHidden) {
  const PictureCamera camera = from_above();
  const double per_unit = kSize / 2.0, radius = 6;
  Scene scene;
  scene.positions = Points(0, 3);
  scene.triangles = Triangles(0, 3);
  scene.tubes.push_back({{-0.5, 0.2, 0}, {0.5, 0.2, 0}, radius, Colour::Ones()});
  const auto drawn = [&] {
    Image image(kSize, kSize, Colour::Zero());
    rasterise(
        image, scene, camera, 4,
        [](const Hit& hit) -> Colour {
          return hit.tube == 0 ? Colour(Colour::Ones()) : Colour(Colour::Zero());
        },
        black);
    return image;
  };
  const double area = 2 * radius * per_unit + kPi * radius * radius;
  EXPECT_NEAR(light(drawn()) * kSize * kSize, area, 0.02 * area);
  scene.tubes[0].to = scene.tubes[0].from;
  EXPECT_NEAR(light(drawn()) * kSize * kSize, kPi * radius * radius, 0.05 * kPi * radius * radius);
  scene.positions = (Points(3, 3) << -3, -3, 0.5, 3, -3, 0.5, 0, 3, 0.5).finished();
  scene.triangles = (Triangles(1, 3) << 0, 1, 2).finished();
  EXPECT_EQ(light(drawn()), 0);
}

// Where nothing is the background shows, by its row from 0 at the top to 1 at the bottom.
TEST(Rasterise, PutsTheBackgroundWhereNothingIs) {
  Image image(kSize, kSize, Colour::Ones());
  Scene scene;
  scene.positions = Points(0, 3);
  scene.triangles = Triangles(0, 3);
  rasterise(
      image, scene, from_above(), 2, [](const Hit&) -> Colour { return Colour::Zero(); },
      [](double row) -> Colour { return row < 0.5 ? Colour(Colour::UnitX()) : Colour(Colour::UnitZ()); });
  EXPECT_EQ(image.at(3, 10)[0], 255);
  EXPECT_EQ(image.at(3, 10)[2], 0);
  EXPECT_EQ(image.at(3, kSize - 10)[0], 0);
  EXPECT_EQ(image.at(3, kSize - 10)[2], 255);
}

}  // namespace
}  // namespace batten
