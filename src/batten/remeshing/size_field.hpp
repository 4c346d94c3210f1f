#pragma once
#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/remeshing/feature_chains.hpp"

namespace batten {

/// Curvature of the surface at each vertex, √(κ1² + κ2²), and of the feature curves through it where that is
/// larger; 1/length. From the change of the vertex normals over the triangles, with creases (the marked
/// edges) taken as breaks and not as curvature; averaged over `rings` one-rings against noise.
Eigen::VectorXd curvature_magnitude(const HalfedgeMesh& mesh, const FeatureChains& chains, int rings = 2);

/// Number of vertices of a mesh of good triangles with edges of the given lengths: ∫ 2 / (√3 h²) dA over the
/// surface (each equilateral triangle of edge h has the area √3/4 h² and, on average, half a vertex).
double vertices_for_sizes(const HalfedgeMesh& mesh, const Eigen::VectorXd& sizes);

/// Edge lengths per vertex: finer where the surface is curved, h ∝ κ^(−adaptivity/2), between mean_length ·
/// 4^∓ adaptivity, changing by at most `gradation` per unit of length. Scaled so that vertices_for_sizes() is
/// what edges of mean_length everywhere would give. h ∝ κ^(−1/2) makes the mean squared error of the normals,
/// ∫ (κ h)², least for a given number of vertices.
/// @param adaptivity 0 (the same length everywhere) to 1.
Eigen::VectorXd adaptive_sizes(const HalfedgeMesh& mesh, const Eigen::VectorXd& curvature, double mean_length,
                               double adaptivity, double gradation);

/// Lowers sizes until they change by at most `gradation` per unit of length along edges.
void limit_gradation(const HalfedgeMesh& mesh, double gradation, Eigen::VectorXd& sizes);

}  // namespace batten
