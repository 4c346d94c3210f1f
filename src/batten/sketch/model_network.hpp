#pragma once
#include "batten/network/curve_network.hpp"
#include "batten/sketch/diffusion_surface.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// The curves of a model as a network for surface_network(): one curve per edge, sampled at the vertices of
/// the refined mesh, with normals estimated from it (where nobody has measured any), edges without a second
/// face tagged as boundary. Ties that tools have made are taken from where the flow has moved them.
/// @pre `surface` was made from `mesh`.
CurveNetwork network_of_model(const PolylineMesh& mesh, const DiffusionSurface& surface);

}  // namespace batten
