#pragma once
#include <pybind11/pybind11.h>

namespace batten::python {

// What python/batten calls, by theme; arguments as the classes of the package, options as a dict of all of
// them, results as dicts of fields. Checked arrays and words first, then the work without the lock of the
// interpreter.

void add_mesh_functions(
    pybind11::module_& module);  ///< repair, fair, remesh, simplify, deform, subdivide, compare, …
void add_network_functions(pybind11::module_& module);  ///< simulate, network, surface, reconstruct, …
void add_solvers(pybind11::module_& module);            ///< SurfaceSolver, ReconstructionSolver
void add_files(pybind11::module_& module);              ///< reading and writing

}  // namespace batten::python
