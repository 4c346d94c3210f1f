#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {

/// A point of a surface that stands for a piece of it.
struct AreaSample {
  Eigen::Vector3d point, normal;  ///< normal: unit, of its triangle
  double area = 0;                ///< of the piece
  int triangle = -1;
};

/// Points spread over a surface by area: the centres of the pieces when every triangle is cut into k² equal
/// ones, the least k for which pieces are at most `largest`. Triangles without area get none.
std::vector<AreaSample> area_samples(const Points& positions, const Triangles& triangles, double largest);

/// Where a sample lies; what it has in common with the others of its triangle is kept once.
struct SamplePoint {
  Eigen::Vector3d point;
  int triangle = -1;
};
/// What the samples of one triangle have in common.
struct SampledTriangle {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit
  double area = 0;                                   ///< of the piece that each of its samples stands for
};

/// A reference surface as a mesh sees it: points spread over the reference, and for each the triangle of the
/// mesh that is nearest. 36 bytes per sample, of which there are some five per triangle.
struct ReferenceSamples {
  std::vector<SamplePoint> points;
  std::vector<int> nearest;             ///< one per point: a triangle of the mesh
  std::vector<SampledTriangle> pieces;  ///< one per triangle of the reference
};

/// Samples of the reference of at most a quarter of the mean area of the mesh's triangles: four and more on a
/// triangle.
/// @throws InvalidInput when the mesh has no triangles or a coordinate is not finite; Cancelled.
ReferenceSamples sample_reference(const Points& positions, const Triangles& triangles,
                                  const Points& reference_positions, const Triangles& reference_triangles,
                                  const Progress& progress = {});

}  // namespace batten
