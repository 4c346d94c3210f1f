#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"

namespace batten {

/// The edges of a triangle mesh and the triangles at each. Side k of a triangle runs from its corner k to its
/// corner (k + 1) mod 3. Built in linear time.
struct MeshEdges {
  /// e × 2 vertices, the lower index first; the rows are sorted.
  Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor> vertices;
  Triangles of_triangle;     ///< m × 3: the edge of each side of each triangle
  std::vector<int> offsets;  ///< e + 1: where the sides of each edge begin in `sides`
  std::vector<int> sides;    ///< 3 · triangle + k of every side, grouped by edge, increasing

  Eigen::Index n_edges() const { return vertices.rows(); }
  /// 1 on the border, 2 inside, more where the mesh is not manifold.
  int n_triangles(Eigen::Index edge) const {
    return offsets[static_cast<size_t>(edge) + 1] - offsets[static_cast<size_t>(edge)];
  }
};

/// @throws InvalidInput naming the first triangle with an index outside 0 … n_vertices − 1.
MeshEdges mesh_edges(const Triangles& triangles, Eigen::Index n_vertices);

/// Neighbours of every vertex in order around it.
struct OneRings {
  std::vector<int> offsets;     ///< n + 1
  std::vector<int> vertices;    ///< the neighbours, counter-clockwise seen from outside
  std::vector<char> is_closed;  ///< per vertex: the ring closes; else it runs from border to border

  /// Number of neighbours of a vertex.
  int valence(Eigen::Index vertex) const {
    return offsets[static_cast<size_t>(vertex) + 1] - offsets[static_cast<size_t>(vertex)];
  }
};

/// @throws InvalidInput naming the vertex whose triangles do not form one fan of consistent orientation.
OneRings one_rings(const Triangles& triangles, Eigen::Index n_vertices);

/// The border as closed walks over vertices with the surface to the left (in a consistently oriented mesh);
/// no vertex is repeated at the end. Where the border touches itself at a vertex, the walk keeps to the fan
/// of triangles that it follows. A border that ends in an edge of three or more triangles is left open there.
std::vector<std::vector<int>> boundary_loops(const Triangles& triangles, const MeshEdges& edges);

/// For each triangle the number of its connected component (through shared edges), 0 … k − 1 in the order of
/// their first triangles.
std::vector<int> triangle_components(const MeshEdges& edges);

/// What a mesh is, combinatorially. Vertices that no triangle uses do not count.
struct MeshTopology {
  Eigen::Index n_vertices = 0, n_edges = 0, n_triangles = 0;
  Eigen::Index n_unused_vertices = 0;
  int n_components = 0;  ///< through shared edges
  int n_boundary_loops = 0;
  Eigen::Index n_boundary_edges = 0;
  /// V − E + F.
  Eigen::Index euler_characteristic = 0;
  /// Edges with three or more triangles; vertices whose triangles form more than one fan.
  std::vector<int> non_manifold_edges, non_manifold_vertices;
  /// Edges whose two triangles run along them in the same sense: one of both is turned inside out.
  std::vector<int> inconsistent_edges;
  /// Triangles that name a vertex twice.
  std::vector<int> collapsed_triangles;
  /// What is wrong, in words with the first place of each kind and the remedy; empty for an oriented
  /// manifold.
  std::vector<std::string> problems;

  /// No edge has more than two triangles, no vertex more than one fan, and no triangle names a vertex twice.
  bool is_manifold() const {
    return non_manifold_edges.empty() && non_manifold_vertices.empty() && collapsed_triangles.empty();
  }
  bool is_oriented() const { return inconsistent_edges.empty(); }
  /// Closed, manifold and consistently oriented: it has an inside.
  bool is_watertight() const {
    return n_triangles > 0 && is_manifold() && is_oriented() && n_boundary_edges == 0;
  }
  /// Handles of all components together: (2 k − b − χ)/2. Nothing when the mesh is not an oriented manifold.
  std::optional<Eigen::Index> genus() const;
};

/// @throws InvalidInput as mesh_edges().
MeshTopology mesh_topology(const Triangles& triangles, Eigen::Index n_vertices);

}  // namespace batten
