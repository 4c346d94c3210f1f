#include "batten/mesh/mending.hpp"

#include "mesh/broken_shapes.hpp"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/quality.hpp"

namespace batten {
namespace {

using fixtures::band;
using fixtures::beside;
using fixtures::box;
using fixtures::glued;
using fixtures::soup_of;
using fixtures::turned_at_random;
using fixtures::with_triangles;

/// What every result promises.
void expect_sound(const TriangleMesh& mesh, const std::string& what) {
  const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
  EXPECT_TRUE(topology.problems.empty()) << what << ": " << topology.problems[0];
  EXPECT_EQ(topology.n_unused_vertices, 0) << what;
  EXPECT_TRUE(degenerate_triangles(mesh.positions, mesh.triangles).empty()) << what;
}

void expect_closed(const TriangleMesh& mesh, double volume, const std::string& what) {
  expect_sound(mesh, what);
  EXPECT_EQ(mesh_topology(mesh.triangles, mesh.n_vertices()).n_boundary_edges, 0) << what;
  EXPECT_NEAR(enclosed_volume(mesh.positions, mesh.triangles), volume, 1e-3 * volume) << what;
}

MendedMesh mended(const TriangleMesh& mesh) {
  return mended_mesh(mesh);
}

TEST(MendedMesh, LeavesASoundMeshAsItIs) {
  for (const TriangleMesh& mesh : {box(3), beside(box(2), box(2, {3, 0, 0})), band(12, 0), band(20, 2)}) {
    const MendedMesh result = mended(mesh);
    EXPECT_FALSE(result.report.changed());
    EXPECT_EQ(result.mesh.positions, mesh.positions);
    EXPECT_EQ(result.mesh.triangles, mesh.triangles);
  }
}

TEST(MendedMesh, MakesSoupsOfAnySizeAndOrientationSolid) {
  for (const double size : {1e-9, 1.0, 1e12})
    for (const double jitter : {0.0, 1e-6}) {
      const TriangleMesh soup = soup_of(turned_at_random(box(4, {0, 0, 0}, size)), jitter * size);
      const MendedMesh result = mended(soup);
      expect_closed(result.mesh, size * size * size, concat("size ", size, ", jitter ", jitter));
      EXPECT_EQ(result.mesh.n_vertices(), box(4).n_vertices());
      EXPECT_GT(result.report.turned, 0);
    }
}

TEST(MendedMesh, TurnsClosedPartsOutwardAndCavitiesInward) {
  const TriangleMesh outer = box(3), inner = box(2, {0.25, 0.25, 0.25}, 0.5),
                     core = box(1, {0.4, 0.4, 0.4}, 0.2);
  expect_closed(mended(turned_at_random(beside(outer, inner))).mesh, 1 - 0.125, "cavity");
  expect_closed(mended(turned_at_random(beside(beside(outer, inner), core))).mesh, 1 - 0.125 + 0.008, "core");
  TriangleMesh inside_out = beside(outer, box(2, {3, 0, 0}));
  for (Eigen::Index f = 0; f < outer.n_triangles(); ++f)
    std::swap(inside_out.triangles(f, 1), inside_out.triangles(f, 2));
  const MendedMesh turned = mended(inside_out);
  expect_closed(turned.mesh, 2, "one part inside out");
  EXPECT_EQ(turned.report.turned, outer.n_triangles());
}

// Without a lid, a box still has an outside.
TEST(MendedMesh, TurnsOpenPartsAwayFromTheirMiddle) {
  for (unsigned seed = 1; seed < 9; ++seed) {
    TriangleMesh open = box(3);
    open.triangles.conservativeResize(open.n_triangles() - 18, 3);
    const MendedMesh result = mended(turned_at_random(open, seed));
    expect_sound(result.mesh, "open box");
    for (Eigen::Index f = 0; f < open.n_triangles(); ++f) {
      const Eigen::RowVector3d n = face_normals(open.positions, open.triangles).row(f);
      ASSERT_GT(face_normals(result.mesh.positions, result.mesh.triangles).row(f).dot(n), 0.99) << seed;
    }
  }
}

// A body in a body may be meant; it becomes a cavity when that is asked for.
TEST(MendedMesh, TurnsAgreeingPartsWithinOthersOnDemand) {
  const TriangleMesh both = beside(box(3), box(2, {0.25, 0.25, 0.25}, 0.5));
  const MendedMesh kept = mended(both);
  EXPECT_EQ(kept.mesh.triangles, both.triangles);
  EXPECT_EQ(kept.report.nested, 1);
  MendingOptions options;
  options.orient = true;
  expect_closed(mended_mesh(both, options).mesh, 1 - 0.125, "cavity");
}

TEST(MendedMesh, LeavesOutRepeatedDegenerateAndDoubledTriangles) {
  const TriangleMesh cube = box(3);
  const std::array<int, 3> t{cube.triangles(4, 0), cube.triangles(4, 1), cube.triangles(4, 2)};
  for (const auto& more : std::vector<std::vector<std::array<int, 3>>>{
           {{t[0], t[0], t[1]}, {t[2], t[2], t[2]}},  // repeated
           {t},                                       // doubled
           {{t[1], t[2], t[0]}, {t[2], t[0], t[1]}},  // tripled, begun elsewhere
           {{t[0], t[2], t[1]}, t}}) {                // of three, two agree
    const MendedMesh result = mended(with_triangles(cube, more));
    expect_closed(result.mesh, 1, "further triangles");
    EXPECT_EQ(result.mesh.n_triangles(), cube.n_triangles());
    EXPECT_EQ(result.report.repeated + result.report.doubled, static_cast<Eigen::Index>(more.size()));
  }
  // Everything once more with vertices of its own, then also looking inward.
  expect_closed(mended(beside(cube, cube)).mesh, 1, "twice");
  TriangleMesh inward = cube;
  inward.triangles.col(1).swap(inward.triangles.col(2));
  expect_closed(mended(with_triangles(cube, {{t[0], t[2], t[1]}})).mesh, 1, "one two-sided");
  expect_closed(mended(glued(beside(cube, inward))).mesh, 1, "two-sided");
}

// A triangle without area along an edge parts the two beside it; without it they meet in a T.
TEST(MendedMesh, ClosesWhatFlatTrianglesHeldTogether) {
  TriangleMesh mesh = box(2);
  const int n = static_cast<int>(mesh.n_vertices());
  const int a = mesh.triangles(0, 0), b = mesh.triangles(0, 1), c = mesh.triangles(0, 2);
  mesh.positions.conservativeResize(n + 1, 3);
  mesh.positions.row(n) = (mesh.positions.row(a) + mesh.positions.row(b)) / 2;
  mesh.triangles.row(0) << a, n, c;
  mesh = with_triangles(mesh, {{n, b, c}, {a, b, n}});
  ASSERT_TRUE(mesh_topology(mesh.triangles, mesh.n_vertices()).is_watertight());
  const MendedMesh result = mended(mesh);
  expect_closed(result.mesh, 1, "cap");
  EXPECT_EQ(result.report.degenerate, 1);
  EXPECT_EQ(result.report.junctions, 1);
}

TEST(MendedMesh, JoinsTJunctionsInChains) {
  const TriangleMesh cube = box(3);
  for (const int n : {1, 2, 7})
    for (const bool as_soup : {false, true}) {
      TriangleMesh mesh = cube;
      std::vector<std::array<int, 3>> more;
      Eigen::Index inserted = 0;
      for (Eigen::Index f = 0; f < cube.n_triangles(); f += 5) {
        const int a = cube.triangles(f, 0), b = cube.triangles(f, 1), c = cube.triangles(f, 2);
        int last = a;
        for (int k = 1; k <= n; ++k, ++inserted) {
          const auto v = static_cast<int>(mesh.n_vertices());
          mesh.positions.conservativeResize(v + 1, 3);
          const double t = k / (n + 1.0);
          mesh.positions.row(v) = (1 - t) * cube.positions.row(a) + t * cube.positions.row(b);
          more.push_back({last, v, c});
          last = v;
        }
        mesh.triangles.row(f) << last, b, c;
      }
      mesh = with_triangles(mesh, more);
      const MendedMesh result = mended(as_soup ? soup_of(mesh) : mesh);
      expect_closed(result.mesh, 1, concat("chains of ", n));
      EXPECT_EQ(result.mesh.n_vertices(), cube.n_vertices() + inserted);
    }
}

TEST(MendedMesh, KeepsBodiesApartThatShareAnEdgeOrAVertex) {
  const TriangleMesh one = box(3);
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, 1, 1)})
    for (const bool mixed : {false, true}) {
      TriangleMesh both = glued(beside(one, box(3, shift)));
      if (mixed) both = turned_at_random(both);
      const MendedMesh result = mended(both);
      expect_closed(result.mesh, 2, concat("shift ", shift.transpose()));
      EXPECT_EQ(mesh_topology(result.mesh.triangles, result.mesh.n_vertices()).n_components, 2);
    }
}

