#include <array>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/bspline_pieces_detail.hpp"

namespace batten::detail {

namespace {

using Row = Eigen::RowVector3d;

Row next_on_edge(const BsplineSurface& surface, int edge, int vertex) {
  const BsplineEdge& along = surface.edges[at(edge)];
  const Eigen::Index n = along.curve.control_points.rows();
  return along.curve.control_points.row(along.vertices[0] == vertex ? 1 : n - 2);
}

/// The inner control point at an extraordinary corner, by least squares on samples of the limit surface.
void fit_corner(const IsolatedLimit& limit, BsplinePatch& patch, int k) {
  const Eigen::Index n_u = patch.n_u(), n_v = patch.n_v();
  const Eigen::Index inner = (k >= 2 ? n_v - 2 : 1) * n_u + (k == 1 || k == 2 ? n_u - 2 : 1);
  patch.control_points.row(inner).setZero();
  Row sum = Row::Zero();
  double squares = 0;
  constexpr int kSamples = 1 << kSampledHalvings;
  for (int j = 1; j < kSamples; j += 2)
    for (int i = 1; i < kSamples; i += 2) {
      const double x = static_cast<double>(i) / kSamples, y = static_cast<double>(j) / kSamples;
      const auto uv = limit.in_corner(k, x, y);
      const double weight = bernstein(1, x) * bernstein(1, y);
      sum += weight * (limit.exact(patch.face, uv[0], uv[1]) -
                       Row(evaluate(patch, uv[0], uv[1]).position.transpose()));
      squares += weight * weight;
    }
  patch.control_points.row(inner) = sum / squares;
}

}  // namespace

void build_patch(const IsolatedLimit& limit, BsplineSurface& surface, int f) {
  BsplinePatch& patch = surface.patches[at(f)];
  const std::array<bool, 4>& irregular = limit.irregular(f);
  patch.face = f;
  patch.is_exact = !irregular[0] && !irregular[1] && !irregular[2] && !irregular[3];
  for (int k = 0; k < 4; ++k) {
    patch.vertices[at(k)] = limit.cage().mesh.corners[at(limit.corner(f, k))];
    patch.edges[at(k)] = limit.topology().edge_of_corner[at(limit.corner(f, k))];
  }
  patch.knots_u = graded_knots(irregular[0] || irregular[3], irregular[1] || irregular[2], limit.isolation());
  patch.knots_v = graded_knots(irregular[0] || irregular[1], irregular[2] || irregular[3], limit.isolation());
  const Eigen::Index n_u = patch.n_u(), n_v = patch.n_v();
  patch.control_points.setConstant(n_u * n_v, 3, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index j = 0; j < n_v; ++j)
    for (Eigen::Index i = 0; i < n_u; ++i) {
      const ControlSite u = control_site(patch.knots_u, i), v = control_site(patch.knots_v, j);
      const LimitCell* cell = limit.cells().covering(f, u.inside, v.inside, limit.isolation());
      if (cell != nullptr)
        patch.control_points.row(j * n_u + i) = polar_form(*cell, u.arguments, v.arguments);
    }
  // The vertices and, where they were fitted, the points next to them are those of the edges.
  for (int k = 0; k < 4; ++k) {
    const bool right = k == 1 || k == 2, high = k >= 2;
    const auto index = [&](Eigen::Index i, Eigen::Index j) {
      return (high ? n_v - 1 - j : j) * n_u + (right ? n_u - 1 - i : i);
    };
    patch.control_points.row(index(0, 0)) = surface.vertices.row(patch.vertices[at(k)]);
    if (!irregular[at(k)]) continue;
    patch.control_points.row(index(1, 0)) =
        next_on_edge(surface, patch.edges[high ? 2 : 0], patch.vertices[at(k)]);
    patch.control_points.row(index(0, 1)) =
        next_on_edge(surface, patch.edges[right ? 1 : 3], patch.vertices[at(k)]);
    fit_corner(limit, patch, k);
  }
  if (!patch.control_points.allFinite())
    throw Error(concat("the limit surface over face ", f, " has an irregular place that is no corner of it; ",
                       "please report the cage"));
}

}  // namespace batten::detail
