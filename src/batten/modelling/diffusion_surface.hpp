#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/linalg/iterative.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// Options of diffusion_surface(). The defaults are those of H 7.3.
struct DiffusionOptions {
  /// Splits of every face: the first makes n quads of n sides, each further one four of each; faces with
  /// concave corners are divided there first and make more. 3 gives the 16 n quads of H 6.4; cost grows
  /// fourfold with each. 1 to 6.
  int splits = 3;
  /// Rounds of diffusion and refit at most, 0 to 200. They end earlier when nothing moves any more.
  int rounds = 30;
  /// The flow has come to rest when no vertex moves by more than this share of the diameter in a round;
  /// above 0. It is also how far a surface that follows edits may differ from one made from nothing.
  double tolerance = 1e-4;
  /// Time step τ of the diffusion without a unit (areas are divided by the mean area of a vertex of the face
  /// at three splits), above 0; H: 0.1 to 1.
  double time_step = 1;
  /// Implicit steps of diffusion in each round (n_MAX), at least 1.
  int diffusion_steps = 5;
  /// σ of (6.5), above 0; smaller keeps vertices of different sharpness further apart.
  double similarity = 0.2;
  /// λ of (6.4): how strongly drawn curves hold. 0: they are kept exactly; H uses 1.
  double fidelity = 0;
  /// Faces that fold or cross others however they are made are left as they are, for whoever checks the
  /// finished surface; off: the surface is refused.
  bool keep_folded = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
  bool operator==(const DiffusionOptions&) const = default;
};

/// The refined mesh of H 6.4 before and after its flow.
struct DiffusionSurface {
  /// All quads, counter-clockwise seen from outside; sharp edges as creases (sharpness 1 for ever, below that
  /// four levels times the sharpness).
  ControlCage refined;
  /// The same with vertices moved so that the limit surface of Catmull–Clark goes through those of `refined`.
  ControlCage cage;
  std::vector<char> on_curve;     ///< per vertex: held by a drawn curve
  std::vector<int> face_of_quad;  ///< face of the model
  /// Per edge of the model (empty for removed ones): its 2^splits + 1 vertices.
  std::vector<std::vector<int>> vertices_of_edge;
  double last_move = 0;           ///< largest move of a vertex in the last round, ÷ diameter
  std::vector<int> not_smoothed;  ///< see SurfaceUpdate
  IterativeReport cage_fit;       ///< see SurfaceUpdate
  StageTimes times;
};

/// What an update of an EditedSurface has done.
struct SurfaceUpdate {
  std::vector<int> faces;  ///< faces of the model whose part of the surface is new, ascending
  Eigen::Index quads = 0;  ///< of these faces
  /// Faces of the model (ascending, of all) that the flow would fold: they keep the shape from which it
  /// starts, and meet their neighbours in a crease.
  std::vector<int> not_smoothed;
  int rounds = 0;        ///< of the flow
  double last_move = 0;  ///< largest move of a vertex in the last round, ÷ diameter
  /// How far the limit surface is from going where it should, ÷ diameter of what was fitted. Where it has not
  /// converged the cage is the best found: warn.
  IterativeReport cage_fit{.iterations = 0, .residual = 0, .converged = true};
  StageTimes times;
};

/// The surface of FIRES V2 (H 6.4) of a model that is being edited. Every face is split into quads in its
/// plane, concave corners first; a thin plate through the curves is where the flow starts from; then mean
/// curvature is diffused over the surface (6.3), not across what is sharp, and the positions are refitted to
/// it (6.4), in turns, until nothing moves.
/// Vertices that lie on a border or on sharp curves take no part in the diffusion (6.5), and their rows
/// of the refit are left out, so that a crease bends freely.
///
/// It keeps what it has made: after an edit, only the faces that the edit has touched begin anew, and the
/// flow moves them and as many rings of faces around them as the change reaches, the rest being held. Curves
/// are held where they were drawn, so a change dies away within a few faces, and the cost follows the edit.
/// With `fidelity` above 0 nothing holds it up, and all of a component is done again.
class EditedSurface {
 public:
  /// @throws InvalidInput on bad options.
  explicit EditedSurface(const DiffusionOptions& options = {});
  ~EditedSurface();
  EditedSurface(EditedSurface&&) noexcept;
  EditedSurface& operator=(EditedSurface&&) noexcept;

  /// Follows the model: does what is new in it since the last update, whatever led to it. (Finding that out
  /// looks at every curve and face once, at none of their quads.)
  /// @throws InvalidInput on an empty model, more than 2 million quads, and where the surface would fold,
  /// cross itself or leave its curves, with the faces; SolverFailure; Cancelled. What was not finished is
  /// done in the next update.
  SurfaceUpdate update(const PolylineMesh& mesh, const Progress& progress = {});

  /// The whole surface; closed components are turned so that their normals point outwards. Time is that of
  /// copying. @pre the last update has succeeded, and `mesh` is its model.
  DiffusionSurface surface(const PolylineMesh& mesh) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The surface of a model, made from nothing: the first update of an EditedSurface.
/// @throws as EditedSurface does.
DiffusionSurface diffusion_surface(const PolylineMesh& mesh, const DiffusionOptions& options = {},
                                   const Progress& progress = {});

}  // namespace batten
