#pragma once
#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "batten/render/colour.hpp"

// How surfaces are lit, and patterns of light that show their quality. All directions are unit vectors in
// camera coordinates. Private to the room.
namespace batten::detail {

using Eigen::Vector3f;

/// Lights fixed to the camera: a large warm one from above left, a cool one from the right, a faint one from
/// behind, and a sky that is brighter above. Large lights reach round the edge (wrap), so shadows are soft.
struct Lighting {
  Vector3f key = Vector3f(-0.42F, 0.62F, 0.66F).normalized(),
           fill = Vector3f(0.85F, 0.05F, 0.52F).normalized(),
           back = Vector3f(0.1F, 0.55F, -0.83F).normalized();
  Vector3f up;  ///< the world's up in camera coordinates

  static float wrapped(const Vector3f& n, const Vector3f& light, float wrap) {
    return std::max(0.0F, (n.dot(light) + wrap) / (1 + wrap));
  }

  Colour diffuse(const Vector3f& n) const {
    const float sky = 0.5F + 0.5F * n.dot(up);
    Colour light = (0.07F + 0.19F * sky) * Colour(0.94F, 0.97F, 1.0F);
    light += 0.74F * wrapped(n, key, 0.10F) * Colour(1.0F, 0.975F, 0.94F);
    light += 0.17F * wrapped(n, fill, 0.3F) * Colour(0.90F, 0.95F, 1.0F);
    light += 0.12F * wrapped(n, back, 0.1F) * Colour(1.0F, 1.0F, 1.0F);
    return light;
  }
  float specular(const Vector3f& n, const Vector3f& viewer, float shininess) const {
    const float s = std::max(0.0F, n.dot((key + viewer).normalized()));
    return std::pow(s, shininess);
  }
  Colour matt(const Vector3f& n, const Vector3f& viewer, const Colour& material) const {
    const float fresnel = std::pow(1 - std::max(0.0F, n.dot(viewer)), 4.0F);
    return 1.10F * diffuse(n).cwiseProduct(material) +
           Colour::Constant(0.06F * specular(n, viewer, 18) + 0.05F * specular(n, viewer, 90) +
                            0.06F * fresnel);
  }
  /// Shading that leaves the colours of a map readable.
  Colour mapped(const Vector3f& n, const Colour& colour) const {
    return (0.66F + 0.40F * diffuse(n)[1]) * colour;
  }
};

/// The red and blue circles of S fig. 4.24 about the viewer.
Colour normal_circles(const Vector3f& n, const Vector3f& viewer);
/// Stripes of equal angle between the normal and a light: `stripes` over half a turn.
Colour isophote(const Vector3f& n, const Lighting& lighting, int stripes);
/// A row of parallel lamps mirrored in the surface.
Colour reflection(const Vector3f& n, const Vector3f& viewer, const Lighting& lighting, int stripes);

}  // namespace batten::detail
