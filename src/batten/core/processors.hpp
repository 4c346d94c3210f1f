#pragma once
#include <optional>
#include <string>

namespace batten {

/// Processors that this process may use: those of its affinity mask, and no more than the processor time that
/// its control groups grant it (rounded up to whole processors). At least 1; 1 in the browser.
int available_processors();

/// The processor time that control groups grant, in processors rounded up; nothing where there is no limit.
/// The tightest limit from the group up to the root counts.
/// @param membership text of /proc/self/cgroup: lines "number:controllers:path", version 1 or 2.
/// @param mount where the hierarchies are mounted, /sys/fs/cgroup.
std::optional<int> control_group_processors(const std::string& membership, const std::string& mount);

}  // namespace batten
