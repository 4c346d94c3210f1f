#pragma once
#include <functional>

#include <Eigen/Core>

#include "batten/core/progress.hpp"

namespace batten {

/// Most threads that work of the library runs on, the calling one included. Results never depend on it.
int thread_count();
/// Sets thread_count() for the whole process, from the next parallel loop on. @param n at least 1; 0 takes
/// available_processors(), which is also what holds before the first call.
/// @throws InvalidInput when n is negative.
void set_thread_count(int n);

/// Runs body(begin, end) over consecutive chunks of 0 … n − 1 on thread_count() threads. The chunks depend on
/// n and `grain` alone, never on the number of threads, so work that writes per chunk is deterministic. The
/// first exception of a chunk is rethrown. A loop inside the body of another runs on its thread alone. Serial
/// where there are no threads (the browser).
/// @param grain the size of a chunk, at least 1; choose it so that a chunk takes some 0.1 ms or more.
void parallel_for(Eigen::Index n, Eigen::Index grain,
                  const std::function<void(Eigen::Index begin, Eigen::Index end)>& body);
/// The same, with a report from the calling thread, and from no other, before each chunk that it takes.
/// @throws Cancelled after the chunks that are being worked on.
void parallel_for(Eigen::Index n, Eigen::Index grain,
                  const std::function<void(Eigen::Index begin, Eigen::Index end)>& body,
                  const Progress& progress);

/// The sum of body(begin, end) over the chunks of parallel_for(), added up in their order.
double parallel_sum(Eigen::Index n, Eigen::Index grain,
                    const std::function<double(Eigen::Index begin, Eigen::Index end)>& body);

}  // namespace batten
