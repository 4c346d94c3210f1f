#include "batten/pipeline/reconstruction.hpp"

#include "batten/core/error.hpp"

namespace batten {

std::optional<std::string> ReconstructionOptions::problem() const {
  if (auto problem = network.problem()) return problem;
  return surface.problem();
}

Reconstruction reconstruct(const Scan& scan, const ReconstructionOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  Reconstruction result;
  result.network = network_from_scan(scan, options.network, progress);
  result.surface = network_surface(result.network.network, options.surface, progress);
  return result;
}

}  // namespace batten
