#include <algorithm>

#include "batten/core/parallel.hpp"
#include "batten/fairing/neighbours_detail.hpp"

namespace batten::fairing_detail {

IndexLists triangles_of_vertices(const Triangles& triangles, Eigen::Index n_vertices) {
  IndexLists lists;
  lists.offsets.assign(static_cast<std::size_t>(n_vertices) + 1, 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++lists.offsets[static_cast<std::size_t>(triangles(f, k)) + 1];
  for (std::size_t v = 1; v < lists.offsets.size(); ++v) lists.offsets[v] += lists.offsets[v - 1];
  lists.indices.resize(3 * static_cast<std::size_t>(triangles.rows()));
  std::vector<int> fill(lists.offsets.begin(), lists.offsets.end() - 1);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) lists.indices[fill[triangles(f, k)]++] = static_cast<int>(f);
  return lists;
}

namespace {

/// Lists that were found in chunks, one after the other.
struct Chunk {
  std::vector<int> sizes, indices;
};

IndexLists joined(const std::vector<Chunk>& chunks, Eigen::Index rows) {
  IndexLists lists;
  lists.offsets.reserve(static_cast<std::size_t>(rows) + 1);
  std::size_t total = 0;
  for (const Chunk& chunk : chunks) total += chunk.indices.size();
  lists.indices.reserve(total);
  for (const Chunk& chunk : chunks) {
    for (const int size : chunk.sizes) lists.offsets.push_back(lists.offsets.back() + size);
    lists.indices.insert(lists.indices.end(), chunk.indices.begin(), chunk.indices.end());
  }
  return lists;
}

}  // namespace

IndexLists vertex_neighbours(const Triangles& triangles, Eigen::Index n_vertices) {
  constexpr Eigen::Index kGrain = 4096;
  const IndexLists around = triangles_of_vertices(triangles, n_vertices);
  std::vector<Chunk> chunks(static_cast<std::size_t>((n_vertices + kGrain - 1) / kGrain));
  parallel_for(n_vertices, kGrain, [&](Eigen::Index begin, Eigen::Index end) {
    Chunk& chunk = chunks[static_cast<std::size_t>(begin / kGrain)];
    std::vector<int> row;
    for (Eigen::Index v = begin; v < end; ++v) {
      row.clear();
      for (int i = around.begin(v); i < around.end(v); ++i)
        for (int k = 0; k < 3; ++k)
          if (const int u = triangles(around.indices[i], k); u != v) row.push_back(u);
      std::sort(row.begin(), row.end());
      row.erase(std::unique(row.begin(), row.end()), row.end());
      chunk.sizes.push_back(static_cast<int>(row.size()));
      chunk.indices.insert(chunk.indices.end(), row.begin(), row.end());
    }
  });
  return joined(chunks, n_vertices);
}

Eigen::VectorXd bi_umbrella_gains(const IndexLists& neighbours) {
  const Eigen::Index n = static_cast<Eigen::Index>(neighbours.offsets.size()) - 1;
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(n);
  // Each chunk has an array of its own: a bounded number of chunks.
  parallel_for(n, std::max<Eigen::Index>(4096, n / 32 + 1), [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<double> row(static_cast<std::size_t>(n), 0.0);
    std::vector<int> touched;
    const auto add = [&](int column, double value) {
      if (row[column] == 0) touched.push_back(column);
      row[column] += value;
    };
    for (Eigen::Index v = begin; v < end; ++v) {
      if (neighbours.size(v) == 0) continue;
      const double share = 1.0 / neighbours.size(v);
      add(static_cast<int>(v), 1);
      for (int i = neighbours.begin(v); i < neighbours.end(v); ++i) {
        const int u = neighbours.indices[i];
        add(u, -2 * share);
        for (int j = neighbours.begin(u); j < neighbours.end(u); ++j)
          add(neighbours.indices[j], share / neighbours.size(u));
      }
      for (const int column : touched) {
        gains[v] += row[column] * row[column];
        row[column] = 0;
      }
      touched.clear();
    }
  });
  return gains;
}

IndexLists triangle_balls(const Points& centroids, const Triangles& triangles,
                          const IndexLists& around_vertex, double radius, int most,
                          const Progress& progress) {
  const Eigen::Index m = triangles.rows();
  const double squared_radius = radius * radius;
  // Each chunk marks triangles in an array of its own: a bounded number of chunks.
  const Eigen::Index grain = std::max<Eigen::Index>(4096, m / 32 + 1);
  std::vector<Chunk> chunks(static_cast<std::size_t>((m + grain - 1) / grain));
  const auto find = [&](Eigen::Index begin, Eigen::Index end) {
    Chunk& chunk = chunks[static_cast<std::size_t>(begin / grain)];
    std::vector<int> seen(static_cast<std::size_t>(m), -1), ball;
    for (Eigen::Index f = begin; f < end; ++f) {
      ball.assign(1, static_cast<int>(f));
      seen[f] = static_cast<int>(f);
      for (std::size_t i = 0; i < ball.size() && static_cast<int>(ball.size()) < most; ++i) {
        const int g = ball[i];
        for (int k = 0; k < 3; ++k) {
          const int v = triangles(g, k);
          for (int j = around_vertex.begin(v); j < around_vertex.end(v); ++j) {
            const int h = around_vertex.indices[j];
            if (seen[h] == f) continue;
            if (g == f || (centroids.row(h) - centroids.row(f)).squaredNorm() < squared_radius) {
              seen[h] = static_cast<int>(f);
              ball.push_back(h);
            }
          }
        }
      }
      chunk.sizes.push_back(static_cast<int>(ball.size()));
      chunk.indices.insert(chunk.indices.end(), ball.begin(), ball.end());
    }
  };
  parallel_for(m, grain, find, progress);
  return joined(chunks, m);
}

Points triangle_centroids(const Points& positions, const Triangles& triangles) {
  Points centroids(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    centroids.row(f) =
        (positions.row(triangles(f, 0)) + positions.row(triangles(f, 1)) + positions.row(triangles(f, 2))) /
        3;
  return centroids;
}

double mean_centroid_distance(const Points& centroids, const std::vector<int>& opposite_half_edges) {
  double sum = 0;
  Eigen::Index count = 0;
  for (std::size_t h = 0; h < opposite_half_edges.size(); ++h)
    if (opposite_half_edges[h] >= 0) {
      sum += (centroids.row(static_cast<Eigen::Index>(h) / 3) - centroids.row(opposite_half_edges[h] / 3))
                 .norm();
      ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace batten::fairing_detail
