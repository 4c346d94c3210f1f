#include <array>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/subdivision/bspline_pieces_detail.hpp"

namespace batten::detail {

namespace {

using Row = Eigen::RowVector3d;

/// Sets the control points of an edge that cells beside it give, and says which these are.
std::vector<char> set_known_points(const IsolatedLimit& limit, const IsolatedLimit::SideOf (&sides)[2],
                                   BsplineCurve& curve) {
  const Eigen::Index n = curve.control_points.rows();
  std::vector<char> known(static_cast<size_t>(n), 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ControlSite where = control_site(curve.knots, i);
    for (const IsolatedLimit::SideOf& side : sides) {
      if (side.face < 0 || known[static_cast<size_t>(i)] != 0) continue;
      PolarArguments t = where.arguments;
      double inside = where.inside;
      if (!side.forward) {
        for (double& x : t) x = 1 - x;
        inside = 1 - inside;
      }
      Row point;
      if (!limit.side_polar(side.face, side.side, t, inside, point)) continue;
      curve.control_points.row(i) = point;
      known[static_cast<size_t>(i)] = 1;
    }
  }
  return known;
}

/// The control point next to an extraordinary end: the curve nearest to samples of the limit curve among
/// those that continue it, in the tangent plane where there is one.
void fit_end(const IsolatedLimit& limit, BsplineEdge& edge, const IsolatedLimit::SideOf& side, int end) {
  const Eigen::Index n = edge.curve.control_points.rows();
  const auto point = [&](Eigen::Index i) {
    return Row(edge.curve.control_points.row(end == 0 ? i : n - 1 - i));
  };
  // In Bernstein form: the double knot ends the cell, and b3 divides b2 and the next point as the knots do.
  const std::vector<double>& knots = edge.curve.knots;
  const auto knot = [&](size_t i) { return end == 0 ? knots[i] : 1 - knots[knots.size() - 1 - i]; };
  const double side_length = knot(4), beyond = knot(6);
  const double w = side_length / beyond;
  const Row b0 = point(0), b2 = point(2), b3 = (1 - w) * point(2) + w * point(3);
  Row sum = Row::Zero();
  double squares = 0;
  constexpr int kSamples = 1 << kSampledHalvings;
  for (int k = 1; k < kSamples; ++k) {
    const double x = static_cast<double>(k) / kSamples;
    const double t = end == 0 ? x * side_length : 1 - x * side_length;
    const auto uv = on_patch_side(side.side, side.forward ? t : 1 - t);
    const Row rest = limit.exact(side.face, uv[0], uv[1]) - bernstein(0, x) * b0 - bernstein(2, x) * b2 -
                     bernstein(3, x) * b3;
    sum += bernstein(1, x) * rest;
    squares += bernstein(1, x) * bernstein(1, x);
  }
  Row b1 = sum / squares;
  const int v = edge.vertices[at(end)];
  if (limit.has_plane(v)) {
    const Row normal = limit.surface().vertex_normals.row(v);
    b1 -= (b1 - b0).dot(normal) * normal;
  }
  edge.curve.control_points.row(end == 0 ? 1 : n - 2) = b1;
}

}  // namespace

void build_edges(const IsolatedLimit& limit, BsplineSurface& surface) {
  const int n_edges = static_cast<int>(limit.topology().edges.size());
  surface.edges.resize(at(n_edges));
  for (int e = 0; e < n_edges; ++e) {
    BsplineEdge& edge = surface.edges[at(e)];
    edge.vertices = limit.topology().edges[at(e)];
    edge.is_sharp = limit.is_sharp(e);
    const IsolatedLimit::SideOf sides[2] = {limit.side_of(e, 0), limit.side_of(e, 1)};
    edge.patches = {sides[0].face, sides[1].face};
    bool irregular[2] = {false, false};
    for (const IsolatedLimit::SideOf& side : sides)
      for (int end = 0; end < 2; ++end)
        if (side.face >= 0 && limit.irregular_end(side, end)) irregular[end] = true;
    edge.curve.knots = graded_knots(irregular[0], irregular[1], limit.isolation());
    const Eigen::Index n = static_cast<Eigen::Index>(edge.curve.knots.size()) - 4;
    edge.curve.control_points.resize(n, 3);
    const std::vector<char> known = set_known_points(limit, sides, edge.curve);
    edge.curve.control_points.row(0) = surface.vertices.row(edge.vertices[0]);
    edge.curve.control_points.row(n - 1) = surface.vertices.row(edge.vertices[1]);
    for (int end = 0; end < 2; ++end)
      if (known[static_cast<size_t>(end == 0 ? 1 : n - 2)] == 0) fit_end(limit, edge, sides[0], end);
  }
}

}  // namespace batten::detail
