#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/modelling/triquadrification.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// An edge of a base mesh: a whole edge of the model, half of one, or a diagonal.
struct BaseEdge {
  int from = 0, to = 0;     ///< vertices of the base mesh
  SharedPolyline polyline;  ///< from the one to the other
  double sharpness = 0;     ///< 0 smooth … 1 sharp, as in the model
  bool drawn = false;       ///< false: ties of holes and diagonals, curves that nobody has drawn
};

/// A triangle or quad of a base mesh.
struct BaseFace {
  std::vector<int> sides;  ///< three or four, as side_of() numbers them, counter-clockwise
  int face = 0;            ///< face of the model in which it lies
  /// The Coons patch of the whole that it is a part of: of the divided face, or of the face in which a hole
  /// was cut; null for a face that is no part. It says how the inside bends; the sides have the last word.
  std::shared_ptr<const CoonsPatch> patch;
  std::vector<Eigen::Vector2d> parameters;  ///< of the patch, per corner
  /// Per side: it runs straight over the parameters of the patch; else only near it.
  std::vector<char> is_line;
};

/// The base mesh of H 6.1: the model with its faces divided into triangles and quads. Two edges may join the
/// same vertices.
struct BaseMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<BaseEdge> edges;
  std::vector<BaseFace> faces;
  /// Per edge of the model its one or two edges here, in its sense; empty for removed ones.
  std::vector<std::vector<int>> edges_of_edge;
  SplitCost cost;       ///< of all faces with more than four sides and of quads that were divided
  int n_divided = 0;    ///< such faces
  int n_diagonals = 0;  ///< new edges

  /// The polyline of an edge, in the sense of the side.
  SharedPolyline polyline_of(int side) const;
};

/// Triquadrification (H 6.1): divides the faces of a model. The edges of faces with two sides are halved
/// first. Ties of holes, which the model has as straight lines, run over the Coons patch of the face in which
/// the hole was cut, as H 5.2.2 has them.
/// @throws InvalidInput when the model has no faces.
BaseMesh triquadrified(const PolylineMesh& mesh, SplitSearch search = SplitSearch::Optimal);

}  // namespace batten
