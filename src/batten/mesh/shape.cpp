#include "batten/mesh/shape.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"

namespace batten {

using Eigen::Vector3d;

ShapeTree::ShapeTree(const Shape& shape) {
  if (shape.is_surface())
    triangles_.emplace(shape.positions, shape.triangles);
  else
    segments_.emplace(shape.positions, shape.segments);
}

ClosestPoint ShapeTree::closest(const Vector3d& query) const {
  return triangles_ ? triangles_->closest(query) : segments_->closest(query);
}

std::vector<ClosestPoint> ShapeTree::closest(const Points& queries, const Progress& progress) const {
  return triangles_ ? triangles_->closest(queries, progress) : segments_->closest(queries, progress);
}

std::vector<int> used_vertices(const Shape& shape) {
  std::vector<char> used(shape.positions.rows(), 0);
  if (shape.is_surface())
    for (Eigen::Index i = 0; i < shape.triangles.size(); ++i) used[shape.triangles.data()[i]] = 1;
  else
    for (Eigen::Index i = 0; i < shape.segments.size(); ++i) used[shape.segments.data()[i]] = 1;
  std::vector<int> vertices;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) vertices.push_back(static_cast<int>(v));
  return vertices;
}

Points sample_uniformly(const Shape& shape, Eigen::Index n, Random& random, std::vector<int>* elements) {
  const bool surface = shape.is_surface();
  const Eigen::Index m = surface ? shape.triangles.rows() : shape.segments.rows();
  const auto corner = [&](Eigen::Index e, int k) -> Vector3d {
    return shape.positions.row(surface ? shape.triangles(e, k) : shape.segments(e, k));
  };
  std::vector<double> sums(m);  // running sums of the areas or lengths
  double total = 0;
  for (Eigen::Index e = 0; e < m; ++e) {
    const Vector3d a = corner(e, 0), ab = corner(e, 1) - a;
    total += surface ? 0.5 * ab.cross(corner(e, 2) - a).norm() : ab.norm();
    sums[e] = total;
  }
  if (!(total > 0) || !std::isfinite(total))
    throw InvalidInput(surface
                           ? "the mesh has no area, so it cannot be sampled; check its positions"
                           : "the curves have no length, so they cannot be sampled; check their positions");
  Points samples(n, 3);
  if (elements != nullptr) elements->assign(n, 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double at = random.uniform() * total;
    const auto e =
        std::min<Eigen::Index>(std::upper_bound(sums.begin(), sums.end(), at) - sums.begin(), m - 1);
    if (elements != nullptr) (*elements)[i] = static_cast<int>(e);
    const Vector3d a = corner(e, 0), b = corner(e, 1);
    if (surface) {  // the square root makes the density even [osada2002]
      const double r = std::sqrt(random.uniform()), s = random.uniform();
      samples.row(i) = (1 - r) * a + r * (1 - s) * b + r * s * corner(e, 2);
    } else {
      samples.row(i) = a + random.uniform() * (b - a);
    }
  }
  return samples;
}

double diameter(const Shape& shape) {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  bool first = true;
  for (const int v : used_vertices(shape)) {
    const Vector3d p = shape.positions.row(v);
    low = first ? p : Vector3d(low.cwiseMin(p));
    high = first ? p : Vector3d(high.cwiseMax(p));
    first = false;
  }
  return (high - low).norm();
}

}  // namespace batten
