#pragma once
#include <array>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/remeshing/area_samples.hpp"

// Private to the room: the reference as the fit to its normals sees it.
namespace batten::remeshing {

/// Per corner k of every triangle: 1 where the edge to the next corner turns by more than `angle` radians.
/// O(n log n).
std::vector<std::array<char, 3>> crease_corners(const Points& positions, const Triangles& triangles,
                                                double angle);

/// Samples of the reference, by the faces of a mesh that they lie on. Faces may hand on samples to others.
class FitSamples {
 public:
  /// Takes the samples whose normal is within 60° of that of their face.
  /// @param faces those of the mesh in the order in which they are mostly asked for: samples of one face lie
  /// together in that order. @param compact the triangles by which `reference` numbers the faces.
  void take(ReferenceSamples reference, const HalfedgeMesh& mesh, const HalfedgeMesh::Compact& compact,
            const std::vector<int>& faces, const Progress& progress);

  AreaSample operator[](int s) const {
    const SamplePoint& point = points_[s];
    const SampledTriangle& piece = pieces_[point.triangle];
    return {point.point, piece.normal, piece.area, point.triangle};
  }
  const Eigen::Vector3d& point(int s) const { return points_[s].point; }

  /// The samples of a face, to be read and exchanged.
  const std::vector<int>& of_face(int f) const { return of_face_[f]; }
  std::vector<int>& of_face(int f) { return of_face_[f]; }

 private:
  std::vector<SampledTriangle> pieces_;  ///< per triangle of the reference
  std::vector<SamplePoint> points_;
  std::vector<std::vector<int>> of_face_;
};

}  // namespace batten::remeshing
