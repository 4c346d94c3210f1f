#pragma once
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/report/report.hpp"

namespace batten {

/// What a run made, to be drawn.
struct Exhibit {
  std::optional<TriangleMesh> mesh;
  std::optional<CurveNetwork> network;
  /// Distances to a truth per vertex of the mesh, or of the network where there is no mesh, in per cent of
  /// the diameter of the truth (TruthErrors::vertices); empty without a truth.
  Eigen::VectorXd errors;
};

/// Draws it in every fitting shading, each with a title and what to see in it: mesh and network together, the
/// errors, then the mesh and the network alone. Empty where there is nothing to draw. Some tenths of a second
/// for every picture. @throws InvalidInput as render(); Cancelled.
std::vector<ReportPicture> exhibit_pictures(const Exhibit& exhibit, const Progress& progress = {});

}  // namespace batten
