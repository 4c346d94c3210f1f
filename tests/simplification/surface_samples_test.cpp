#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "batten/simplification/surface_fit_detail.hpp"

namespace batten {
namespace {

using simplification::sample_surface;
using simplification::SurfaceSample;

/// Two triangles of area 2 each in z = 0, and with `lift` the corner (2, 2) raised.
Points square(double lift = 0) {
  Points points(4, 3);
  points << 0, 0, 0, 2, 0, 0, 2, 2, lift, 0, 2, 0;
  return points;
}
Triangles halves() {
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 0, 2, 3;
  return triangles;
}

double total_area(const std::vector<SurfaceSample>& samples) {
  double sum = 0;
  for (const SurfaceSample& sample : samples) sum += sample.area;
  return sum;
}

// Every face is cut into m² equal parts, the smallest m with parts of at most area / n: 4 / 20 = 0.2, faces
// of 2, so m = 4. Their centres weighted by their areas have the centroid of the square and its second
// moments to the accuracy of the parts.
TEST(SampleSurface, StandsForEqualPartsOfTheArea) {
  const std::vector<SurfaceSample> samples = sample_surface(square(), halves(), 20);
  ASSERT_EQ(samples.size(), 32U) << "flat: no vertex is watched over";
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const SurfaceSample& sample : samples) {
    EXPECT_DOUBLE_EQ(sample.area, 2.0 / 16);
    EXPECT_EQ(sample.normal, Eigen::Vector3f(0, 0, 1));
    centroid += sample.area * sample.point / 4;
    const bool lower = sample.point.y() < sample.point.x();
    EXPECT_EQ(sample.face, lower ? 0 : 1);
  }
  EXPECT_LT((centroid - Eigen::Vector3d(1, 1, 0)).norm(), 1e-12);
}

// Faces smaller than the share of a sample get one in turn: every so many together make up the share.
TEST(SampleSurface, SmallFacesShareSamples) {
  constexpr int kStrip = 200;
  Points points(2 * kStrip + 2, 3);
  Triangles triangles(2 * kStrip, 3);
  for (int i = 0; i <= kStrip; ++i) {
    points.row(2 * i) << i, 0, 0;
    points.row(2 * i + 1) << i, 1, 0;
  }
  for (int i = 0; i < kStrip; ++i) {
    triangles.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    triangles.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  const std::vector<SurfaceSample> samples = sample_surface(points, triangles, 50);
  EXPECT_EQ(samples.size(), 50U);
  EXPECT_NEAR(total_area(samples), kStrip, 1e-9);
}

// Where the surface bends, vertices are samples too, with a thousandth of a share.
TEST(SampleSurface, BentVerticesAreWatchedOver) {
  const std::vector<SurfaceSample> samples = sample_surface(square(1), halves(), 20);
  const auto is_vertex = [](const SurfaceSample& sample) {
    return sample.point == Eigen::Vector3d(2, 2, 1) || sample.point == Eigen::Vector3d(0, 0, 0);
  };
  EXPECT_EQ(std::count_if(samples.begin(), samples.end(), is_vertex), 2) << "the ends of the folded edge";
  double area = 0;
  for (const SurfaceSample& sample : samples) area += is_vertex(sample) ? 0 : sample.area;
  EXPECT_NEAR(area, 2 * std::sqrt(5.0), 1e-9);
  const auto vertex = std::find_if(samples.begin(), samples.end(), is_vertex);
  EXPECT_NEAR(vertex->area, 1e-3 * area / 20, 1e-12);
}

TEST(SampleSurface, NothingComesOfNothing) {
  EXPECT_TRUE(sample_surface(Points(0, 3), Triangles(0, 3), 10).empty());
  EXPECT_TRUE(sample_surface(Points::Zero(3, 3), (Triangles(1, 3) << 0, 1, 2).finished(), 10).empty());
}

}  // namespace
}  // namespace batten
