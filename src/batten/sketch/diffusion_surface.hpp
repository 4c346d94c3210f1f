#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// Options of diffusion_surface(). The defaults are those of H 7.3.
struct DiffusionOptions {
  /// Splits of every face: the first makes n quads of n sides, each further one four of each. 3 gives the 16
  /// n quads of H 6.4; cost grows fourfold with each. 1 to 6.
  int splits = 3;
  /// Rounds of diffusion and refit, 0 to 50. Ten are enough for great circles to become a sphere.
  int rounds = 10;
  /// Time step τ of the diffusion without a unit (areas are divided by their mean), above 0; H: 0.1 to 1.
  double time_step = 1;
  /// Implicit steps of diffusion in each round (n_MAX), at least 1.
  int diffusion_steps = 5;
  /// σ of (6.5), above 0; smaller keeps vertices of different sharpness further apart.
  double similarity = 0.2;
  /// λ of (6.4): how strongly drawn curves hold. 0: they are kept exactly; H uses 1.
  double fidelity = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
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
  double last_move = 0;  ///< largest move of a vertex in the last round, ÷ diameter
  StageTimes times;
};

/// The surface of FIRES V2 (H 6.4): faces are split at their centroids, then mean curvature is diffused over
/// the surface (6.3), not across what is sharp, and the positions are refitted to it (6.4), in turns. Closed
/// components are turned so that their normals point outwards.
/// Vertices that lie on a border or on sharp curves take no part in the diffusion (6.5), and their rows
/// of the refit are left out, so that a crease bends freely.
/// @throws InvalidInput on bad options, an empty model, more than 2 million quads, and where the surface
/// would fold, cross itself or leave its curves, with the faces; SolverFailure; Cancelled.
DiffusionSurface diffusion_surface(const PolylineMesh& mesh, const DiffusionOptions& options = {},
                                   const Progress& progress = {});

}  // namespace batten
