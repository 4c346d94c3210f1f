#pragma once
#ifdef __unix__
#include <sys/resource.h>
#endif

namespace batten {

/// The most memory that this process has held so far, in MB; 0 where the system does not tell. To measure
/// one benchmark, run it alone (--benchmark_filter).
inline double peak_megabytes() {
#ifdef __unix__
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
#else
  return 0;
#endif
}

}  // namespace batten
