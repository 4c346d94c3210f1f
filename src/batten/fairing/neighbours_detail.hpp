#pragma once
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten::fairing_detail {

/// Rows of indices, one after the other.
struct IndexLists {
  std::vector<int> offsets{0};
  std::vector<int> indices;

  int begin(Eigen::Index row) const { return offsets[static_cast<std::size_t>(row)]; }
  int end(Eigen::Index row) const { return offsets[static_cast<std::size_t>(row) + 1]; }
  int size(Eigen::Index row) const { return end(row) - begin(row); }
};

/// The vertices joined to each vertex by an edge, ascending.
IndexLists vertex_neighbours(const Triangles& triangles, Eigen::Index n_vertices);

/// How much (I − P)², P the mean of the neighbours, amplifies the variance of white noise at each vertex:
/// the squared length of its row; 0 at vertices without neighbours.
Eigen::VectorXd bi_umbrella_gains(const IndexLists& neighbours);

/// The triangles around each vertex, ascending.
IndexLists triangles_of_vertices(const Triangles& triangles, Eigen::Index n_vertices);

/// The triangles whose centroids lie within `radius` of that of each triangle, reached over triangles that
/// share a vertex; those that touch the triangle itself always belong. The triangle itself comes first. At
/// most `most` (nearest in the sense of that walk), so that time stays linear where triangles are tiny.
IndexLists triangle_balls(const Points& centroids, const Triangles& triangles,
                          const IndexLists& around_vertex, double radius, int most,
                          const Progress& progress = {});

/// Centroids of the triangles, m × 3.
Points triangle_centroids(const Points& positions, const Triangles& triangles);

/// Mean distance of the centroids of triangles that share an edge; 0 without such.
double mean_centroid_distance(const Points& centroids, const std::vector<int>& opposite_half_edges);

}  // namespace batten::fairing_detail
