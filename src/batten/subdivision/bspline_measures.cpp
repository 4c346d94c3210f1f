#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/subdivision/bspline_pieces_detail.hpp"

namespace batten::detail {

namespace {

/// The distance of a point of the limit surface from a patch, by Newton steps from its own parameters. The
/// patch is parametrised otherwise near the vertex, so that places of equal parameters say little.
double distance_from(const BsplinePatch& patch, double u, double v, const Eigen::Vector3d& point) {
  double best = (evaluate(patch, u, v).position - point).norm();
  for (int step = 0; step < 8; ++step) {
    const PatchPoint here = evaluate(patch, u, v);
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << here.along_u, here.along_v;
    const Eigen::Matrix2d normal = tangents.transpose() * tangents;
    if (!(normal.determinant() > 1e-14 * normal.squaredNorm())) break;
    const Eigen::Vector2d move = normal.inverse() * (tangents.transpose() * (point - here.position));
    u = std::clamp(u + move(0), 0.0, 1.0);
    v = std::clamp(v + move(1), 0.0, 1.0);
    best = std::min(best, (evaluate(patch, u, v).position - point).norm());
  }
  return best;
}

}  // namespace

void measure_deviation(const IsolatedLimit& limit, BsplineSurface& surface, int f) {
  constexpr int kSamples = 1 << kSampledHalvings;
  for (int k = 0; k < 4; ++k) {
    if (!limit.irregular(f)[at(k)]) continue;
    for (int j = 0; j <= kSamples; j += 2)
      for (int i = 0; i <= kSamples; i += 2) {
        if (i <= 1 && j <= 1) continue;  // not covered: the vertex itself, where both meet
        const auto uv =
            limit.in_corner(k, static_cast<double>(i) / kSamples, static_cast<double>(j) / kSamples);
        surface.deviation = std::max(
            surface.deviation,
            distance_from(surface.patches[at(f)], uv[0], uv[1], limit.exact(f, uv[0], uv[1]).transpose()));
      }
  }
}

void measure_normals(const IsolatedLimit& limit, BsplineSurface& surface) {
  for (int e = 0; e < static_cast<int>(limit.topology().edges.size()); ++e) {
    const IsolatedLimit::SideOf sides[2] = {limit.side_of(e, 0), limit.side_of(e, 1)};
    if (sides[1].face < 0 || limit.is_sharp(e)) continue;
    if (surface.patches[at(sides[0].face)].is_exact && surface.patches[at(sides[1].face)].is_exact) continue;
    for (int end = 0; end < 2; ++end) {
      if (!limit.has_plane(limit.topology().edges[at(e)][at(end)])) continue;  // a cone has no tangent plane
      for (int k = 1; k <= 16; ++k) {
        const double t = std::abs(end - limit.cell_side() * k / 16);
        Eigen::Vector3d normals[2];
        for (size_t s = 0; s < 2; ++s) {
          const auto uv = on_patch_side(sides[s].side, sides[s].forward ? t : 1 - t);
          const PatchPoint point = evaluate(surface.patches[at(sides[s].face)], uv[0], uv[1]);
          normals[s] = point.along_u.cross(point.along_v);
        }
        if (normals[0].norm() == 0 || normals[1].norm() == 0) continue;
        const double angle = std::atan2(normals[0].cross(normals[1]).norm(), normals[0].dot(normals[1]));
        surface.normal_jump = std::max(surface.normal_jump, angle);
      }
    }
  }
}

}  // namespace batten::detail
