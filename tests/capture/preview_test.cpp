#include "batten/capture/preview.hpp"

#include "capture/simulated.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "batten/core/text.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten::test {
namespace {

/// Where the preview stood when each node was marked for the first time, and all drifts.
struct Followed {
  std::map<int, double> greatest_drift;  // per node
  std::vector<double> drifts;
  PreviewState last;
};

Followed follow(const Recording& recording) {
  Followed followed;
  LivePreview preview(recording.header);
  double known = -1;
  for (const CaptureEvent& event : recording.events) {
    preview.push(event);
    const PreviewState& state = preview.state();
    if (state.drift_m && *state.drift_m != known) {
      known = *state.drift_m;
      followed.drifts.push_back(known);
      double& greatest = followed.greatest_drift[state.drift_node];
      greatest = std::max(greatest, known);
    }
  }
  followed.last = preview.state();
  return followed;
}

// An exact device on a sphere of 0.3 m comes back to every node to within the ticks of its wheel: 0.13 mm a
// step, of which a quarter of a circle has some thousand, and their roundings do not add up.
TEST(LivePreview, ComesBackToNodesOfAnExactDevice) {
  for (const char* device : {"&noise=0", "&noise=0&device=line", "&noise=0&device=line&fused=1"}) {
    const Captured run = captured(std::string("simulator:sphere?speed=max&pace=5") + device);
    const Followed followed = follow(run.recording);
    EXPECT_EQ(followed.last.n_curves, 3);
    EXPECT_EQ(followed.last.n_nodes, 6);
    EXPECT_GE(followed.drifts.size(), 4U);
    for (const double drift : followed.drifts) {
      EXPECT_LT(drift, 1e-3) << device;
    }
    EXPECT_EQ(followed.last.n_missing, 0) << device;
    EXPECT_NEAR(followed.last.rate_hz, 100, 1) << device;
  }
}

TEST(LivePreview, ShowsASlippingWheelAsDrift) {
  const Captured run = captured("simulator:sphere?speed=max&pace=5&noise=0&slip=10:4&slipshare=0.5");
  const Followed followed = follow(run.recording);
  double greatest = 0;
  for (const double drift : followed.drifts) greatest = std::max(greatest, drift);
  EXPECT_GT(greatest, 0.01);
}

TEST(LivePreview, IsNotStuckByWrongBytes) {
  for (const int seed : {1, 4, 7}) {
    const Captured run = captured(concat("simulator:sphere?speed=max&pace=5&flip=1%&seed=", seed));
    const Followed followed = follow(run.recording);
    EXPECT_EQ(followed.last.n_curves, 3) << seed;
    // A fifth of the packets is spoilt; of the others nearly all are believed, to the very end.
    const auto all = static_cast<double>(followed.last.n_readings + followed.last.n_refused);
    EXPECT_LT(static_cast<double>(followed.last.n_refused), 0.22 * all) << seed;
    EXPECT_GT(followed.last.rate_hz, 70) << seed;
  }
}

TEST(LivePreview, CountsGapsAndMissingSamples) {
  const Captured run = captured("simulator:sphere?speed=max&pace=5&device=line&silence=5:2", {.seconds = 12});
  const Followed followed = follow(run.recording);
  EXPECT_EQ(followed.last.n_gaps, 1);
  EXPECT_NEAR(static_cast<double>(followed.last.n_missing), 200, 2);
}

TEST(LivePreview, FollowsKeys) {
  LivePreview preview(RecordingHeader{});
  const auto press = [&](std::int64_t time, const std::string& key) {
    preview.push({time, "keys", EventKind::Key, key});
  };
  press(0, "+");
  EXPECT_TRUE(preview.state().drawing);
  press(100, "1");
  EXPECT_EQ(preview.state().digits, "1");
  press(200, "enter");
  EXPECT_EQ(preview.state().n_nodes, 1);
  press(300, "*");
  EXPECT_TRUE(preview.state().paused);
  press(400, "/");
  EXPECT_EQ(preview.state().n_curves, 0);
  EXPECT_EQ(preview.state().n_nodes, 0);  // the node was new in the curve that was discarded
  preview.push({500, "device", EventKind::State, "lost it"});
  EXPECT_EQ(preview.state().source, "lost it");
}

}  // namespace
}  // namespace batten::test
