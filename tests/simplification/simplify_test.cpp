#include "batten/simplification/simplify.hpp"

#include "mesh/shapes.hpp"
#include "mesh/tiles.hpp"
#include "remeshing/cad_parts.hpp"
#include "report_gaps.hpp"
#include "threads.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>
#include <ostream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// The unit cube, every side a grid of n × n cells, without seams.
TriangleMesh cube(int n) {
  TriangleMesh mesh;
  std::vector<Vector3d> points;
  std::vector<int> number((n + 1) * (n + 1) * (n + 1), -1);
  const auto vertex = [&](int i, int j, int k) {
    int& v = number[(i * (n + 1) + j) * (n + 1) + k];
    if (v < 0) {
      v = static_cast<int>(points.size());
      points.emplace_back(i / double(n), j / double(n), k / double(n));
    }
    return v;
  };
  std::vector<Eigen::Vector3i> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
          const auto corner = [&](int u, int v) {
            int c[3];
            c[axis] = side;
            c[(axis + 1) % 3] = a + u;
            c[(axis + 2) % 3] = b + v;
            return vertex(c[0], c[1], c[2]);
          };
          int q[4] = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          faces.emplace_back(q[0], q[1], q[2]);
          faces.emplace_back(q[0], q[2], q[3]);
        }
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    mesh.positions.row(static_cast<Eigen::Index>(v)) = points[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) mesh.triangles.row(static_cast<Eigen::Index>(f)) = faces[f];
  return mesh;
}

TriangleMesh torus(int n, double scale = 1) {
  return fixtures::as_mesh(fixtures::grid(2 * n, n, true, true, [scale](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.7 * std::cos(b);
    return Vector3d(scale * r * std::cos(a), scale * r * std::sin(a), scale * 0.7 * std::sin(b));
  }));
}

double volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Vector3d a = mesh.positions.row(mesh.triangles(f, 0)), b = mesh.positions.row(mesh.triangles(f, 1)),
                   c = mesh.positions.row(mesh.triangles(f, 2));
    sum += a.dot(b.cross(c)) / 6;
  }
  return sum;
}

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
    const Vector3d a = mesh.positions.row(mesh.triangles(f, 0)), b = mesh.positions.row(mesh.triangles(f, 1)),
                   c = mesh.positions.row(mesh.triangles(f, 2));
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

int euler(const TriangleMesh& mesh) {
  const HalfedgeMesh halfedges(mesh.positions, mesh.triangles);
  int n_edges = 0;
  for (int h = 0; h < halfedges.halfedge_capacity(); ++h) n_edges += halfedges.is_representative(h) ? 1 : 0;
  return halfedges.n_vertices() - n_edges + halfedges.n_faces();
}

Comparison compared(const TriangleMesh& a, const TriangleMesh& b) {
  CompareOptions options;
  options.samples = 50000;
  return compare({a.positions, a.triangles, {}}, {b.positions, b.triangles, {}}, options);
}

SimplifyResult with_faces(const TriangleMesh& mesh, Eigen::Index faces) {
  SimplifyOptions options;
  options.faces = faces;
  return simplify(mesh, options);
}

/// What every result must be: as many faces as asked for, a manifold of the same topology, no face without
/// area, no self-intersection.
void expect_sound(const TriangleMesh& input, const SimplifyResult& result, Eigen::Index faces) {
  EXPECT_LE(result.mesh.n_triangles(), faces);
  EXPECT_GE(result.mesh.n_triangles(), faces - 2);
  EXPECT_EQ(euler(result.mesh), euler(input));
  EXPECT_TRUE(degenerate_triangles(result.mesh.positions, result.mesh.triangles, 1e-6).empty());
  EXPECT_TRUE(self_intersections(result.mesh.positions, result.mesh.triangles).empty());
}

// Twelve triangles are enough for a cube, and the planes leave no other place for its corners.
TEST(Simplify, ACubeOfManyFacesBecomesTwelveTrianglesExactly) {
  const TriangleMesh input = cube(12);
  ASSERT_NEAR(volume(input), 1, 1e-12);
  const SimplifyResult result = with_faces(input, 12);
  expect_sound(input, result, 12);
  EXPECT_EQ(result.mesh.n_vertices(), 8);
  // The pull that decides in flat places moves a corner by a millionth of an edge.
  EXPECT_NEAR(volume(result.mesh), 1, 1e-4);
  EXPECT_NEAR(area(result.mesh), 6, 1e-4);
  EXPECT_LT(result.max_error, 1e-4);
}

