#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/modelling/spline_controls_detail.hpp"

namespace batten::detail {

CubicBasis spline_basis(double t, int spans) {
  CubicBasis basis = cubic_basis(t * spans, spans, false);
  for (double& slope : basis.slopes) slope *= spans;
  return basis;
}

std::vector<double> clamped_knots(int spans) {
  std::vector<double> knots(3, 0.0);
  for (int k = 0; k <= spans; ++k) knots.push_back(static_cast<double>(k) / spans);
  knots.insert(knots.end(), 3, 1.0);
  return knots;
}

SplineControls::SplineControls(QuadLayout layout) : layout_(std::move(layout)) {
  DisjointSets classes(static_cast<int>(layout_.edges.size()));
  for (const LayoutQuad& quad : layout_.quads)
    for (int k = 0; k < 2; ++k) classes.unite(quad.edges[at(k)], quad.edges[at(k + 2)]);
  for (int e = 0; e < classes.size(); ++e) class_.push_back(classes.root(e));
  spans_.assign(class_.size(), 1);
}

int SplineControls::spans_of_edge(int edge) const {
  return spans_[at(class_[at(edge)])];
}

void SplineControls::number_controls() {
  int n = layout_.n_corners;
  first_of_edge_.clear();
  for (std::size_t e = 0; e < layout_.edges.size(); ++e) {
    first_of_edge_.push_back(n);
    n += spans_of_edge(static_cast<int>(e)) + 1;
  }
  first_of_quad_.clear();
  for (const LayoutQuad& quad : layout_.quads) {
    first_of_quad_.push_back(n);
    n += (spans_u(quad) + 1) * (spans_v(quad) + 1);
  }
  controls_ = Points::Zero(n, 3);
}

int SplineControls::control_of_edge(int edge, int i) const {
  const LayoutEdge& ends = layout_.edges[at(edge)];
  if (i == 0) return ends.corners[0];
  if (i == spans_of_edge(edge) + 2) return ends.corners[1];
  return first_of_edge_[at(edge)] + i - 1;
}

int SplineControls::on_side(const LayoutQuad& quad, int k, int i) const {
  const int e = quad.edges[at(k)], n = spans_of_edge(e) + 3;
  if (i == 0) return quad.corners[at(k)];
  if (i == n - 1) return quad.corners[at((k + 1) % 4)];
  return first_of_edge_[at(e)] + (runs_along(quad, k) ? i : n - 1 - i) - 1;
}
bool SplineControls::runs_along(const LayoutQuad& quad, int k) const {
  const LayoutEdge& edge = layout_.edges[at(quad.edges[at(k)])];
  return edge.corners[0] == quad.corners[at(k)] && edge.corners[1] == quad.corners[at((k + 1) % 4)];
}

int SplineControls::control(std::size_t q, int i, int j) const {
  const LayoutQuad& quad = layout_.quads[q];
  const int nu = spans_u(quad) + 3, nv = spans_v(quad) + 3;
  if (j == 0) return on_side(quad, 0, i);
  if (i == nu - 1) return on_side(quad, 1, j);
  if (j == nv - 1) return on_side(quad, 2, nu - 1 - i);
  if (i == 0) return on_side(quad, 3, nv - 1 - j);
  return first_of_quad_[q] + (j - 1) * (nu - 2) + i - 1;
}

PatchPoint SplineControls::evaluate_at(std::size_t q, double u, double v) const {
  const LayoutQuad& quad = layout_.quads[q];
  const CubicBasis a = spline_basis(u, spans_u(quad)), b = spline_basis(v, spans_v(quad));
  PatchPoint point{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d c = controls_.row(control(q, a.first + i, b.first + j)).transpose();
      point.position += a.values[at(i)] * b.values[at(j)] * c;
      point.along_u += a.slopes[at(i)] * b.values[at(j)] * c;
      point.along_v += a.values[at(i)] * b.slopes[at(j)] * c;
    }
  return point;
}

Eigen::Vector3d SplineControls::normal_at(std::size_t q, int k, double t) const {
  const auto [u, v] = on_patch_side(k, t);
  const PatchPoint point = evaluate_at(q, u, v);
  return point.along_u.cross(point.along_v).normalized();
}

double SplineControls::jump_at(std::size_t e) const {
  const LayoutEdge& edge = layout_.edges[e];
  if (edge.quads[1] < 0 || edge.is_sharp) return 0;
  const int n = 16 * spans_of_edge(static_cast<int>(e));
  double largest = 0;
  for (int s = 0; s <= n; ++s) {
    const double t = static_cast<double>(s) / n;
    std::array<Eigen::Vector3d, 2> normals;
    for (int k = 0; k < 2; ++k) {
      const bool along = runs_along(layout_.quads[at(edge.quads[at(k)])], edge.sides[at(k)]);
      normals[at(k)] = normal_at(at(edge.quads[at(k)]), edge.sides[at(k)], along ? t : 1 - t);
    }
    largest = std::max(largest, std::atan2(normals[0].cross(normals[1]).norm(), normals[0].dot(normals[1])));
  }
  return largest;
}

}  // namespace batten::detail
