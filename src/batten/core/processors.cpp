#include "batten/core/processors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sched.h>
#endif

namespace batten {

namespace {

/// The first words of a file; empty where it cannot be read.
std::vector<std::string> words_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istream_iterator<std::string>(in), std::istream_iterator<std::string>()};
}

/// Processors for a quota of `quota` µs in every `period` µs; nothing where they set no limit ("max", −1).
std::optional<int> processors_of(const std::string& quota, const std::string& period) {
  char *quota_end = nullptr, *period_end = nullptr;
  const double time = std::strtod(quota.c_str(), &quota_end),
               every = std::strtod(period.c_str(), &period_end);
  if (*quota_end != '\0' || *period_end != '\0' || !(time > 0 && every > 0)) return std::nullopt;
  return static_cast<int>(std::min(std::ceil(time / every), 1e6));
}

/// The limit that one group sets itself.
std::optional<int> limit_of_group(const std::string& folder, bool unified) {
  if (unified) {
    const std::vector<std::string> limit = words_of(folder + "/cpu.max");
    return limit.size() == 2 ? processors_of(limit[0], limit[1]) : std::nullopt;
  }
  const std::vector<std::string> quota = words_of(folder + "/cpu.cfs_quota_us"),
                                 period = words_of(folder + "/cpu.cfs_period_us");
  return quota.size() == 1 && period.size() == 1 ? processors_of(quota[0], period[0]) : std::nullopt;
}

#ifdef __linux__
/// Processors of the affinity mask; 0 where it cannot be read.
int affinity_processors() {
  // The kernel refuses masks shorter than its own.
  for (int size = CPU_SETSIZE; size <= (1 << 20); size *= 2) {
    cpu_set_t* set = CPU_ALLOC(size);
    if (set == nullptr) return 0;
    const std::size_t bytes = CPU_ALLOC_SIZE(size);
    const bool read = sched_getaffinity(0, bytes, set) == 0;
    const int count = read ? CPU_COUNT_S(bytes, set) : 0;
    CPU_FREE(set);
    if (read) return count;
  }
  return 0;
}
#endif

}  // namespace

std::optional<int> control_group_processors(const std::string& membership, const std::string& mount) {
  std::optional<int> least;
  const auto tighten = [&](std::optional<int> limit) {
    if (limit && (!least || *limit < *least)) least = limit;
  };
  std::istringstream lines(membership);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool unified = controllers.empty();
    if (!unified && ("," + controllers + ",").find(",cpu,") == std::string::npos) continue;
    const std::string root = unified ? mount : mount + "/" + controllers;
    // In a container the path may be that of the host: the groups that cannot be seen set no limit here.
    for (std::string path = line.substr(second + 1);; path.resize(path.rfind('/'))) {
      if (path == "/") path.clear();
      tighten(limit_of_group(root + path, unified));
      if (path.find('/') == std::string::npos) break;
    }
  }
  return least;
}

int available_processors() {
#if defined(__EMSCRIPTEN__)
  return 1;
#else
  int count = static_cast<int>(std::thread::hardware_concurrency());
#ifdef __linux__
  if (const int allowed = affinity_processors(); allowed > 0) count = allowed;
  std::ifstream in("/proc/self/cgroup");
  std::ostringstream membership;
  membership << in.rdbuf();
  if (const auto granted = control_group_processors(membership.str(), "/sys/fs/cgroup"))
    count = std::min(count, *granted);
#endif
  return std::max(1, count);
#endif
}

}  // namespace batten
