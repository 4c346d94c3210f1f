#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/deformation/deformer.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// How a MultiresolutionDeformer works.
struct MultiresolutionOptions {
  /// Of the energy and the detail preservation; max_iterations counts those on the base.
  DeformOptions deform;
  /// Vertices of the base, at least 50. A mesh with fewer is its own base.
  Eigen::Index base_vertices = 2500;
  /// Iterations on the fine mesh after the detail is back, at least 1.
  int fine_iterations = 3;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Deforms a mesh in two resolutions (H, part 1): a simplified base follows the handles, with all iterations
/// that this takes; the detail, kept in frames of the base, is put back; a few iterations on the fine mesh
/// then meet its handles exactly and take the facets of the base out. Low frequencies, which converge
/// slowest, converge where iterations are cheap.
class MultiresolutionDeformer {
 public:
  /// @param constrained as for Deformer.
  /// @throws as Deformer, and InvalidInput when the mesh cannot be simplified; Cancelled.
  MultiresolutionDeformer(const Points& positions, const Triangles& triangles, std::vector<int> constrained,
                          const MultiresolutionOptions& options = {}, const Progress& progress = {});
  ~MultiresolutionDeformer();
  MultiresolutionDeformer(MultiresolutionDeformer&&) noexcept;
  MultiresolutionDeformer& operator=(MultiresolutionDeformer&&) noexcept;

  /// @param targets one row per constrained vertex of the fine mesh.
  /// @param stages targets on the way, in order: the base goes through them first. Large turns need them,
  /// because the iterations begin at a linear solution.
  Deformer::Result deform(const Points& targets, const std::vector<Points>& stages = {},
                          const Progress& progress = {}) const;

  /// The base at rest.
  const TriangleMesh& base() const;
  /// As Deformer::curvature_term(), of the fine mesh.
  double curvature_term() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace batten
