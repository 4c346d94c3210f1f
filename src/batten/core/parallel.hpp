#pragma once
#include <functional>

#include <Eigen/Core>

namespace batten {

/// Runs body(begin, end) over consecutive chunks of 0 … n − 1 on all processors. The chunks depend on n and
/// `grain` alone, never on the number of threads, so work that writes per chunk is deterministic.
/// The first exception of a chunk is rethrown. Serial where there are no threads (the browser).
/// @param grain the size of a chunk, at least 1; choose it so that a chunk takes some 0.1 ms or more.
void parallel_for(Eigen::Index n, Eigen::Index grain,
                  const std::function<void(Eigen::Index begin, Eigen::Index end)>& body);

}  // namespace batten
