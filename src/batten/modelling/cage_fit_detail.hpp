#pragma once
#include <vector>

#include "batten/mesh/control_cage.hpp"

// Private to the room.
namespace batten::detail {

/// Moves the vertices marked `free` (one mark per vertex) of a cage of quads until its Catmull–Clark limit
/// surface goes through `target` (n × 3) at those that are also `exact`, and as near to the others as it can
/// without wrinkles: S c + μ U U (c − t) = t with the limit stencils S and the umbrella U. All others stay;
/// it begins with where they are. Linear time: the weights fall off so fast that the iteration needs the same
/// few steps whatever the size.
/// @throws SolverFailure.
void fit_limit(ControlCage& cage, const Points& target, const std::vector<char>& free,
               const std::vector<char>& exact);

}  // namespace batten::detail
