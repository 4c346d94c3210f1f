#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/units.hpp"
#include "batten/render/light_detail.hpp"

namespace batten::detail {

namespace {

/// 0 or 1 in stripes of equal width, softened where they are narrower than a few samples.
float stripe(double phase) {
  return phase - std::floor(phase) < 0.5 ? 1.0F : 0.0F;
}

}  // namespace

Colour normal_circles(const Vector3f& n, const Vector3f& viewer) {
  constexpr float kRings = 9;  ///< of each colour over the hemisphere
  const float angle = std::acos(std::clamp(n.dot(viewer), -1.0F, 1.0F)) / static_cast<float>(kPi / 2);
  const float at = angle * kRings;
  const bool red = at - std::floor(at) < 0.5F;
  const Colour colour = red ? hex_colour(0xd2342e) : hex_colour(0x27489e);
  // Light falls on the hemisphere from above left: left and right, up and down can be told apart.
  const float light = 0.78F + 0.22F * n.dot(Vector3f(-0.5F, 0.7F, 0.5F));
  return light * colour;
}

Colour isophote(const Vector3f& n, const Lighting& lighting, int stripes) {
  // A light beside the viewer: its rings are not the outline again.
  const Vector3f light = Vector3f(-0.35F, 0.50F, 0.79F).normalized();
  const double angle = std::acos(std::clamp(n.dot(light), -1.0F, 1.0F));
  const float white = stripe(angle / kPi * stripes);
  const Colour colour = white * hex_colour(0xf3f4f6) + (1 - white) * hex_colour(0x343b47);
  return lighting.mapped(n, colour);
}

Colour reflection(const Vector3f& n, const Vector3f& viewer, const Lighting& lighting, int stripes) {
  // Lamps are lines along the camera's x axis, tilted a little; the angle of the mirrored ray about that axis
  // tells which lamp is seen.
  const Vector3f mirrored = 2 * n.dot(viewer) * n - viewer;
  const Vector3f axis = Vector3f(0.93F, 0.12F, 0.34F).normalized();
  const Vector3f across = axis.cross(Vector3f::UnitZ()).normalized(), along = axis.cross(across);
  const double angle = std::atan2(mirrored.dot(across), mirrored.dot(along));
  const float lamp = stripe(angle / (2 * kPi) * stripes);
  const float fresnel = 0.25F + 0.75F * std::pow(1 - std::max(0.0F, n.dot(viewer)), 3.0F);
  const Colour body = lighting.diffuse(n).cwiseProduct(hex_colour(0x35527a));
  return body + lamp * (0.55F + 0.3F * fresnel) * hex_colour(0xf4f7fb);
}

}  // namespace batten::detail
