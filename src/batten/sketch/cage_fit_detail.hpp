#pragma once
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/mesh/control_cage.hpp"

// Private to the room.
namespace batten::detail {

/// Moves the vertices marked `free` (one mark per vertex) of a cage of quads until its Catmull–Clark limit
/// surface goes through `target` (n × 3) at them, beginning with where they are; all others stay. Linear
/// time: the weights fall off so fast that the iteration needs the same few steps whatever the size.
/// @throws SolverFailure, Cancelled.
void fit_limit(ControlCage& cage, const Points& target, const std::vector<char>& free,
               const Progress& progress);

}  // namespace batten::detail