// The wall between two bodies, once in each of them, goes; what is left is one body.
TEST(MendedMesh, JoinsBodiesThatShareAFace) {
  const TriangleMesh both = beside(box(3), box(3, {1, 0, 0}));
  for (const TriangleMesh& mesh : {both, glued(both)}) {
    const MendedMesh result = mended(mesh);
    expect_closed(result.mesh, 2, "shared face");
    EXPECT_EQ(mesh_topology(result.mesh.triangles, result.mesh.n_vertices()).n_components, 1);
    EXPECT_EQ(result.report.doubled, 2 * 18);
  }
}

TEST(MendedMesh, SeparatesSheetsAtAnEdge) {
  TriangleMesh book;
  book.positions.resize(5, 3);
  book.positions << 0, 0, 0, 0, 0, 1, 1, 0, 0, -1, 0.1, 0, 0, 1, 0;
  book.triangles.resize(3, 3);
  book.triangles << 0, 1, 2, 0, 1, 3, 0, 1, 4;
  const MendedMesh result = mended(book);
  expect_sound(result.mesh, "book");
  EXPECT_EQ(result.report.branching, 1);
  EXPECT_EQ(result.report.split_vertices, 2);
  // The two that go on straightest stay together.
  const MeshTopology topology = mesh_topology(result.mesh.triangles, result.mesh.n_vertices());
  EXPECT_EQ(topology.n_components, 2);
}