// Piecewise linear approximation of a smooth surface with n triangles errs by O(1/n): four times fewer faces,
// four times the error.
TEST(Simplify, ErrorOnATorusIsInverselyProportionalToTheFaces) {
  const TriangleMesh input = torus(56);
  const double fine = compared(input, with_faces(input, 3200).mesh).a_to_b.samples.rms;
  const double coarse = compared(input, with_faces(input, 800).mesh).a_to_b.samples.rms;
  EXPECT_NEAR(std::log(coarse / fine) / std::log(4.0), 1.0, 0.25);
}

TEST(Simplify, ATorusStaysATorusWithGoodTrianglesAndItsVolume) {
  const TriangleMesh input = torus(60);
  const SimplifyResult result = with_faces(input, 1000);
  expect_sound(input, result, 1000);
  EXPECT_TRUE(result.reached);
  EXPECT_NEAR(volume(result.mesh) / volume(input), 1, 1e-3);
  const MeshQuality quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
  EXPECT_GT(degrees(quality.mean_min_angle), 36);
  const Comparison comparison = compared(input, result.mesh);
  // Both directions, so that nothing sticks out of the result either.
  EXPECT_LT(comparison.b_to_a.samples.max, 2.5 * comparison.a_to_b.samples.max);
  EXPECT_NEAR(result.rms_error / comparison.a_to_b.samples.rms, 1, 0.1);
}

// The same mesh in another place, size and unit gives the same picture.
TEST(Simplify, ScalesWithTheMesh) {
  const double reference = with_faces(torus(40), 400).rms_error;
  for (const double scale : {1e-3, 1e3}) {
    const SimplifyResult result = with_faces(torus(40, scale), 400);
    expect_sound(torus(40, scale), result, 400);
    EXPECT_NEAR(result.rms_error / (scale * reference), 1, 0.15);
  }
}

TEST(Simplify, IsDeterministic) {
  const TriangleMesh input = torus(30);
  const SimplifyResult a = with_faces(input, 300), b = with_faces(input, 300);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
}

// A flat square keeps its outline exactly: the border runs along straight lines.
TEST(Simplify, AFlatSquareKeepsItsBorder) {
  const TriangleMesh input = fixtures::as_mesh(
      fixtures::grid(30, 30, false, false, [](double u, double v) { return Vector3d(u, v, 0); }));
  const SimplifyResult result = with_faces(input, 40);
  expect_sound(input, result, 40);
  EXPECT_NEAR(area(result.mesh), 1, 1e-4);
  EXPECT_NEAR(result.mesh.positions.col(0).minCoeff(), 0, 1e-4);
  EXPECT_NEAR(result.mesh.positions.col(1).maxCoeff(), 1, 1e-4);
}

// Tiles of one torus that know nothing of each other: joined again they are a torus without cracks, with
// every border edge where it was. The cut is jagged, so that borders bend in all directions. Kept edges and
// the thesis' method hold the border just so.
TEST(Simplify, TilesWithHeldBordersJoinWithoutCracks) {
  const TriangleMesh whole = torus(32);
  SimplifyOptions options;
  options.remove = 0.8;
  options.hold_border = true;
  for (const int kind : {0, 1, 2}) {
    options.keep_edges = kind == 1 ? radians(25.0) : 0;
    options.method = kind == 2 ? SimplifyMethod::PLaplacian : SimplifyMethod::Quadric;
    TriangleMesh halves[2];
    for (const bool upper : {false, true}) {
      const TriangleMesh half = fixtures::half_at_x0(whole, upper);
      halves[upper ? 1 : 0] = simplify(half, options).mesh;
      EXPECT_EQ(fixtures::border_places(halves[upper ? 1 : 0]), fixtures::border_places(half));
      EXPECT_LT(halves[upper ? 1 : 0].n_triangles(), half.n_triangles() / 2);
    }
    const TriangleMesh joined = fixtures::joined(halves[0], halves[1]);
    EXPECT_TRUE(fixtures::border_places(joined).empty());
    EXPECT_EQ(joined.n_vertices() * 2, joined.n_triangles());  // χ = 0
  }
}

