#include "batten/remeshing/surface_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Points on the reference whose normals differ from the nearest triangle's by more than 60° belong to the
/// other side of an edge: they say nothing of this triangle.
constexpr double kSameSide = 0.5;
constexpr std::size_t kSamplesPerReport = 1 << 16;  ///< some 20 ms

struct Corners {
  Vector3d a, b, c;
  Corners(const Points& X, const Triangles& T, Eigen::Index f)
      : a(X.row(T(f, 0))), b(X.row(T(f, 1))), c(X.row(T(f, 2))) {}
  Vector3d cross() const { return (b - a).cross(c - a); }
};

/// Adds the rows of the samples: to one block of every triangle, and to the right-hand side.
std::vector<Matrix3d> sample_blocks(const Points& positions, const Triangles& triangles,
                                    const Points& vertex_normals, const ReferenceSamples& reference,
                                    double slope_weight, Eigen::VectorXd& right, const Progress& progress) {
  std::vector<Matrix3d> block(triangles.rows(), Matrix3d::Zero());
  for (std::size_t s = 0; s < reference.points.size(); ++s) {
    if (s % kSamplesPerReport == 0)
      progress.report("fit", 0.5 * static_cast<double>(s) / static_cast<double>(reference.points.size()));
    const SamplePoint& point = reference.points[s];
    const SampledTriangle& sample = reference.pieces[point.triangle];
    const Eigen::Index f = reference.nearest[s];
    const Corners corners(positions, triangles, f);
    const ClosestPoint at = closest_point_on_triangle(point.point, corners.a, corners.b, corners.c);
    const Vector3d cross = corners.cross();
    const double doubled = cross.norm();
    if (!(doubled > 0)) continue;
    const Vector3d normal = cross / doubled;
    if (!(sample.normal.dot(normal) > kSameSide)) continue;
    // Distance: Σ w_k c_k t_k = (q − p)·n with c_k the cosine between the normals of vertex and triangle.
    Vector3d row;
    for (int k = 0; k < 3; ++k)
      row[k] = at.weights[k] * normal.dot(Vector3d(vertex_normals.row(triangles(f, k))));
    const double residual = normal.dot(point.point - at.point);
    block[f] += sample.area * row * row.transpose();
    // Slope: the normal turns by −∇t, which should be `turn`. Gradients of the hat functions are the opposite
    // edges, turned by a right angle, over twice the area.
    const Vector3d turn = sample.normal / sample.normal.dot(normal) - normal;
    const Vector3d gradients[3] = {normal.cross(corners.c - corners.b) / doubled,
                                   normal.cross(corners.a - corners.c) / doubled,
                                   normal.cross(corners.b - corners.a) / doubled};
    for (int k = 0; k < 3; ++k) {
      right[triangles(f, k)] += sample.area * (row[k] * residual - slope_weight * gradients[k].dot(turn));
      for (int l = 0; l < 3; ++l)
        block[f](k, l) += sample.area * slope_weight * gradients[k].dot(gradients[l]);
    }
  }
  return block;
}

/// Fixed vertices, and a little weight on staying where no sample fell.
void hold_vertices(SparseMatrix& A, Eigen::VectorXd& right, const std::vector<char>& fixed) {
  const double small = 1e-6 * A.diagonal().mean();
  for (Eigen::Index v = 0; v < A.cols(); ++v) {
    for (SparseMatrix::InnerIterator entry(A, v); entry; ++entry)
      if (entry.row() != v && (fixed[v] != 0 || fixed[entry.row()] != 0)) entry.valueRef() = 0;
    double& diagonal = A.coeffRef(v, v);
    diagonal += small;
    if (fixed[v] != 0) {
      diagonal = 1;
      right[v] = 0;
    }
  }
}

/// The shortest edge at every vertex; infinite where there is none.
Eigen::VectorXd shortest_edges(const Triangles& triangles, const EdgeLengths& lengths, Eigen::Index n) {
  Eigen::VectorXd shortest = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      double& value = shortest[triangles(f, k)];
      value = std::min({value, lengths(f, (k + 1) % 3), lengths(f, (k + 2) % 3)});
    }
  return shortest;
}

}  // namespace

std::optional<std::string> SurfaceFitOptions::problem() const {
  if (!(normals >= 0) || !std::isfinite(normals)) return concat("normals must be >= 0, got ", normals);
  if (!(most >= 0)) return concat("most must be >= 0, got ", most);
  return std::nullopt;
}

SurfaceFitResult fitted_to_surface(const Points& positions, const Triangles& triangles,
                                   const std::vector<char>& fixed, const ReferenceSamples& reference,
                                   const SurfaceFitOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const Eigen::Index n = positions.rows(), m = triangles.rows();
  const EdgeLengths lengths = edge_lengths(positions, triangles);
  const double slope_weight = options.normals * std::pow(lengths.mean(), 2);
  const Points vertex_normals = batten::vertex_normals(positions, triangles);
  SparseMatrix A = cotangent_stiffness(triangles, lengths, n);
  for (Eigen::Index i = 0; i < A.nonZeros(); ++i) A.valuePtr()[i] = 0;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const std::vector<Matrix3d> block =
      sample_blocks(positions, triangles, vertex_normals, reference, slope_weight, right, progress);
  progress.report("fit", 0.5);
  for (Eigen::Index f = 0; f < m; ++f)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l) A.coeffRef(triangles(f, k), triangles(f, l)) += block[f](k, l);
  progress.report("fit", 0.6);
  hold_vertices(A, right, fixed);
  IterativeOptions solver;
  solver.tolerance = 1e-4;
  solver.max_iterations = 200;
  solver.preconditioner = Preconditioner::Diagonal;
  SurfaceFitResult result{positions, {}};
  Eigen::MatrixXd solution;
  try {
    result.solve = solve_conjugate_gradients(A, right, solution, "fit to the surface", solver,
                                             progress.part("fit", 0.7, 1));
  } catch (const SolverFailure&) {
    result.solve.residual = 1;  // nothing of the right-hand side was met
    return result;
  }
  const Eigen::VectorXd t = solution;
  const Eigen::VectorXd shortest = shortest_edges(triangles, lengths, n);
  for (Eigen::Index v = 0; v < n; ++v)
    if (fixed[v] == 0 && std::isfinite(shortest[v])) {
      const double limit = options.most * shortest[v];
      result.positions.row(v) += std::clamp(t[v], -limit, limit) * vertex_normals.row(v);
    }
  return result;
}

}  // namespace batten
