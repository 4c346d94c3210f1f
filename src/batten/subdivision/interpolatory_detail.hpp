#pragma once
#include "batten/core/progress.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

// Private to the room.
namespace batten::detail {

/// Nuliss, NulissMod and Linear: the schemes that keep the vertices where they are. Fills the whole result.
void refine_interpolatory(const ControlCage& cage, const CageTopology& topology,
                          const SubdivisionOptions& options, SubdividedSurface& surface,
                          const Progress& progress);

}  // namespace batten::detail
