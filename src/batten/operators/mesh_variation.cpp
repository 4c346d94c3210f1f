#include "batten/operators/mesh_variation.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

double ratio(double numerator, double denominator) {
  return denominator > 0 ? numerator / denominator : std::numeric_limits<double>::quiet_NaN();
}

std::vector<int> listed(const std::vector<char>& chosen) {
  std::vector<int> rows;
  for (std::size_t v = 0; v < chosen.size(); ++v)
    if (chosen[v] != 0) rows.push_back(static_cast<int>(v));
  return rows;
}

Eigen::VectorXd rows_of(const Eigen::VectorXd& values, const std::vector<int>& rows) {
  Eigen::VectorXd chosen(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) chosen[static_cast<Eigen::Index>(i)] = values[rows[i]];
  return chosen;
}

double variance(const Eigen::VectorXd& values) {
  return values.size() == 0 ? 0 : (values.array() - values.mean()).square().mean();
}

std::vector<char> used_by(const Triangles& triangles, Eigen::Index n_vertices) {
  std::vector<char> used(n_vertices, 0);
  for (Eigen::Index i = 0; i < triangles.size(); ++i) used[triangles.data()[i]] = 1;
  return used;
}

/// A mesh with what is compared of it.
struct Measured {
  Measured(const Points& mesh_positions, const Triangles& triangles) : positions(mesh_positions) {
    if (triangles.rows() == 0) throw InvalidInput("the mesh has no faces, so it has no curvature to compare");
    const Curvatures curvatures = discrete_curvatures(mesh_positions, triangles);
    H = curvatures.mean;
    edge_variance = edge_length_variances(mesh_positions, triangles);
    std::vector<char> used = used_by(triangles, mesh_positions.rows());
    all = listed(used);
    for (std::size_t v = 0; v < used.size(); ++v)
      if (curvatures.on_border[v] != 0) used[v] = 0;
    inner = listed(used);
  }
  const Points& positions;
  Eigen::VectorXd H, edge_variance;
  std::vector<int> all, inner;  ///< vertices of faces, and those of them that are not on a border
};

/// ‖b(nearest) − a‖ / ‖a‖ over the chosen vertices of a.
double matched_change(const Measured& a, const Eigen::VectorXd& of_a, const std::vector<int>& rows_a,
                      const Measured& b, const Eigen::VectorXd& of_b, const std::vector<int>& rows_b) {
  if (rows_a.empty() || rows_b.empty()) return std::numeric_limits<double>::quiet_NaN();
  // The nearest of points: of segments without length.
  Segments points(static_cast<Eigen::Index>(rows_b.size()), 2);
  for (std::size_t i = 0; i < rows_b.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)).setConstant(rows_b[i]);
  Points queries(static_cast<Eigen::Index>(rows_a.size()), 3);
  for (std::size_t i = 0; i < rows_a.size(); ++i)
    queries.row(static_cast<Eigen::Index>(i)) = a.positions.row(rows_a[i]);
  const std::vector<ClosestPoint> nearest = SegmentTree(b.positions, points).closest(queries);
  Eigen::VectorXd matched(queries.rows());
  for (Eigen::Index i = 0; i < matched.size(); ++i) matched[i] = of_b[rows_b[nearest[i].element]];
  const Eigen::VectorXd reference = rows_of(of_a, rows_a);
  return ratio((matched - reference).norm(), reference.norm());
}

}  // namespace

Eigen::VectorXd edge_length_variances(const Points& positions, const Triangles& triangles) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(positions.rows()), squares = sum, count = sum;
  const auto ends = [&](Eigen::Index e) { return edges.vertices.row(e); };
  const auto length = [&](Eigen::Index e) {
    return (positions.row(ends(e)[0]) - positions.row(ends(e)[1])).norm();
  };
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    for (const int v : {ends(e)[0], ends(e)[1]}) {
      sum[v] += length(e);
      count[v] += 1;
    }
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    for (const int v : {ends(e)[0], ends(e)[1]}) squares[v] += std::pow(length(e) - sum[v] / count[v], 2);
  return (count.array() > 0).select(squares.array() / count.array().max(1), 0).matrix();
}

double area_variance(const Points& positions, const Triangles& triangles) {
  const Eigen::VectorXd areas =
      rows_of(lumped_mass(positions, triangles), listed(used_by(triangles, positions.rows())));
  if (areas.size() == 0 || !(areas.mean() > 0)) return 0;
  return variance(areas) / (areas.mean() * areas.mean());
}

MeshVariation mesh_variation(const Points& original_positions, const Triangles& original_triangles,
                             const Points& positions, const Triangles& triangles) {
  const Measured before(original_positions, original_triangles), after(positions, triangles);
  MeshVariation result;
  result.mean_curvature = matched_change(before, before.H, before.inner, after, after.H, after.inner);
  result.edge_variance =
      matched_change(before, before.edge_variance, before.all, after, after.edge_variance, after.all);
  const double a0 = area_variance(original_positions, original_triangles);
  result.area_variance = ratio(std::abs(area_variance(positions, triangles) - a0), a0);
  const double h0 = variance(rows_of(before.H, before.inner));
  result.curvature_variance = ratio(std::abs(variance(rows_of(after.H, after.inner)) - h0), h0);
  return result;
}

}  // namespace batten
