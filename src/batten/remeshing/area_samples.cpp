#include "batten/remeshing/area_samples.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace batten {

std::vector<AreaSample> area_samples(const Points& positions, const Triangles& triangles, double largest) {
  using Eigen::Vector3d;
  std::vector<AreaSample> samples;
  samples.reserve(triangles.rows());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                   c = positions.row(triangles(f, 2));
    const Vector3d cross = (b - a).cross(c - a);
    const double area = 0.5 * cross.norm();
    if (!(area > 0)) continue;
    // A hair less than the root, so that a triangle of just the largest area is not cut.
    const int k = std::max(1, static_cast<int>(std::ceil(std::sqrt(area / largest) - 1e-9)));
    const double part = 1.0 / k;
    for (int i = 0; i < k; ++i)
      for (int j = 0; i + j < k; ++j)
        for (const double third : {1.0 / 3, 2.0 / 3}) {
          // A cell of the grid holds two pieces, but for the cells along the far side.
          if (third > 0.5 && i + j == k - 1) continue;
          AreaSample sample;
          sample.point = a + (i + third) * part * (b - a) + (j + third) * part * (c - a);
          sample.normal = cross / (2 * area);
          sample.area = area * part * part;
          sample.triangle = static_cast<int>(f);
          samples.push_back(sample);
        }
  }
  return samples;
}

ReferenceSamples sample_reference(const Points& positions, const Triangles& triangles,
                                  const Points& reference_positions, const Triangles& reference_triangles) {
  using Eigen::Vector3d;
  double area = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                   c = positions.row(triangles(f, 2));
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  ReferenceSamples result;
  result.samples =
      area_samples(reference_positions, reference_triangles,
                   area / (4.0 * static_cast<double>(std::max<Eigen::Index>(1, triangles.rows()))));
  Points points(static_cast<Eigen::Index>(result.samples.size()), 3);
  for (std::size_t s = 0; s < result.samples.size(); ++s)
    points.row(static_cast<Eigen::Index>(s)) = result.samples[s].point;
  result.nearest = TriangleTree(positions, triangles).closest(points);
  return result;
}

}  // namespace batten
