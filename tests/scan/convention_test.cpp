#include "batten/scan/convention.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace batten {
namespace {

constexpr double kRadius = 2, kTurn = 0.05;  // radians per step
constexpr int kReadings = 41;

/// An arc of a circle with radial normals; tangents at the readings, or along the chords to the next one with
/// the lengths of chords as distances.
Scan arc_of_circle(bool chords) {
  ScanCurve curve;
  curve.distances.resize(kReadings);
  curve.tangents.resize(kReadings, 3);
  curve.normals.resize(kReadings, 3);
  for (int i = 0; i < kReadings; ++i) {
    const double phi = kTurn * i, along = chords ? phi + kTurn / 2 : phi;
    curve.normals.row(i) << std::cos(phi), std::sin(phi), 0;
    curve.tangents.row(i) << -std::sin(along), std::cos(along), 0;
    curve.distances[i] = i * (chords ? 2 * kRadius * std::sin(kTurn / 2) : kRadius * kTurn);
  }
  Scan scan;
  scan.curves.push_back(curve);
  return scan;
}

// A chord of a circle stands at right angles to the mean of the normals at its ends, and not to either.
TEST(TangentConvention, IsToldByTheAngleBetweenTangentsAndNormals) {
  const ConventionReport chords = tangent_convention(arc_of_circle(true));
  EXPECT_EQ(chords.convention, TangentConvention::ToNext);
  EXPECT_FALSE(chords.uncertain);
  EXPECT_EQ(chords.forward_misfit, -1) << "an open curve has no loop to measure";
  const ConventionReport frames = tangent_convention(arc_of_circle(false));
  EXPECT_EQ(frames.convention, TangentConvention::AtSample);
  EXPECT_FALSE(frames.uncertain);
  // Halfway between both neither fits better: frames at the readings, and the doubt is told.
  Scan between = arc_of_circle(false);
  for (int i = 0; i < kReadings; ++i) {
    const double along = kTurn * i + kTurn / 4;
    between.curves[0].tangents.row(i) << -std::sin(along), std::cos(along), 0;
  }
  const ConventionReport neither = tangent_convention(between);
  EXPECT_EQ(neither.convention, TangentConvention::AtSample);
  EXPECT_TRUE(neither.uncertain);
}

TEST(TangentConvention, TakesWhatTheScanStates) {
  for (const bool chords : {false, true})
    for (const TangentConvention stated : {TangentConvention::ToNext, TangentConvention::AtSample}) {
      Scan scan = arc_of_circle(chords);
      scan.tangents = stated;
      EXPECT_EQ(tangent_convention(scan).convention, stated);
    }
}

// On a circle the chords before and behind a reading lie evenly about its tangent, and the arc is the chord
// times (θ/2)/sin(θ/2): exact inside; at the two ends the tangents are extrapolated, to second order.
TEST(FramesAtSamples, AreExactOnACircle) {
  const Scan found = frames_at_samples(arc_of_circle(true)), truth = arc_of_circle(false);
  EXPECT_EQ(found.tangents, TangentConvention::AtSample);
  const ScanCurve &a = found.curves[0], &b = truth.curves[0];
  for (int i = 0; i < kReadings; ++i) {
    const bool at_end = i == 0 || i == kReadings - 1;
    EXPECT_LT((a.tangents.row(i) - b.tangents.row(i)).norm(), at_end ? kTurn * kTurn : 1e-12) << i;
    EXPECT_EQ(a.normals.row(i), b.normals.row(i));
    if (i > 1 && !at_end) {
      EXPECT_NEAR(a.distances[i] - a.distances[i - 1], kRadius * kTurn, 1e-12) << i;
    }
  }
}

// Readings at one distance, where the device rests, share a tangent.
TEST(FramesAtSamples, GivesReadingsAtOnePlaceOneTangent) {
  Scan scan = arc_of_circle(true);
  ScanCurve& curve = scan.curves[0];
  for (int i = 20; i < kReadings; ++i) curve.distances[i] -= curve.distances[20] - curve.distances[19];
  const Scan found = frames_at_samples(scan);
  EXPECT_EQ(found.curves[0].distances[19], found.curves[0].distances[20]);
  EXPECT_EQ(found.curves[0].tangents.row(19), found.curves[0].tangents.row(20));
  EXPECT_LT(found.curves[0].distances[18], found.curves[0].distances[19]);
}

}  // namespace
}  // namespace batten
