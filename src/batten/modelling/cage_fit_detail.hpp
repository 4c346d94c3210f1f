#pragma once
#include <vector>

#include "batten/linalg/iterative.hpp"
#include "batten/mesh/control_cage.hpp"

// Private to the room.
namespace batten::detail {

/// Moves the vertices marked `free` (one mark per vertex) of a cage of quads until its Catmull–Clark limit
/// surface goes through `target` (n × 3) at those that are also `exact`, and as near to the others as it can
/// without wrinkles: S c + μ U U (c − t) = t with the limit stencils S and the umbrella U. All others stay;
/// it begins with where they are. Linear time: the weights fall off so fast that the iteration needs the same
/// few steps whatever the size.
/// @return rounds, and what the worst vertex still lacks as a fraction of the size. Converged where that is
/// below 1e-9, far less than can be seen; rounding stops most fits near 1e-13. Where the iteration leaves off
/// before, the best it had.
/// @throws SolverFailure when it leaves the finite numbers.
IterativeReport fit_limit(ControlCage& cage, const Points& target, const std::vector<char>& free,
                          const std::vector<char>& exact);

}  // namespace batten::detail
