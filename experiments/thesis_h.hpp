#pragma once
#include "thesis_run.hpp"

#include <vector>

namespace batten::experiments {

/// H chapter 2: tables 2.1 to 2.5 (noise, fairing, remeshing, simplification) on those of its meshes that are
/// at hand, and deformations. The methods are called as `batten fair`, `remesh`, `simplify` and `deform` do.
std::vector<ThesisExperiment> thesis_h();

/// H chapter 7: the pen (7.1), surfaces of FIRES V1 (7.2) and V2 (7.3).
std::vector<ThesisExperiment> thesis_h_fires();

}  // namespace batten::experiments
