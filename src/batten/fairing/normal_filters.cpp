#include "batten/fairing/normal_filters.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/neighbours_detail.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {

namespace {

using Eigen::RowVector3d;
using Eigen::VectorXd;
using fairing_detail::IndexLists;

/// One pass: normals averaged with weights from distance and from the difference of the guide.
Points filtered(const Points& normals, const Points& guide, const Points& centroids, const VectorXd& areas,
                const IndexLists& neighbours, double spatial, double range) {
  Points result(normals.rows(), 3);
  const double s = 1 / (2 * spatial * spatial), r = 1 / (2 * range * range);
  for (Eigen::Index f = 0; f < normals.rows(); ++f) {
    RowVector3d sum = RowVector3d::Zero();
    for (int i = neighbours.begin(f); i < neighbours.end(f); ++i) {
      const int g = neighbours.indices[i];
      sum += areas[g] *
             std::exp(-s * (centroids.row(g) - centroids.row(f)).squaredNorm() -
                      r * (guide.row(g) - guide.row(f)).squaredNorm()) *
             normals.row(g);
    }
    const double length = sum.norm();
    result.row(f) = length > 0 ? RowVector3d(sum / length) : RowVector3d(normals.row(f));
  }
  return result;
}

/// The mean normal of the most consistent patch among those around the corners of each triangle: small
/// spread of normals, and that spread concentrated on few edges.
class PatchGuide {
 public:
  PatchGuide(const Triangles& triangles, const std::vector<int>& opposite, const IndexLists& around)
      : triangles_(triangles), opposite_(opposite), around_(around) {}

  Points guide(const Points& normals, const VectorXd& areas) const {
    const Eigen::Index n = static_cast<Eigen::Index>(around_.offsets.size()) - 1;
    VectorXd inconsistency(n);
    Points means(n, 3);
    for (Eigen::Index v = 0; v < n; ++v) measure(v, normals, areas, inconsistency[v], means);
    Points result = normals;
    for (Eigen::Index f = 0; f < triangles_.rows(); ++f) {
      int best = triangles_(f, 0);
      for (int k = 1; k < 3; ++k)
        if (inconsistency[triangles_(f, k)] < inconsistency[best]) best = triangles_(f, k);
      if (means.row(best).squaredNorm() > 0) result.row(f) = means.row(best);
    }
    return result;
  }

 private:
  void measure(Eigen::Index v, const Points& normals, const VectorXd& areas, double& inconsistency,
               Points& means) const {
    double spread = 0, largest = 0, total = 0;
    RowVector3d mean = RowVector3d::Zero();
    for (int i = around_.begin(v); i < around_.end(v); ++i) {
      const int f = around_.indices[i];
      mean += areas[f] * normals.row(f);
      for (int j = around_.begin(v); j < i; ++j)
        spread = std::max(spread, (normals.row(f) - normals.row(around_.indices[j])).norm());
      for (int k = 0; k < 3; ++k) {  // the edges of the patch's inside, those at v
        const int other = opposite_[3 * static_cast<std::size_t>(f) + static_cast<std::size_t>(k)];
        if (other < 0 || triangles_(f, k) == v || other / 3 < f) continue;
        const double jump = (normals.row(f) - normals.row(other / 3)).norm();
        largest = std::max(largest, jump);
        total += jump;
      }
    }
    inconsistency = spread * (1e-9 + largest / (1e-9 + total));
    const double length = mean.norm();
    means.row(v) = length > 0 ? RowVector3d(mean / length) : RowVector3d::Zero();
  }

  const Triangles& triangles_;
  const std::vector<int>& opposite_;
  const IndexLists& around_;
};

Points filter_loop(const Points& positions, const Triangles& triangles, const NormalFilterOptions& options,
                   bool guided, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  fairing_detail::fixed_vertices(positions, triangles, false);
  const std::vector<int> opposite = opposite_half_edges(triangles);
  const IndexLists around = fairing_detail::triangles_of_vertices(triangles, positions.rows());
  const Points centroids = fairing_detail::triangle_centroids(positions, triangles);
  const double distance = std::max(fairing_detail::mean_centroid_distance(centroids, opposite), 1e-300);
  const VectorXd areas = face_areas(positions, triangles);
  // The published guided filter reaches over balls of twice the mean distance, the bilateral one over the
  // triangles that touch.
  const IndexLists neighbours =
      fairing_detail::triangle_balls(centroids, triangles, around, guided ? 2 * distance : 0.0, 100);
  const PatchGuide patches(triangles, opposite, around);
  Points normals = face_normals(positions, triangles);
  for (int i = 0; i < options.iterations; ++i) {
    progress.report("filtering normals", static_cast<double>(i) / options.iterations);
    const Points guide = guided ? patches.guide(normals, areas) : normals;
    normals = filtered(normals, guide, centroids, areas, neighbours, distance, options.range);
  }
  return normals;
}

}  // namespace