// Two sheets that pass one edge and meet again at both of its ends: no splitting of vertices parts them.
TEST(MendedMesh, SeparatesSheetsThatShareBothEndsOfAnEdge) {
  // A torus pinched so that one edge along it is passed twice: a box ring whose hole is that edge.
  TriangleMesh mesh = beside(beside(box(2), box(2, {1, 1, 0})), beside(box(2, {0, 1, 1}), box(2, {1, 0, 1})));
  const MendedMesh result = mended(turned_at_random(glued(mesh)));
  expect_closed(result.mesh, 4, "checkerboard of cubes");
}

TEST(MendedMesh, CutsOneSidedBandsOpen) {
  for (const int half_turns : {1, 3}) {
    const TriangleMesh given = turned_at_random(band(40, half_turns));
    const MendedMesh result = mended(given);
    expect_sound(result.mesh, "band");
    EXPECT_EQ(result.report.cut, 1);  // across the band, two vertices wide
    EXPECT_EQ(result.mesh.n_vertices(), given.n_vertices() + 2);
    EXPECT_EQ(result.mesh.n_triangles(), given.n_triangles());
  }
}

// Whatever triangles there are over few vertices: edges with ten of them, pinches, folds, repetitions.
TEST(MendedMesh, IsManifoldForAnyTriangles) {
  std::mt19937 random(7);
  int n_branching = 0;
  for (int round = 0; round < 200; ++round) {
    TriangleMesh mesh;
    const auto n = static_cast<int>(4 + random() % 9);
    mesh.positions.resize(n, 3);
    for (int v = 0; v < n; ++v)
      for (int k = 0; k < 3; ++k)
        mesh.positions(v, k) =
            round % 2 == 0 ? static_cast<double>(random() % 3) : static_cast<double>(random()) * 1e-9;
    mesh.triangles.resize(static_cast<Eigen::Index>(2 + random() % 50), 3);
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k)
        mesh.triangles(f, k) = static_cast<int>(random() % static_cast<unsigned>(n));
    const MendedMesh result = mended(mesh);
    n_branching += result.report.branching > 0;
    expect_sound(result.mesh, concat("round ", round));
  }
  EXPECT_GT(n_branching, 100);
}

TEST(MendedMesh, CarriesNormalsAndValues) {
  TriangleMesh soup = soup_of(box(2));
  soup.vertex_values["x"] = soup.positions.col(0);
  soup.normals = soup.positions.rowwise().normalized();
  soup.normals.row(0) << 0, 0, 1;
  const MendedMesh result = mended(soup);
  ASSERT_EQ(result.mesh.normals.rows(), result.mesh.n_vertices());
  EXPECT_EQ(result.mesh.vertex_values.at("x"), Eigen::VectorXd(result.mesh.positions.col(0)));
}

TEST(MendedMesh, RefusesWhatCannotBeGuessedWithThePlace) {
  TriangleMesh mesh = box(2);
  mesh.triangles(7, 1) = 1000;
  try {
    mended(mesh);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("triangle 7 names vertex 1000"), std::string::npos);
  }
  mesh = box(2);
  mesh.positions(5, 2) = std::numeric_limits<double>::quiet_NaN();
  try {
    mended(mesh);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 5"), std::string::npos);
  }
  MendingOptions options;
  options.tolerance = -1;
  EXPECT_THROW(mended_mesh(box(1), options), InvalidInput);
  EXPECT_THROW(mended_mesh(box(1), {}, Progress([](std::string_view, double) { return false; })), Cancelled);
}

}  // namespace
}  // namespace batten
