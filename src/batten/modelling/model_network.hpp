#pragma once
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/sketch/polyline_mesh.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {

/// The curves of a model as a network with its faces as patches. One curve per edge, sampled at the vertices
/// of the refined mesh, with normals estimated from it (where nobody has measured any); edges without a
/// second face are tagged as boundary. A network knows one normal per vertex, so a sharp edge is two curves
/// at one place, one for each side, but for the tip of a dart; where sharp edges divide the faces around a
/// vertex, each part has a vertex of its own.
struct ModelNetwork {
  CurveNetwork network;
  std::vector<NetworkCycle> cycles;  ///< one per face of the model, without `segments`
  std::vector<int> face_of_cycle;
  std::vector<int> place;  ///< per vertex of the network: that of the refined mesh
};

/// Normals beside a sharp edge are those of its side; with a sharpness below 1 they are drawn to the mean of
/// both sides. Ties that tools have made are taken from where the flow has moved them.
/// @pre `surface` was made from `mesh`.
ModelNetwork network_of_model(const PolylineMesh& mesh, const DiffusionSurface& surface);

/// A model filled by surface_network(), one patch per face.
struct FilledModel {
  TriangleMesh mesh;  ///< closed where the model is; normals along sharp edges are the mean of their sides
  std::vector<int> face_of_triangle;
  std::vector<int> turned;  ///< triangles against the propagated normals of their side
  std::vector<std::string> warnings;
  StageTimes times;
};

/// The parts on both sides of sharp edges are filled side by side and welded along them.
/// @pre `surface` was made from `mesh`. @throws InvalidInput, SolverFailure, Cancelled.
FilledModel fill_model(const PolylineMesh& mesh, const DiffusionSurface& surface,
                       const SurfaceOptions& options = {}, const Progress& progress = {});

}  // namespace batten
