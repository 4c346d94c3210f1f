#include "batten/core/processors.hpp"

#include "scratch.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#ifdef __linux__
#include <sched.h>
#endif

#include <gtest/gtest.h>

namespace batten {
namespace {

/// A tree of control groups in a folder of its own.
class Groups {
 public:
  explicit Groups(const std::string& name) : root_(test::scratch() + "/" + name) {
    std::filesystem::remove_all(root_);
  }
  const std::string& root() const { return root_; }
  void write(const std::string& file, const std::string& text) const {
    const std::filesystem::path path = root_ + "/" + file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text << '\n';
  }

 private:
  std::string root_;
};

// The quota is 150 ms of processor time in every 100 ms: two processors, half of the time on the second.
TEST(Processors, RoundsTheGrantOfAControlGroupUp) {
  const Groups groups("v2");
  groups.write("job/cpu.max", "150000 100000");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), 2);
  groups.write("job/cpu.max", "200000 100000");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), 2);
  groups.write("job/cpu.max", "1000 100000");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), 1);
}

TEST(Processors, TakesTheTightestGroupUpToTheRoot) {
  const Groups groups("nested");
  groups.write("outer/cpu.max", "300000 100000");
  groups.write("outer/inner/cpu.max", "max 100000");
  groups.write("outer/inner/leaf/cpu.max", "800000 100000");
  EXPECT_EQ(control_group_processors("0::/outer/inner/leaf\n", groups.root()), 3);
  groups.write("cpu.max", "100000 100000");  // what a container sees of its own group
  EXPECT_EQ(control_group_processors("0::/outer/inner/leaf\n", groups.root()), 1);
  EXPECT_EQ(control_group_processors("0::/\n", groups.root()), 1);
}

TEST(Processors, ReadsControlGroupsOfVersionOne) {
  const Groups groups("v1");
  groups.write("cpu,cpuacct/job/cpu.cfs_quota_us", "400000");
  groups.write("cpu,cpuacct/job/cpu.cfs_period_us", "100000");
  EXPECT_EQ(control_group_processors("4:memory:/job\n3:cpu,cpuacct:/job\n", groups.root()), 4);
  groups.write("cpu,cpuacct/job/cpu.cfs_quota_us", "-1");
  EXPECT_EQ(control_group_processors("3:cpu,cpuacct:/job\n", groups.root()), std::nullopt);
}

TEST(Processors, SeesNoLimitWhereThereIsNone) {
  const Groups groups("none");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), std::nullopt);
  groups.write("job/cpu.max", "max 100000");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), std::nullopt);
  groups.write("job/cpu.max", "rubbish");
  EXPECT_EQ(control_group_processors("0::/job\n", groups.root()), std::nullopt);
  EXPECT_EQ(control_group_processors("", groups.root()), std::nullopt);
  EXPECT_EQ(control_group_processors("no colons", groups.root()), std::nullopt);
}

#ifdef __linux__
TEST(Processors, FollowsTheAffinityMask) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_LE(available_processors(), CPU_COUNT(&before));
  CPU_ZERO(&one);
  for (int c = 0; c < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++c)
    if (CPU_ISSET(c, &before)) CPU_SET(c, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(available_processors(), 1);
  EXPECT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}
#endif

}  // namespace
}  // namespace batten
