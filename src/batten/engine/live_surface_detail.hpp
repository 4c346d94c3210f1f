#pragma once
#include <array>
#include <memory>
#include <optional>

#include "batten/core/progress.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/session/object.hpp"
#include "batten/surfacing/surface.hpp"

// Private to the room: what a slider shows while it moves.
namespace batten::detail {

/// How fine a surface is shown.
enum class LiveDetail {
  Coarse,  ///< while something moves
  Fine,    ///< at rest: as fine as was asked for
};

/// The network of a scan and a surface through it, by solvers that are kept from one position of a slider to
/// the next: the readings are cleaned once, and where the samples stay the same a surface is moved instead of
/// built. One that was moved is not checked, and differs from one that is built by what its metric has
/// changed.
class LiveSurface {
 public:
  struct Shown {
    const CurveNetwork* network = nullptr;
    const ScanReport* report = nullptr;
    const SurfaceResult* surface = nullptr;
    bool rebuilt = false;  ///< the triangles are other ones than those shown last
  };

  /// @param edge_length of a coarse surface, a part of the diameter of the network.
  /// @param moving follow() instead of solve(): see ReconstructionSolver.
  /// @throws as ReconstructionSolver and SurfaceSolver. What is shown holds until the next call.
  Shown show(const SharedScan& scan, const ScanOptions& options, const NetworkSurfaceOptions& surface,
             LiveDetail detail, double edge_length, bool moving, const Progress& progress);

 private:
  SharedScan scan_;
  std::unique_ptr<ReconstructionSolver> solver_;
  struct Kept {
    std::unique_ptr<SurfaceSolver> solver;
    SurfaceOptions options;
    CurveNetwork network;  ///< that it was built or moved to last
  };
  std::array<Kept, 2> surfaces_;  ///< by LiveDetail
  ScanReport report_;
};

}  // namespace batten::detail