// Two parallel plates nearer to each other than their triangles are wide: the trap for collapses that look at
// their own faces only. A wavy thin shell, closed at the rim.
TEST(Simplify, SheetsThatLieCloseTogetherDoNotTouch) {
  const TriangleMesh input = fixtures::as_mesh(fixtures::sphere(20));
  TriangleMesh shell = input;
  for (Eigen::Index v = 0; v < shell.n_vertices(); ++v) {
    const Vector3d p = input.positions.row(v);
    shell.positions(v, 2) = 0.004 * p.z() + 0.15 * std::sin(4 * p.x()) * std::cos(3 * p.y());
  }
  for (const Eigen::Index faces : {1500, 600, 200}) {
    const SimplifyResult result = with_faces(shell, faces);
    EXPECT_TRUE(self_intersections(result.mesh.positions, result.mesh.triangles).empty()) << faces;
    EXPECT_TRUE(result.reached || !result.warnings.empty());
  }
}

// Two tori pushed through each other, in one mesh. They cross along closed curves before and after: each pair
// of faces that cross counts once along such a curve, so that there are fewer of them with fewer, larger
// faces. What lies around is simplified as if the other were not there.
TEST(Simplify, InputThatCrossesItselfIsSimplifiedAllTheSame) {
  const TriangleMesh one = torus(24);
  TriangleMesh both;
  both.positions.resize(2 * one.n_vertices(), 3);
  both.triangles.resize(2 * one.n_triangles(), 3);
  both.positions << one.positions, one.positions.rowwise() + Eigen::RowVector3d(1.53, 0.31, 0.27);
  both.triangles << one.triangles, (one.triangles.array() + static_cast<int>(one.n_vertices())).matrix();
  const std::size_t before = self_intersections(both.positions, both.triangles).size();
  ASSERT_GT(before, 100U);
  const SimplifyResult result = with_faces(both, 500);
  EXPECT_TRUE(result.reached);
  EXPECT_LT(self_intersections(result.mesh.positions, result.mesh.triangles).size(), before);
  const SimplifyResult alone = with_faces(one, 250);
  EXPECT_LT(compared(both, result.mesh).a_to_b.samples.rms,
            1.2 * compared(one, alone.mesh).a_to_b.samples.rms);
}

TEST(Simplify, StaysWithinAnErrorInBothDirections) {
  const TriangleMesh input = torus(24);
  SimplifyOptions options;
  options.max_error = 0.1;
  const SimplifyResult result = simplify(input, options);
  const Comparison comparison = compared(input, result.mesh);
  EXPECT_LT(comparison.a_to_b.vertices.max, 0.1 * (1 + 1e-9));
  EXPECT_LT(std::max(comparison.a_to_b.samples.max, comparison.b_to_a.samples.max), 0.105);
  // Not by keeping everything: half the faces would be allowed about twice the error.
  EXPECT_LT(result.mesh.n_triangles(), input.n_triangles() / 2);
  EXPECT_GT(result.max_error, 0.05);
}

// Sharp edges of a block under a cut so deep that the error alone would round them off.
TEST(Simplify, KeptEdgesStayWhereTheyAre) {
  const TriangleMesh input = cube(10);
  SimplifyOptions options;
  options.faces = 60;
  options.keep_edges = radians(30);
  const SimplifyResult result = simplify(input, options);
  expect_sound(input, result, 60);
  EXPECT_NEAR(volume(result.mesh), 1, 1e-6);
  EXPECT_NEAR(area(result.mesh), 6, 1e-6);
}

// Shares by hand for three levels: (6, 4, 2)/12. H (2.99)
TEST(Simplify, SharesOfTheLevelsAreThoseOfTheFormula) {
  EXPECT_EQ(faces_per_level(1200, 0, 3), (std::vector<Eigen::Index>{600, 200, 0}));
  EXPECT_EQ(faces_per_level(1000, 100, 1), (std::vector<Eigen::Index>{100}));
  for (const int levels : {2, 4, 7}) {
    const auto faces = faces_per_level(100000, 1000, levels);
    EXPECT_EQ(faces.size(), static_cast<std::size_t>(levels));
    EXPECT_EQ(faces.back(), 1000);
    EXPECT_TRUE(std::is_sorted(faces.rbegin(), faces.rend()));
  }
}

