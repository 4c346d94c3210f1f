#pragma once
#include <optional>
#include <string>

#include "batten/core/progress.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/scan/scan.hpp"

namespace batten {

/// Options of reconstruct(). The defaults are those of `batten reconstruct`.
struct ReconstructionOptions {
  ScanOptions network;
  NetworkSurfaceOptions surface;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A scan as a network and as a surface, each with its own warnings and stage times.
struct Reconstruction {
  ScanNetwork network;
  NetworkSurface surface;
};

/// From readings to a checked surface: network_from_scan(), network_surface().
/// @throws InvalidInput with curve, reading, node or patch and the remedy; SolverFailure; Cancelled.
Reconstruction reconstruct(const Scan& scan, const ReconstructionOptions& options = {},
                           const Progress& progress = {});

}  // namespace batten
