#pragma once
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/render/camera.hpp"
#include "batten/render/image.hpp"

namespace batten {

/// A straight tube of constant width in the picture; a ball where both ends are the same.
struct Tube {
  Eigen::Vector3d from, to;  ///< world coordinates
  double radius = 1;         ///< in pixels
  Colour colour = Colour::Zero();
};

/// What the rasteriser draws: triangles as faces, curves and nodes as tubes, hidden by what lies before them.
struct Scene {
  Points positions;
  Triangles triangles;
  std::vector<Tube> tubes;
};

/// What is seen at one sample of the picture.
struct Hit {
  int triangle = -1;         ///< or −1 for a tube
  int tube = -1;             ///< or −1 for a triangle
  Eigen::Vector3d weights;   ///< of the corners of the triangle, sum 1
  Eigen::Vector3d position;  ///< camera coordinates
  Eigen::Vector3d normal;    ///< unit, camera: of the flat triangle as wound, of the tube
  Eigen::Vector3d viewer;    ///< unit, camera: towards the viewer
  double pixel_size = 0;     ///< length of a pixel there, world units
};

/// Colour of a hit in linear light. Called from several threads.
using Shader = std::function<Colour(const Hit&)>;

/// Draws a scene over a picture, `samples` × `samples` per pixel averaged in linear light, with a depth
/// buffer. Deterministic: equal depths go to the lower index, whatever the number of threads.
/// @param background colour of a row (0 top … 1 bottom) where nothing is.
void rasterise(Image& image, const Scene& scene, const PictureCamera& camera, int samples,
               const Shader& shader, const std::function<Colour(double)>& background,
               const Progress& progress = {});

}  // namespace batten
