#pragma once
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/operators/intrinsic.hpp"

// The flow of H 6.4.1 on a mesh, or on a part of one with the rest around it held. Private to the room.
namespace batten::detail {

/// How the flow begins on a face.
struct FlowPatch {
  enum class Begin {
    Kept,   ///< where it is
    Plate,  ///< start_flow() puts it onto a thin plate
    Coons,  ///< its inner vertices lie on a Coons patch, unless a plate bends less
  };
  Begin begin = Begin::Kept;
  /// The domain is the face seen from a side; else only the lengths of its sides are known from it.
  bool is_projection = true;
};

/// What the flow moves, and what it knows about the vertices.
struct FlowMesh {
  Points positions;
  Triangles triangles;
  /// Sides of the triangles in the domains of their faces, where quads have a shape even if they have none
  /// in space.
  EdgeLengths domain;
  std::vector<char> fixed;  ///< per vertex: never moves
  std::vector<char> soft;   ///< per vertex: held softly at `targets` (option fidelity)
  std::vector<char>
      without_row;  ///< per vertex: its mean curvature is not known (borders, the rim of a part)
  std::vector<double> sharpness;  ///< per vertex: S of (6.5), 0 where smooth
  std::vector<int> patch;         ///< per triangle: the face of the model
  std::vector<FlowPatch> patches;
  Points targets;  ///< n × 3; read where soft
};

/// A share of the diagonal of a matrix that ties every vertex to where it is: where creases on all sides
/// leave it no row of its own, it stays.
constexpr double kAnchor = 1e-10;

/// Areas of vertices, bounded from below so that the weights 1/M of slivers stay finite.
Eigen::VectorXd bounded_mass(const Eigen::VectorXd& mass);

/// Puts the vertices of patches that begin on a plate there, except those that are fixed, soft, or shared
/// with a Coons patch: min Σ M |M⁻¹ K X|² over the rows of smooth vertices. It bends on over smooth curves,
/// and is a plane where the curves lie in one. The metric is that of the domains, or, where these are no
/// projections, that of the membrane over the curves. A Coons patch follows tubes, which a plate through few
/// curves does not; where its sides turn around different axes it bulges. Of both the one that bends less,
/// together with its neighbours, is taken.
void start_flow(FlowMesh& mesh);

/// Rounds of STEP 1 and STEP 2 of H 6.4.1.
class CurvatureFlow {
 public:
  CurvatureFlow(FlowMesh& mesh, const DiffusionOptions& options);
  /// One round. @return the move of every vertex, n lengths.
  Eigen::VectorXd round();
  /// Divides the time step by three.
  void slow_down() { time_step_ /= 3; }

 private:
  double similarity(double s, double t) const;
  void diffuse(const SparseMatrix& K, const Eigen::VectorXd& M, Eigen::VectorXd& H);
  void move(const Points& step);

  FlowMesh& mesh_;
  const DiffusionOptions& options_;
  HeldUnknowns unknowns_;
  SparseCholesky diffusion_, refit_;
  double time_step_;
  Eigen::VectorXd moved_;
};

}  // namespace batten::detail
