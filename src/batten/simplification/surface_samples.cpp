#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/simplification/surface_fit_detail.hpp"

namespace batten::simplification {

using Eigen::Vector3d;

std::vector<SurfaceSample> sample_surface(const Points& positions, const Triangles& triangles, int n) {
  std::vector<SurfaceSample> samples;
  const auto corner = [&](Eigen::Index f, int k) { return Vector3d(positions.row(triangles(f, k))); };
  const auto normal = [&](Eigen::Index f) {
    const Vector3d a = corner(f, 0);
    return Vector3d((corner(f, 1) - a).cross(corner(f, 2) - a));
  };
  double area = 0;
  std::vector<Vector3d> vertex_normal(positions.rows(), Vector3d::Zero());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d N = normal(f);
    area += 0.5 * N.norm();
    for (int k = 0; k < 3; ++k) vertex_normal[triangles(f, k)] += N.normalized();
  }
  if (!(area > 0)) return samples;
  const double share = area / n;
  // How far the normals around a vertex part from their mean: a cosine, low where the surface bends.
  struct Bend {
    float cosine = 1;
    int face = -1;
  };
  std::vector<Bend> bends(positions.rows());
  double carried = 0;  // area of small faces that no sample stands for yet
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d N = normal(f);
    const double face_area = 0.5 * N.norm();
    const Eigen::Vector3f unit = N.normalized().cast<float>();
    for (int k = 0; k < 3; ++k) {
      Bend& bend = bends[triangles(f, k)];
      const auto cosine = static_cast<float>(N.normalized().dot(vertex_normal[triangles(f, k)].normalized()));
      if (bend.face < 0 || cosine < bend.cosine) bend = {cosine, static_cast<int>(f)};
    }
    const Vector3d a = corner(f, 0), ab = corner(f, 1) - a, ac = corner(f, 2) - a;
    if (face_area < share) {
      carried += face_area;
      if (carried < share) continue;
      carried -= share;
      samples.push_back({a + (ab + ac) / 3, share, unit, static_cast<int>(f)});
      continue;
    }
    // m² equal parts, by the centres of the triangles of a regular subdivision.
    const int m = static_cast<int>(std::ceil(std::sqrt(face_area / share)));
    for (int i = 0; i < m; ++i)
      for (int j = 0; i + j < m; ++j) {
        samples.push_back({a + ((i + 1.0 / 3) * ab + (j + 1.0 / 3) * ac) / m, face_area / (m * m), unit,
                           static_cast<int>(f)});
        if (i + j + 1 < m)
          samples.push_back({a + ((i + 2.0 / 3) * ab + (j + 2.0 / 3) * ac) / m, face_area / (m * m), unit,
                             static_cast<int>(f)});
      }
  }
  std::vector<int> bent;
  for (std::size_t v = 0; v < bends.size(); ++v)
    if (bends[v].face >= 0 && bends[v].cosine < 0.985F) bent.push_back(static_cast<int>(v));
  const std::size_t most = samples.size() / 4 + 1;
  if (bent.size() > most) {
    std::nth_element(
        bent.begin(), bent.begin() + static_cast<std::ptrdiff_t>(most), bent.end(), [&](int u, int v) {
          return bends[u].cosine < bends[v].cosine || (bends[u].cosine == bends[v].cosine && u < v);
        });
    bent.resize(most);
    std::sort(bent.begin(), bent.end());
  }
  for (const int v : bent) {
    const int f = bends[v].face;
    samples.push_back({positions.row(v).transpose(), 1e-3 * share, normal(f).normalized().cast<float>(), f});
  }
  return samples;
}

}  // namespace batten::simplification
