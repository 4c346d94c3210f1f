#include "batten/remeshing/area_samples.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace batten {

namespace {

using Eigen::Vector3d;

/// Calls visit(sample) for every sample of triangle f.
template <typename Visit>
void visit_samples(const Points& positions, const Triangles& triangles, Eigen::Index f, double largest,
                   Visit&& visit) {
  const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                 c = positions.row(triangles(f, 2));
  const Vector3d cross = (b - a).cross(c - a);
  const double area = 0.5 * cross.norm();
  if (!(area > 0)) return;
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
        visit(sample);
      }
}

}  // namespace

std::vector<AreaSample> area_samples(const Points& positions, const Triangles& triangles, double largest) {
  std::vector<AreaSample> samples;
  samples.reserve(triangles.rows());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    visit_samples(positions, triangles, f, largest,
                  [&](const AreaSample& sample) { samples.push_back(sample); });
  return samples;
}

ReferenceSamples sample_reference(const Points& positions, const Triangles& triangles,
                                  const Points& reference_positions, const Triangles& reference_triangles,
                                  const Progress& progress) {
  progress.report("samples", 0);
  double area = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                   c = positions.row(triangles(f, 2));
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  const double largest = area / (4.0 * static_cast<double>(std::max<Eigen::Index>(1, triangles.rows())));
  ReferenceSamples result;
  // Counted first: a vector that grows holds up to three times what it needs.
  std::size_t count = 0;
  result.pieces.resize(static_cast<std::size_t>(reference_triangles.rows()));
  for (Eigen::Index f = 0; f < reference_triangles.rows(); ++f)
    visit_samples(reference_positions, reference_triangles, f, largest, [&](const AreaSample& sample) {
      result.pieces[f] = {sample.normal, sample.area};
      ++count;
    });
  result.points.reserve(count);
  progress.report("samples", 0.1);
  for (Eigen::Index f = 0; f < reference_triangles.rows(); ++f)
    visit_samples(reference_positions, reference_triangles, f, largest, [&](const AreaSample& sample) {
      result.points.push_back({sample.point, sample.triangle});
    });
  progress.report("samples", 0.2);
  const TriangleTree tree(positions, triangles);
  result.nearest.resize(count);
  // Piece by piece: what a search gives for each point is more than is kept of it.
  constexpr std::size_t kPiece = 1 << 18;
  Points points;
  for (std::size_t begin = 0; begin < count; begin += kPiece) {
    const std::size_t end = std::min(count, begin + kPiece);
    const double all = static_cast<double>(count);
    points.resize(static_cast<Eigen::Index>(end - begin), 3);
    for (std::size_t s = begin; s < end; ++s)
      points.row(static_cast<Eigen::Index>(s - begin)) = result.points[s].point;
    const std::vector<ClosestPoint> nearest =
        tree.closest(points, progress.part("samples", 0.3 + 0.7 * static_cast<double>(begin) / all,
                                           0.3 + 0.7 * static_cast<double>(end) / all));
    for (std::size_t s = begin; s < end; ++s)
      result.nearest[s] = static_cast<int>(nearest[s - begin].element);
  }
  return result;
}

}  // namespace batten
