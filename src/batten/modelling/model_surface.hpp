#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/modelling/coons_surface.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/modelling/soundness.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// How the surface of a model of curves and faces is made.
enum class ModelSurfaceMethod {
  Coons,      ///< FIRES V1 (H 6.1–6.3): Coons patches, subdivided; the fastest, waves between the curves
  Diffusion,  ///< FIRES V2 (H 6.4): mean curvature diffused over the whole surface; the fairest
  Filled,     ///< the curves as a network with normals, filled by surface_network() (S 4.5)
};
/// In the order in which they are compared.
constexpr auto choices_of(ModelSurfaceMethod) {
  return choices<ModelSurfaceMethod>("method", {{ModelSurfaceMethod::Coons, "v1"},
                                                {ModelSurfaceMethod::Diffusion, "v2"},
                                                {ModelSurfaceMethod::Filled, "curvature"}});
}

/// Options of model_surface().
struct ModelSurfaceOptions {
  ModelSurfaceMethod method = ModelSurfaceMethod::Diffusion;
  /// Of the flow of Diffusion and Filled; Filled makes one split more, as filling refines no further.
  DiffusionOptions diffusion{};
  /// Levels of subdivision of the finished surface, 0 to 6, of every method but Filled; each makes four times
  /// as many triangles. `coons.levels` is overwritten by it.
  int levels = 3;
  CoonsOptions coons{};  ///< of Coons
  /// Off: only the cage of the limit surface is made, which is what CAD files hold.
  bool with_mesh = true;
  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// How the faces of a model were divided for its Coons patches (H 6.1).
struct FaceDivision {
  int n_triangles = 0, n_quads = 0;  ///< of the base mesh
  int n_divided = 0;                 ///< faces of the model
  int n_diagonals = 0;
  SplitCost cost;
};

/// The surface of a model, with what is to be said about it.
struct ModelSurface {
  TriangleMesh mesh;         ///< without triangles where only the cage was asked for
  ControlCage cage;          ///< its limit surface is what STEP files hold; empty where the scheme has none
  Eigen::Index n_quads = 0;  ///< of the refined mesh
  std::optional<FaceDivision> division;  ///< of Coons
  double last_move = 0;                  ///< of the flow, ÷ diameter; Diffusion and Filled
  std::vector<int> not_smoothed;         ///< faces that kept their first shape; Diffusion and Filled
  /// Faces of Diffusion that came out folded and were filled anew in the mesh, ascending. `cage` knows
  /// nothing of it.
  std::vector<int> filled_as_plates, filled_as_membranes;
  std::optional<SurfaceSoundness> soundness;  ///< where there is a mesh
  std::vector<std::string> warnings;          ///< with the faces and the remedy
  StageTimes times;
};

/// Makes the surface of a model by the chosen method and checks it.
/// @throws InvalidInput on bad options and where the method refuses the model, with the faces and the remedy;
/// SolverFailure; Cancelled.
ModelSurface model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options = {},
                           const Progress& progress = {});

}  // namespace batten
