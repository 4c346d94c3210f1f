#pragma once
#include "thesis_run.hpp"

#include <vector>

namespace batten::experiments {

/// S 3.14, 3.18 to 3.22, 4.19, 5.17 to 5.21: scans with errors, as networks and as surfaces.
std::vector<ThesisExperiment> thesis_s_scans();
/// S table 3.9, 3.11 to 3.13, 3.15 to 3.17: times, the stages of a network, and exact data.
std::vector<ThesisExperiment> thesis_s_networks();
/// S 4.6 and 4.7, table 5.2, 5.13 to 5.16: surfaces through exact networks.
std::vector<ThesisExperiment> thesis_s_surfaces();

/// All of them.
std::vector<ThesisExperiment> thesis_s();

}  // namespace batten::experiments
