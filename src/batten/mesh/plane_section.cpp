#include "batten/mesh/plane_section.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {

namespace {

/// Where the plane goes through a triangle, as two of its edges: in by the one that leads down, out by the
/// one that leads up, which is the way down of the triangle beyond.
struct Crossing {
  int in = -1, out = -1;
};

SectionCurve curve_through(const std::vector<Eigen::RowVector3d>& places, bool closed,
                           const Eigen::Vector3d& unit) {
  SectionCurve curve;
  curve.closed = closed;
  std::vector<Eigen::RowVector3d> kept;  // around a vertex in the plane one place comes several times
  for (const Eigen::RowVector3d& place : places)
    if (kept.empty() || place != kept.back()) kept.push_back(place);
  while (closed && kept.size() > 1 && kept.front() == kept.back()) kept.pop_back();
  curve.points.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) curve.points.row(static_cast<Eigen::Index>(i)) = kept[i];
  const std::size_t n_pieces = kept.size() - (closed || kept.empty() ? 0 : 1);
  for (std::size_t i = 0; i < n_pieces; ++i) {
    const Eigen::Vector3d a = kept[i] - kept[0], b = kept[(i + 1) % kept.size()] - kept[0];
    curve.length += (b - a).norm();
    if (closed) curve.area += a.cross(b).dot(unit) / 2;
  }
  return curve;
}

}  // namespace

std::vector<SectionCurve> plane_section(const Points& positions, const Triangles& triangles,
                                        const Eigen::Vector3d& normal, double offset) {
  const double size = normal.norm();
  if (!(size > 0) || !std::isfinite(size)) throw InvalidInput("the normal of a section must not be zero");
  if (!std::isfinite(offset)) throw InvalidInput("the offset of a section must be a finite number");
  const Eigen::VectorXd height = (positions * normal).array() - offset;
  const auto is_above = [&](int v) { return height[v] >= 0; };
  const MeshEdges edges = mesh_edges(triangles, positions.rows());

  std::vector<Crossing> crossings;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    Crossing crossing;
    for (int k = 0; k < 3; ++k) {
      const bool from = is_above(triangles(f, k)), to = is_above(triangles(f, (k + 1) % 3));
      if (from && !to) crossing.in = edges.of_triangle(f, k);
      if (!from && to) crossing.out = edges.of_triangle(f, k);
    }
    if (crossing.in >= 0) crossings.push_back(crossing);
  }
  // Which crossing begins at an edge, and whether one ends there.
  std::vector<int> beginning(at(edges.n_edges()), -1);
  std::vector<char> has_end(at(edges.n_edges()), 0), is_done(crossings.size(), 0);
  for (std::size_t c = 0; c < crossings.size(); ++c) {
    beginning[at(crossings[c].in)] = static_cast<int>(c);
    has_end[at(crossings[c].out)] = 1;
  }
  const auto place = [&](int edge) -> Eigen::RowVector3d {
    const int a = edges.vertices(edge, 0), b = edges.vertices(edge, 1);
    const double t = height[a] / (height[a] - height[b]);
    return positions.row(a) + t * (positions.row(b) - positions.row(a));
  };
  std::vector<SectionCurve> curves;
  const auto follow = [&](std::size_t first) {
    std::vector<Eigen::RowVector3d> places{place(crossings[first].in)};
    std::size_t c = first;
    bool closed = false;
    for (;;) {
      is_done[c] = 1;
      places.push_back(place(crossings[c].out));
      const int next = beginning[at(crossings[c].out)];
      closed = next >= 0 && static_cast<std::size_t>(next) == first;
      if (next < 0 || is_done[at(next)]) break;
      c = at(next);
    }
    SectionCurve curve = curve_through(places, closed, normal / size);
    if (curve.points.rows() > (closed ? 2 : 1)) curves.push_back(std::move(curve));
  };
  for (std::size_t c = 0; c < crossings.size(); ++c)  // open ones from where they begin
    if (!is_done[c] && !has_end[at(crossings[c].in)]) follow(c);
  for (std::size_t c = 0; c < crossings.size(); ++c)
    if (!is_done[c]) follow(c);
  std::stable_sort(curves.begin(), curves.end(),
                   [](const SectionCurve& a, const SectionCurve& b) { return a.length > b.length; });
  return curves;
}

}  // namespace batten
