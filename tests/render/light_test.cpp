#include <gtest/gtest.h>

#include "batten/render/light_detail.hpp"

namespace batten {
namespace {

using detail::Lighting;
using Eigen::Vector3f;

Lighting lighting() {
  Lighting lights;
  lights.up = Vector3f::UnitY();
  return lights;
}

// The warm key light comes from above left, the cool fill from the right.
TEST(Lighting, IsWarmerAndStrongerTowardsTheKeyLight) {
  const Lighting lights = lighting();
  const Colour key = lights.diffuse(lights.key), away = lights.diffuse(-lights.key);
  EXPECT_GT(key.sum(), 2 * away.sum());
  EXPECT_GT(key[0] / key[2], 1);
  EXPECT_GT(lights.diffuse(lights.fill)[2] / lights.diffuse(lights.fill)[0], key[2] / key[0]);
}

TEST(Lighting, WrappedLightEndsWhereTheWrapSays) {
  const Vector3f light = Vector3f::UnitX();
  EXPECT_FLOAT_EQ(Lighting::wrapped(light, light, 0.3F), 1);
  EXPECT_GT(Lighting::wrapped(Vector3f(-0.2F, 0.98F, 0), light, 0.3F), 0);
  EXPECT_EQ(Lighting::wrapped(-light, light, 0.3F), 0);
}

TEST(Isophote, ChangesWithTheAngleToItsLight) {
  const Lighting lights = lighting();
  int changes = 0;
  Colour before = detail::isophote(Vector3f::UnitZ(), lights, 28);
  for (int i = 1; i <= 1000; ++i) {
    const auto angle = static_cast<float>(i * 3.14159265 / 2 / 1000);
    const Colour now = detail::isophote(Vector3f(std::sin(angle), 0, std::cos(angle)), lights, 28);
    if ((now - before).cwiseAbs().maxCoeff() > 0.3F) ++changes;
    before = now;
  }
  // From 38 to 110 degrees from the light, and two changes in each of 28 periods over 180 degrees.
  EXPECT_NEAR(changes, (110.5 - 38) / 180 * 28 * 2, 1);
}

TEST(NormalCircles, AreRoundAboutTheViewer) {
  const Vector3f viewer = Vector3f::UnitZ();
  const auto is_red = [&](double polar, double around) {
    const Vector3f n(static_cast<float>(std::sin(polar) * std::cos(around)),
                     static_cast<float>(std::sin(polar) * std::sin(around)),
                     static_cast<float>(std::cos(polar)));
    const Colour colour = detail::normal_circles(n, viewer);
    return colour[0] > colour[2];
  };
  // Nine rings over 90 degrees: half a ring is five degrees.
  for (int ring = 0; ring < 18; ++ring)
    for (const double around : {0.0, 1.0, 2.5, 4.0})
      EXPECT_EQ(is_red((ring + 0.5) * 3.14159265 / 36, around), ring % 2 == 0) << ring;
}

}  // namespace
}  // namespace batten
