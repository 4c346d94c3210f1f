#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/remeshing/fit_ring_detail.hpp"

namespace batten::remeshing {
namespace {

using Eigen::Vector3d;

/// Six equilateral triangles of side 1 around the origin, counter-clockwise in the plane z = 0.
struct Hexagon {
  Points positions = Points::Zero(7, 3);
  Triangles triangles = Triangles(6, 3);
  Hexagon() {
    for (int k = 0; k < 6; ++k) {
      positions.row(k + 1) << std::cos(k * kPi / 3), std::sin(k * kPi / 3), 0;
      triangles.row(k) << 0, k + 1, (k + 1) % 6 + 1;
    }
  }
};

/// The samples of a reference that is the mesh itself: the centre of every triangle.
ReferenceSamples centres(const Hexagon& hexagon) {
  ReferenceSamples samples;
  for (int f = 0; f < 6; ++f) {
    Vector3d centre = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) centre += hexagon.positions.row(hexagon.triangles(f, k)).transpose() / 3;
    samples.points.push_back({centre, f});
    samples.nearest.push_back(f);
    samples.pieces.push_back({Vector3d::UnitZ(), std::sqrt(3) / 4});
  }
  return samples;
}

/// The ring of the middle vertex.
struct HexagonRing {
  Hexagon hexagon;
  HalfedgeMesh mesh{hexagon.positions, hexagon.triangles};
  FitSamples samples;
  FitRing ring;
  explicit HexagonRing(bool turned_reference = false) {
    ReferenceSamples reference = centres(hexagon);
    if (turned_reference) reference.pieces[2].normal = -Vector3d::UnitZ();
    samples.take(std::move(reference), mesh, mesh.compacted(), {0, 1, 2, 3, 4, 5}, {});
    ring.gather(mesh, samples, 0);
  }
};

TEST(FitRing, GathersTheTrianglesAndSamplesOfAVertex) {
  const HexagonRing given;
  EXPECT_EQ(given.ring.spokes.size(), 6u);
  EXPECT_EQ(given.ring.entries.size(), 6u);
  EXPECT_NEAR(given.ring.area, 6 * std::sqrt(3) / 4, 1e-15);
  EXPECT_FALSE(given.ring.has_sectors);
  EXPECT_NEAR(given.ring.least_sine(Vector3d::Zero()), std::sin(kPi / 3), 1e-15);
  // What looks the other way lies behind an edge, and is nobody's.
  EXPECT_EQ(HexagonRing(true).ring.entries.size(), 5u);
}

// In the plane of the reference the fit costs nothing, and equilateral triangles have no cost of shape.
// Lifted by h, all six normals lean by the same angle: tan a = h / (√3 / 2), and |n − z| = 2 sin(a / 2).
TEST(FitRing, CostsTheAnglesToTheReference) {
  HexagonRing given;
  const FitWeights weights{0, 0};
  EXPECT_NEAR(given.ring.cost(Vector3d::Zero(), 1, 0, 1e9, {1, 1}), 0, 1e-12);
  for (const double h : {0.1, -0.3}) {
    const double a = std::atan(std::abs(h) / (std::sqrt(3) / 2));
    EXPECT_NEAR(given.ring.cost({0, 0, h}, 1, 0, 1e9, weights), given.ring.area * 2 * std::sin(a / 2), 1e-12);
  }
  // The distance of the reference from the leaning planes, in lengths.
  const double h = 0.1, a = std::atan(h / (std::sqrt(3) / 2));
  const double distance = std::cos(a) * h / 3;  // a centre has a third of the height of the vertex over it
  const double plain = given.ring.cost({0, 0, h}, 2, 0, 1e9, weights);
  EXPECT_NEAR(given.ring.cost({0, 0, h}, 2, 0, 1e9, {0, 5}) - plain, given.ring.area * 5 * distance / 2,
              1e-12);
}

TEST(FitRing, RefusesBadTrianglesAndWhatCostsTooMuch) {
  HexagonRing given;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const FitWeights weights{1, 1};
  EXPECT_EQ(given.ring.cost({1, 0, 0}, 1, 0, 1e9, weights), kInfinity);  // no area
  EXPECT_EQ(given.ring.cost({2, 0, 0}, 1, 0, 1e9, weights), kInfinity);  // turned over
  EXPECT_EQ(given.ring.cost({0, 0, 2}, 1, 0, 1e9, weights), kInfinity);  // by more than 60°
  const double cost = given.ring.cost({0.2, 0, 0}, 1, 0, 1e9, weights);
  EXPECT_GT(cost, 0);
  EXPECT_EQ(given.ring.cost({0.2, 0, 0}, 1, std::sin(kPi / 3) + 1e-9, 1e9, weights), kInfinity);
  EXPECT_EQ(given.ring.cost({0.2, 0, 0}, 1, 0, 0.9 * given.ring.shape, weights), kInfinity);
}

// Moved by half a side, the vertex passes the middle of a triangle: its sample comes onto another.
TEST(FitRing, SamplesGoToTheTriangleThatHoldsThem) {
  HexagonRing given;
  const Vector3d x(-0.45, 0.35, 0);
  given.ring.cost(x, 1, 0, 1e9, {0, 0});
  int n_moved = 0;
  for (const FitRing::Entry& entry : given.ring.entries) {
    const std::size_t k = given.ring.spoke_of(entry, entry.sample.point - x);
    const Vector3d b = given.ring.spokes[k].b - x, c = given.ring.spokes[k].c - x, p = entry.sample.point - x;
    EXPECT_GE(cross(b, p).z(), -1e-12) << entry.number;
    EXPECT_GE(cross(p, c).z(), -1e-12) << entry.number;
    n_moved += static_cast<int>(k) != entry.spoke ? 1 : 0;
  }
  EXPECT_GT(n_moved, 0);
}

TEST(NearestPlaces, KeepsTheNearestWithoutRepeats) {
  NearestPlaces<2> places;
  const auto offer = [&](double squared, int number) {
    places.offer({squared, number, Vector3d::Constant(number)});
  };
  offer(3, 1);
  offer(2, 2);
  offer(3, 1);
  EXPECT_EQ(places.size, 2);
  offer(1, 3);
  offer(1 * (1 + 1e-12), 3);  // the same up to rounding
  offer(5, 4);
  ASSERT_EQ(places.size, 2);
  EXPECT_EQ(places.places[0].number, 3);
  EXPECT_EQ(places.places[1].number, 2);
  offer(1, 2);  // as near as the first: the lower number goes before
  EXPECT_EQ(places.places[0].number, 2);
  EXPECT_EQ(places.places[1].number, 3);
}

// Two triangles over the unit square, folded by 40° along their diagonal.
TEST(CreaseCorners, AreThoseOfEdgesThatTurnByMore) {
  Points X(4, 3);
  X << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  const double angle = radians(40.0), h = std::sqrt(0.5);
  // The corner off the diagonal is turned about it out of the plane.
  X.row(3) << 0.5 - 0.5 * std::cos(angle), 0.5 + 0.5 * std::cos(angle), h * std::sin(angle);
  Triangles T(2, 3);
  T << 0, 1, 2, 0, 2, 3;
  using Marks = std::vector<std::array<char, 3>>;
  EXPECT_EQ(crease_corners(X, T, radians(39.9)), (Marks{{0, 0, 1}, {1, 0, 0}}));
  EXPECT_EQ(crease_corners(X, T, radians(40.1)), (Marks{{0, 0, 0}, {0, 0, 0}}));
}

}  // namespace
}  // namespace batten::remeshing
