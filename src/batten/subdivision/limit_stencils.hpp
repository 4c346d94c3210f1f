#pragma once
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/control_cage.hpp"

namespace batten {

/// Limit points of Catmull–Clark at the vertices of an all-quad cage: row v of this n × n matrix holds the
/// weights of the cage's vertices in the limit point of vertex v; rows sum to one. The rules are those of
/// subdivide() with sharp corners of the border, for creases, corners, darts and borders, semi-sharp ones
/// too. [halstead1993] [biermann2000] [derose1998]
/// @pre All faces are quads, as subdivide() takes them. @throws InvalidInput on a face that is none.
SparseMatrix limit_stencils(const ControlCage& cage);

}  // namespace batten
