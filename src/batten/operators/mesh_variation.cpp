#include "batten/operators/mesh_variation.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"
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
  Measured(const Points& mesh_positions, const Triangles& triangles, const std::vector<char>& left_out)
      : positions(mesh_positions) {
    const Eigen::Index n = mesh_positions.rows();
    if (triangles.rows() == 0) throw InvalidInput("the mesh has no faces, so it has no curvature to compare");
    const Curvatures curvatures = discrete_curvatures(mesh_positions, triangles);
    H = curvatures.mean;
    edge_variance = edge_length_variances(mesh_positions, triangles);
    counts = used_by(triangles, n);
    vertices = listed(counts);
    for (std::size_t v = 0; v < counts.size(); ++v)
      if (curvatures.on_border[v] != 0 || (!left_out.empty() && left_out[v] != 0)) counts[v] = 0;
  }
  const Points& positions;
  Eigen::VectorXd H, edge_variance;
  std::vector<int> vertices;  ///< of faces
  std::vector<char> counts;   ///< 1 for those of them whose curvature counts
};

/// Vertices of the original with the nearest of the other mesh.
struct Matches {
  std::vector<int> original, nearest;
};

Matches matches(const Measured& original, const Measured& other, const Progress& progress) {
  // The nearest of points: of segments without length.
  Segments points(static_cast<Eigen::Index>(other.vertices.size()), 2);
  for (std::size_t i = 0; i < other.vertices.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)).setConstant(other.vertices[i]);
  Points queries(static_cast<Eigen::Index>(original.vertices.size()), 3);
  for (std::size_t i = 0; i < original.vertices.size(); ++i)
    queries.row(static_cast<Eigen::Index>(i)) = original.positions.row(original.vertices[i]);
  Matches result{original.vertices, {}};
  for (const ClosestPoint& closest : SegmentTree(other.positions, points).closest(queries, progress))
    result.nearest.push_back(other.vertices[closest.element]);
  return result;
}

double mean_edge(const Points& positions, const Triangles& triangles) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  double sum = 0;
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e)
    sum += (positions.row(edges.vertices(e, 0)) - positions.row(edges.vertices(e, 1))).norm();
  return sum / static_cast<double>(edges.n_edges());
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

std::optional<std::string> MeshVariationOptions::problem(Eigen::Index n_original,
                                                         Eigen::Index n_vertices) const {
  const auto misfit = [](const char* name, const std::vector<char>& list, Eigen::Index n) {
    return list.empty() || list.size() == static_cast<std::size_t>(n)
               ? std::nullopt
               : std::optional(concat(name, " must have an entry per vertex or none, got ", list.size(),
                                      " entries for ", n, " vertices"));
  };
  if (auto wrong = misfit("original_left_out", original_left_out, n_original)) return wrong;
  return misfit("left_out", left_out, n_vertices);
}

MeshVariation mesh_variation(const Points& original_positions, const Triangles& original_triangles,
                             const Points& positions, const Triangles& triangles,
                             const MeshVariationOptions& options, const Progress& progress) {
  if (const auto problem = options.problem(original_positions.rows(), positions.rows()))
    throw InvalidInput(*problem);
  progress.report("variation", 0);
  Measured before(original_positions, original_triangles, options.original_left_out);
  progress.report("variation", 0.3);
  Measured after(positions, triangles, options.left_out);
  progress.report("variation", 0.6);
  if (options.relative_edges) {
    const double mean_before = mean_edge(original_positions, original_triangles),
                 mean_after = mean_edge(positions, triangles);
    if (mean_before > 0) before.edge_variance /= mean_before * mean_before;
    if (mean_after > 0) after.edge_variance /= mean_after * mean_after;
  }
  double change = 0, size = 0, edge_change = 0, edge_size = 0;
  const Matches pairs = matches(before, after, progress.part("variation", 0.7, 1));
  for (std::size_t i = 0; i < pairs.original.size(); ++i) {
    const int v = pairs.original[i], u = pairs.nearest[i];
    edge_change += std::pow(after.edge_variance[u] - before.edge_variance[v], 2);
    edge_size += std::pow(before.edge_variance[v], 2);
    if (before.counts[v] == 0 || after.counts[u] == 0) continue;
    change += std::pow(after.H[u] - before.H[v], 2);
    size += std::pow(before.H[v], 2);
  }
  MeshVariation result;
  result.edge_variance = ratio(std::sqrt(edge_change), std::sqrt(edge_size));
  const double a0 = area_variance(original_positions, original_triangles);
  result.area_variance = ratio(std::abs(area_variance(positions, triangles) - a0), a0);

  // Curvature below this is rounding: that of a flat surface, and its variance on a sphere.
  const double flat = 1e-9 / bounding_box_diagonal(original_positions);
  const auto n = static_cast<double>(pairs.original.size());
  result.mean_curvature =
      std::sqrt(size / n) > flat ? std::sqrt(change / size) : std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd H0 = rows_of(before.H, listed(before.counts));
  const double spread = variance(H0);
  const double rounding = H0.size() == 0 ? 0 : flat * flat + 1e-18 * H0.squaredNorm() / H0.size();
  result.curvature_variance = ratio(std::abs(variance(rows_of(after.H, listed(after.counts))) - spread),
                                    spread > rounding ? spread : 0);
  return result;
}

std::vector<char> vertices_on_creases(const Points& positions, const Triangles& triangles, double angle) {
  const MeshEdges edges = mesh_edges(triangles, positions.rows());
  const auto area_normal = [&](Eigen::Index f) -> Eigen::Vector3d {
    const Eigen::Vector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                          c = positions.row(triangles(f, 2));
    return (b - a).cross(c - a);
  };
  std::vector<char> result(positions.rows(), 0);
  for (Eigen::Index e = 0; e < edges.n_edges(); ++e) {
    if (edges.n_triangles(e) != 2) continue;
    const Eigen::Vector3d m = area_normal(edges.sides[edges.offsets[e]] / 3),
                          n = area_normal(edges.sides[edges.offsets[e] + 1] / 3);
    if (std::atan2(m.cross(n).norm(), m.dot(n)) > angle)
      for (const int v : {edges.vertices(e, 0), edges.vertices(e, 1)}) result[v] = 1;
  }
  return result;
}

}  // namespace batten
