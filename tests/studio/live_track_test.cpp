// The way of a device as windows draw it: curves, nodes, what is moved or forgotten, and a bound on all of
// it.
#include "studio/live_track.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

using studio::LiveTrack;

/// A person who draws: the states of a preview without its sensors.
struct Hand {
  PreviewState state;

  void begin(LiveTrack& track) {
    ++state.n_curves;
    state.drawing = true;
    state.placed = false;
    state.distance_m = 0;
    state.position.setZero();
    track.push(state);
  }
  void move(LiveTrack& track, double x) {
    state.distance_m += std::abs(x - state.position.x());
    state.position.x() = x;
    track.push(state);
  }
  /// A node that has no place yet.
  void node(LiveTrack& track) {
    ++state.n_nodes;
    state.placed = true;
    track.push(state);
  }
};

std::vector<float> column(const LiveTrack& track, int k) {
  std::vector<float> values;
  for (std::size_t i = 0; i < track.n_points(); ++i)
    values.push_back(track.values()[i * LiveTrack::kColumns + k]);
  return values;
}

TEST(LiveTrack, HasThePointsOfCurvesAndMarksNewNodes) {
  LiveTrack track;
  Hand hand;
  track.push(hand.state);
  EXPECT_EQ(track.n_points(), 0U) << "nothing is drawn";
  hand.begin(track);
  hand.node(track);
  hand.move(track, 1);
  track.push(hand.state);  // at rest: no point
  hand.move(track, 2);
  hand.node(track);
  hand.state.drawing = false;
  hand.move(track, 9);  // carried to the next curve
  hand.begin(track);
  EXPECT_EQ(column(track, 0), (std::vector<float>{1, 1, 1, 1, 1, 2}));
  EXPECT_EQ(column(track, 1), (std::vector<float>{0, 0, 1, 2, 2, 0}));
  EXPECT_EQ(column(track, 4), (std::vector<float>{0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(track.version(), 0) << "what was there stays";
}

TEST(LiveTrack, MovesACurveToTheKnownNodeThatItMeets) {
  LiveTrack track;
  Hand hand;
  hand.begin(track);
  hand.node(track);
  hand.move(track, 1);
  hand.begin(track);
  hand.move(track, 0.5);
  hand.state.position = {10, 5, 0};  // the preview puts the device to the node
  hand.state.placed = true;
  track.push(hand.state);
  hand.move(track, 11);
  EXPECT_EQ(column(track, 1), (std::vector<float>{0, 0, 1, 9.5, 10, 11}));
  EXPECT_EQ(column(track, 2), (std::vector<float>{0, 0, 0, 5, 5, 5}));
  EXPECT_EQ(track.version(), 1) << "windows need all anew";
}

TEST(LiveTrack, ForgetsACurveThatIsForgotten) {
  LiveTrack track;
  Hand hand;
  hand.begin(track);
  hand.move(track, 1);
  hand.begin(track);
  hand.move(track, 2);
  --hand.state.n_curves;
  hand.state.drawing = false;
  track.push(hand.state);
  EXPECT_EQ(column(track, 1), (std::vector<float>{0, 1}));
  EXPECT_EQ(track.version(), 1);
  hand.begin(track);
  hand.move(track, 3);
  // Forgotten, and the next one begun before the preview told anything.
  hand.state.distance_m = 0;
  hand.state.position.setZero();
  track.push(hand.state);
  EXPECT_EQ(column(track, 1), (std::vector<float>{0, 1, 0}));
}

TEST(LiveTrack, IsBoundedHoweverLongACaptureLasts) {
  LiveTrack track(1000);
  Hand hand;
  std::size_t most = 0;
  for (int curve = 0; curve < 20; ++curve) {
    hand.begin(track);
    hand.node(track);
    for (int i = 1; i <= 3000; ++i) {
      hand.move(track, 0.001 * i);
      most = std::max(most, track.n_points());
    }
    hand.node(track);
    hand.state.drawing = false;
    track.push(hand.state);
  }
  EXPECT_LE(most, 1001U);
  EXPECT_GT(track.n_points(), 400U);
  // Every curve has its ends and its nodes still, and points between them.
  std::vector<int> n_nodes(21), n_points(21);
  std::vector<float> last(21);
  for (std::size_t i = 0; i < track.n_points(); ++i) {
    const float* point = &track.values()[i * LiveTrack::kColumns];
    const auto curve = static_cast<std::size_t>(point[0]);
    if (n_points[curve]++ == 0) {
      EXPECT_EQ(point[1], 0) << curve;
    }
    n_nodes[curve] += static_cast<int>(point[4]);
    last[curve] = point[1];
  }
  for (std::size_t curve = 1; curve <= 20; ++curve) {
    EXPECT_EQ(n_nodes[curve], 2) << curve;
    EXPECT_GT(n_points[curve], 10) << curve;
    EXPECT_FLOAT_EQ(last[curve], 3) << curve;
  }
}

TEST(LiveTrack, IsBoundedWhereAllPointsAreNodes) {
  LiveTrack track(100);
  Hand hand;
  hand.begin(track);
  for (int i = 0; i < 1000; ++i) hand.node(track);
  EXPECT_LE(track.n_points(), 101U);
}

}  // namespace
}  // namespace batten::test
