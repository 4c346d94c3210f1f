#pragma once
#include <cstddef>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {

/// What flatten_crossing_patches() did.
struct FlatteningReport {
  std::vector<int> patches;          ///< those that were flattened, increasing
  std::size_t crossings_before = 0;  ///< pairs of triangles that cross or fold onto each other
  std::size_t crossings_after = 0;
};

/// Pulls patches that cross others or themselves, or that are folded, towards the membrane over their curves:
/// first halfway, and where that does not help, altogether. Curves stay, other patches stay, and across the
/// curves of a flattened patch the surface has an edge. It is meant for sketches: normals that were estimated
/// from curves round off every rim, and where two walls lie close together their bulges go through each
/// other. A surface without crossings and folds is left as it is, bit for bit; so is one where crossings
/// and folded triangles together would not become fewer. Counts and normals of the result are brought up to
/// date; what was flattened is told in its warnings.
/// @throws SolverFailure; Cancelled.
FlatteningReport flatten_crossing_patches(SurfaceResult& surface, const Progress& progress = {});

}  // namespace batten
