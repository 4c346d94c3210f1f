#include "batten/network/estimated_cycles.hpp"

#include "network/sample_networks.hpp"
#include "network/sphere_network.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/units.hpp"
#include "batten/io/network_io.hpp"

namespace batten {
namespace {

CurveNetwork without_normals(CurveNetwork network) {
  network.normals.resize(0, 3);
  return network;
}

/// Cycles as sets of the vertices of their loops: what does not change when a surface is seen from inside.
std::multiset<std::set<std::set<int>>> patches(const std::vector<NetworkCycle>& cycles) {
  std::multiset<std::set<std::set<int>>> result;
  for (const NetworkCycle& cycle : cycles) {
    std::set<std::set<int>> loops;
    for (const NetworkCycle::Loop& loop : cycle.loops)
      loops.insert(std::set<int>(loop.vertices.begin(), loop.vertices.end()));
    result.insert(loops);
  }
  return result;
}

class SharedNetworks : public testing::TestWithParam<const char*> {};

// The networks lie on known surfaces and bring their normals; the answer is what find_cycles() makes of those.
TEST_P(SharedNetworks, HaveTheSameCyclesWithoutTheirNormals) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/networks/" + GetParam() + ".net";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const CurveNetwork network = read_network(path);
  const EstimatedCycles estimate = estimate_cycles(without_normals(network));
  EXPECT_EQ(patches(estimate.cycles), patches(find_cycles(network).cycles));
  double sum = 0, worst = 0, count = 0, agree = 0;
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) agree += estimate.normals.row(v).dot(network.normals.row(v));
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) {
      const double angle = std::acos(std::clamp((agree < 0 ? -1 : 1) * estimate.normals.row(v).dot(network.normals.row(v)), -1.0, 1.0));
      sum += angle;
      ++count;
      worst = std::max(worst, angle);
    }
  std::cout << GetParam() << " mean " << degrees(sum / count) << " worst " << degrees(worst) << " cycles " << estimate.cycles.size() << "\n";
  for (auto& w : estimate.warnings) std::cout << "  " << w << "\n";
}
INSTANTIATE_TEST_SUITE_P(EstimatedCycles, SharedNetworks,
                         testing::Values("bumpycube", "dish", "ellipsoid5", "saddle", "sphere3", "sphere6",
                                         "torus", "waves"),
                         [](const auto& network) { return std::string(network.param); });

}  // namespace
}  // namespace batten