std::optional<std::string> NormalFilterOptions::problem() const {
  if (!(range > 0)) return concat("range must be above 0, got ", range);
  if (iterations < 0) return concat("iterations must be at least 0, got ", iterations);
  if (vertex_iterations < 0) return concat("vertex_iterations must be at least 0, got ", vertex_iterations);
  return std::nullopt;
}

Points bilateral_normals(const Points& positions, const Triangles& triangles,
                         const NormalFilterOptions& options, const Progress& progress) {
  return filter_loop(positions, triangles, options, false, progress);
}

Points guided_normals(const Points& positions, const Triangles& triangles, const NormalFilterOptions& options,
                      const Progress& progress) {
  return filter_loop(positions, triangles, options, true, progress);
}

Points move_to_normals(const Points& positions, const Triangles& triangles, const Points& face_normals,
                       int iterations, bool keep_boundary) {
  if (face_normals.rows() != triangles.rows())
    throw InvalidInput(
        concat("one normal per triangle is needed: ", triangles.rows(), ", got ", face_normals.rows()));
  const std::vector<char> fixed = fairing_detail::fixed_vertices(positions, triangles, keep_boundary);
  const IndexLists around = fairing_detail::triangles_of_vertices(triangles, positions.rows());
  Points X = positions;
  for (int i = 0; i < iterations; ++i) {
    const Points centroids = fairing_detail::triangle_centroids(X, triangles);
    for (Eigen::Index v = 0; v < X.rows(); ++v) {
      if (fixed[v] || around.size(v) == 0) continue;
      RowVector3d move = RowVector3d::Zero();
      for (int j = around.begin(v); j < around.end(v); ++j) {
        const int f = around.indices[j];
        move += face_normals.row(f).dot(centroids.row(f) - X.row(v)) * face_normals.row(f);
      }
      X.row(v) += move / around.size(v);
    }
  }
  return X;
}

Points refit_to_normals(const Points& positions, const Triangles& triangles, const Points& face_normals,
                        double fidelity, bool keep_boundary, const Progress& progress) {
  if (face_normals.rows() != triangles.rows())
    throw InvalidInput(
        concat("one normal per triangle is needed: ", triangles.rows(), ", got ", face_normals.rows()));
  if (!(fidelity > 0)) throw InvalidInput(concat("fidelity must be above 0, got ", fidelity));
  const std::vector<char> fixed = fairing_detail::fixed_vertices(positions, triangles, keep_boundary);
  const Eigen::Index n = positions.rows();
  std::vector<int> first(static_cast<std::size_t>(n), -1);
  int unknowns = 0;
  for (Eigen::Index v = 0; v < n; ++v)
    if (!fixed[v]) {
      first[v] = unknowns;
      unknowns += 3;
    }
  if (unknowns == 0) return positions;
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(static_cast<std::size_t>(81 * triangles.rows() + unknowns));
  VectorXd right = VectorXd::Zero(unknowns);
  for (int i = 0; i < unknowns; ++i) triplets.emplace_back(i, i, fidelity);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Eigen::Vector3d normal = face_normals.row(f);
    RowVector3d p[3];
    for (int k = 0; k < 3; ++k) p[k] = positions.row(triangles(f, k));
    const double twice_area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      const double cotangent =
          twice_area > 0 ? std::clamp((p[a] - p[k]).dot(p[b] - p[k]) / twice_area, 0.1, 3.0) : 0.1;
      const Eigen::Matrix3d block = cotangent * normal * normal.transpose();
      // Moves u: (n · (p_a + u_a − p_b − u_b))².
      const Eigen::Vector3d pull = cotangent * normal.dot(p[a] - p[b]) * normal;
      const int ends[2] = {first[triangles(f, a)], first[triangles(f, b)]};
      for (int r = 0; r < 2; ++r) {
        if (ends[r] < 0) continue;
        right.segment<3>(ends[r]) -= (r == 0 ? 1 : -1) * pull;
        for (int c = 0; c < 2; ++c) {
          if (ends[c] < 0) continue;
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              triplets.emplace_back(ends[r] + i, ends[c] + j, (r == c ? 1 : -1) * block(i, j));
        }
      }
    }
  }
  SparseMatrix system(unknowns, unknowns);
  system.setFromTriplets(triplets.begin(), triplets.end());
  SparseCholesky solver("refit to normals");
  solver.factorize(system, progress);
  const VectorXd moves = solver.solve(right);
  Points X = positions;
  for (Eigen::Index v = 0; v < n; ++v)
    if (!fixed[v]) X.row(v) += moves.segment<3>(first[v]).transpose();
  return X;
}

}  // namespace batten
