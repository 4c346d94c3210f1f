#pragma once
#include <memory>
#include <optional>

#include "batten/core/progress.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/session/object.hpp"
#include "batten/surfacing/surface.hpp"

// Private to the room: what a slider shows while it moves.
namespace batten::detail {

/// The network of a scan and a coarse surface through it, by solvers that are kept from one position of a
/// slider to the next: the readings are cleaned once, and where the samples stay the same the surface is
/// moved instead of built.
class LiveSurface {
 public:
  struct Shown {
    const CurveNetwork* network = nullptr;
    const ScanReport* report = nullptr;
    const SurfaceResult* surface = nullptr;
    bool rebuilt = false;  ///< the triangles are other ones than those shown last
  };

  /// @param edge_length of the coarse surface, a part of the diameter of the network.
  /// @param moving follow() instead of solve(): see ReconstructionSolver.
  /// @throws as ReconstructionSolver and SurfaceSolver. What is shown holds until the next call.
  Shown show(const SharedScan& scan, const ScanOptions& options, const NetworkSurfaceOptions& surface,
             double edge_length, bool moving, const Progress& progress);

 private:
  SharedScan scan_;
  std::unique_ptr<ReconstructionSolver> solver_;
  std::unique_ptr<SurfaceSolver> surface_;
  SurfaceOptions options_;
  ScanNetwork network_;
};

}  // namespace batten::detail