// Every vertex of a level has one that stands for it in the next, near by, and the chain of maps is the whole
// map; the levels are what the history replays, forth and back.
TEST(Simplify, LevelsAndHistoryLeadBackToTheInput) {
  for (const SimplifyMethod method : {SimplifyMethod::Quadric, SimplifyMethod::PLaplacian}) {
    const TriangleMesh input = torus(24);
    SimplifyOptions options;
    options.method = method;
    options.faces = 200;
    options.levels = 3;
    options.keep_levels = options.keep_history = true;
    const SimplifyResult result = simplify(input, options);
    expect_sound(input, result, 200);
    ASSERT_EQ(result.levels.size(), 3U);
    ASSERT_EQ(result.history.level_steps().size(), 3U);
    std::vector<int> chain(input.n_vertices());
    std::iota(chain.begin(), chain.end(), 0);
    SimplificationHistory::Replay replay(result.history);
    const TriangleMesh* finer = &input;
    for (std::size_t level = 0; level < 3; ++level) {
      const SimplifyLevel& kept = result.levels[level];
      ASSERT_EQ(kept.vertex_of_finer.size(), static_cast<std::size_t>(finer->n_vertices()));
      for (int& v : chain) v = kept.vertex_of_finer[v];
      for (const int v : kept.vertex_of_finer) {
        ASSERT_GE(v, 0);
        ASSERT_LT(v, kept.mesh.n_vertices());
      }
      replay.go_to(result.history.level_steps()[level]);
      const TriangleMesh replayed = replay.mesh();
      EXPECT_EQ(replayed.positions, kept.mesh.positions);
      EXPECT_EQ(replayed.triangles, kept.mesh.triangles);
      finer = &kept.mesh;
    }
    EXPECT_EQ(chain, result.vertex_map);
    EXPECT_EQ(result.levels.back().mesh.positions, result.mesh.positions);
    // Refined again step by step, to the exact input.
    replay.go_to_faces(500);
    EXPECT_LE(replay.n_faces(), 500);
    EXPECT_GE(replay.n_faces(), 498);
    EXPECT_EQ(euler(replay.mesh()), 0);
    replay.go_to(0);
    EXPECT_EQ(replay.mesh().positions, input.positions);
    EXPECT_EQ(replay.mesh().triangles, input.triangles);
    EXPECT_THROW(replay.go_to(result.history.n_steps() + 1), InvalidInput);
  }
}

