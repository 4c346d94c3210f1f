#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/operators/mesh_variation.hpp"

namespace batten {

/// The triangles of a mesh, or the segments of a network.
Shape shape_of(const TriangleMesh& mesh);
Shape shape_of(const CurveNetwork& network);

/// How two shapes differ. Lengths in the unit of B.
struct ShapeComparison {
  Comparison distances;
  double hausdorff = 0;  ///< the largest distance found, in either direction
  /// How the triangles of A, moved onto B, differ from those of B; nothing unless both are oriented
  /// manifolds.
  std::optional<MeshVariation> variation;
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Measures one shape against another: compare(), mesh_variation(). The options are those of `batten
/// compare`.
/// @throws InvalidInput as compare(); Cancelled.
ShapeComparison compared_shapes(const Shape& a, const Shape& b, const CompareOptions& options = {},
                                const Progress& progress = {});

/// The mesh that was measured as A, moved as it was, with its distances per vertex as the value "distance".
TriangleMesh measured_mesh(TriangleMesh a, const Comparison& distances);

/// How far something made is from the truth, after a motion onto it.
struct TruthErrors {
  /// Per vertex, in per cent of `diameter`; NaN where no element uses the vertex.
  Eigen::VectorXd vertices;
  DistanceFigures figures;        ///< over the vertices, in per cent of `diameter`
  DistanceFigures lengths;        ///< the same in the unit of the truth
  DistanceFigures normal_angles;  ///< radians; see DirectedComparison
  double diameter = 0;            ///< of the truth
};

/// What `batten reconstruct --truth` measures, and `batten render --against` shows.
/// @param registration which motions what was made is moved by. @throws InvalidInput as compare(); Cancelled.
TruthErrors truth_errors(const Shape& made, const Shape& truth,
                         RegistrationKind registration = RegistrationKind::Rigid,
                         const Progress& progress = {});

}  // namespace batten