TEST(Simplify, BadOptionsAndMeshesAreRefusedWithTheReason) {
  const TriangleMesh input = torus(8);
  const auto message = [&](const TriangleMesh& mesh, const SimplifyOptions& options) {
    try {
      simplify(mesh, options);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  SimplifyOptions options;
  EXPECT_NE(message(input, options).find("exactly one"), std::string::npos);
  options.faces = 10;
  options.remove = 0.5;
  EXPECT_NE(message(input, options).find("exactly one"), std::string::npos);
  options.faces = 0;
  options.remove = 1.5;
  EXPECT_NE(message(input, options).find("remove"), std::string::npos);
  options.remove = 0.5;
  options.flow.p = 0;
  EXPECT_NE(message(input, options).find("p must"), std::string::npos);
  options.flow.p = 0.1;
  EXPECT_NE(message({}, options).find("no faces"), std::string::npos);
  TriangleMesh twisted = input;
  std::swap(twisted.triangles(5, 0), twisted.triangles(5, 1));
  EXPECT_NE(message(twisted, options).find("edge from vertex"), std::string::npos);
}

// A tetrahedron has no edge to give; the wish is not met, and that is said.
TEST(Simplify, SaysWhenTheTopologyAllowsNoMore) {
  Points positions(4, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  Triangles triangles(4, 3);
  triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  TriangleMesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  const SimplifyResult result = with_faces(mesh, 2);
  EXPECT_EQ(result.mesh.n_triangles(), 4);
  EXPECT_FALSE(result.reached);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("stopped at 4 of 2"), std::string::npos);
}

TEST(Simplify, CanBeCancelled) {
  SimplifyOptions options;
  options.faces = 100;
  EXPECT_THROW(simplify(torus(20), options, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

// Figures of MeshLab 2020.09 (dmax, dmean, dRMS over the diagonal, 200 000 samples of the original; mean
// smallest angle) and of CGAL 5.5.1's Lindstrom-Turk (dRMS), measured on the same files.
struct Case {
  const char* file;
  double removed, dmax, dmean, drms, angle, lindstrom_turk;
};
void PrintTo(const Case& peer, std::ostream* out) {
  *out << peer.file << " without " << 100 * peer.removed << " %";
}
class SimplifyAgainstPeers : public testing::TestWithParam<Case> {};

TEST_P(SimplifyAgainstPeers, IsNearerThanMeshLabAndLindstromTurkWithAnglesAsGood) {
  const Case& peer = GetParam();
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + peer.file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh input = read_mesh(path);
  SimplifyOptions options;
  options.remove = peer.removed;
  const SimplifyResult result = simplify(input, options);
  expect_sound(input, result,
               static_cast<Eigen::Index>((1 - peer.removed) * double(input.n_triangles()) + 1e-6));
  const double diameter = bounding_box_diagonal(input.positions);
  const Comparison comparison = compared(input, result.mesh);
  for (const DirectedComparison* side : {&comparison.a_to_b, &comparison.b_to_a}) {
    EXPECT_LT(side->samples.mean / diameter, peer.dmean);
    EXPECT_LT(side->samples.rms / diameter, peer.drms);
  }
  EXPECT_LT(comparison.a_to_b.samples.max / diameter, peer.dmax);
  EXPECT_LT(comparison.a_to_b.samples.rms / diameter, peer.lindstrom_turk);
  const MeshQuality quality = mesh_quality(result.mesh.positions, result.mesh.triangles);
  EXPECT_GT(degrees(quality.mean_min_angle), peer.angle - 1);
}

#ifdef BATTEN_SANITIZED  // the same code runs for every mesh; what the figures are, the release suite
                         // tells
INSTANTIATE_TEST_SUITE_P(Meshes, SimplifyAgainstPeers,
                         testing::Values(Case{"fandisk.obj", 0.95, 1.87e-3, 6.83e-5, 1.39e-4, 22.1,
                                              9.85e-5}));
#else
INSTANTIATE_TEST_SUITE_P(
    Meshes, SimplifyAgainstPeers,
    testing::Values(Case{"fandisk.obj", 0.80, 1.70e-4, 4.99e-6, 1.14e-5, 26.9, 7.94e-6},
                    Case{"fandisk.obj", 0.95, 1.87e-3, 6.83e-5, 1.39e-4, 22.1, 9.85e-5},
                    Case{"fandisk.obj", 0.99, 1.16e-2, 9.59e-4, 1.77e-3, 26.9, 1.45e-3},
                    Case{"rocker-arm.obj", 0.90, 7.65e-3, 3.36e-4, 5.26e-4, 33.0, 3.17e-4},
                    Case{"rocker-arm.obj", 0.95, 8.82e-3, 6.17e-4, 9.37e-4, 31.7, 5.34e-4},
                    Case{"rocker-arm.obj", 0.97, 1.33e-2, 9.54e-4, 1.44e-3, 32.0, 8.19e-4}));
#endif

// A mesh of 100,000 vertices takes some 3 s, one of 10,000 a tenth of that, in the same shares.
TEST(Simplify, ReportsOftenAndStopsWhereItIsTold) {
  const TriangleMesh input = cube(40);
  SimplifyOptions options;
  options.remove = 0.8;
  const test::Threads one_thread(1);  // all the work is on the thread whose time is measured
  const test::ReportGaps gaps([&](const Progress& progress) { simplify(input, options, progress); });
  EXPECT_LT(gaps.largest_share(), 0.15) << "before " << gaps.before();
  EXPECT_GT(gaps.reports(), 50);
  for (const int stop_at : {1, 10, gaps.reports() / 2, gaps.reports()}) {
    int reports = 0;
    const Progress stop([&](std::string_view, double) { return ++reports < stop_at; });
    EXPECT_THROW(simplify(input, options, stop), Cancelled) << stop_at;
  }
}

TEST(Simplify, GivesTheSameBitsOnAnyNumberOfThreads) {
  const TriangleMesh input = cube(30);
  SimplifyOptions options;
  options.remove = 0.8;
  const auto simplified = [&](int threads) {
    const test::Threads here(threads);
    return simplify(input, options);
  };
  const SimplifyResult one = simplified(1);
  for (const int threads : {2, 3}) {
    const SimplifyResult other = simplified(threads);
    EXPECT_EQ(other.mesh.positions, one.mesh.positions) << threads;
    EXPECT_EQ(other.mesh.triangles, one.mesh.triangles) << threads;
    EXPECT_EQ(other.rms_error, one.rms_error) << threads;
  }
}

// Rods as CAD programs export them are needles throughout: their facets are joined, within the height of an
// arc over twice a facet, and nothing stops for the shape of the triangles.
TEST(Simplify, TakesFacesOffRodsOfNeedles) {
  for (const int sides : {32, 64}) {
    const TriangleMesh rod = fixtures::rod(sides, 1, 10);
    SimplifyOptions options;
    options.remove = 0.5;
    const SimplifyResult result = simplify(rod, options);
    EXPECT_TRUE(result.reached);
    EXPECT_LE(result.mesh.n_triangles(), rod.n_triangles() / 2);
    EXPECT_LT(result.max_error, 2 * (1 - std::cos(2 * kPi / sides)));
    EXPECT_TRUE(self_intersections(result.mesh.positions, result.mesh.triangles, 1).empty());
  }
}

}  // namespace
}  // namespace batten
