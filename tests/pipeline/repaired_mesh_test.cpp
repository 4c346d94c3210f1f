#include "batten/pipeline/repaired_mesh.hpp"

#include "mesh/broken_shapes.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"

namespace batten {
namespace {

using fixtures::beside;
using fixtures::box;
using fixtures::soup_of;
using fixtures::turned_at_random;

/// A cube with faults of several kinds: triangles turned at random, a doubled face, a hole, unused vertices.
TriangleMesh broken_cube() {
  TriangleMesh mesh = box(4);
  const Eigen::Index n = mesh.n_vertices(), m = mesh.n_triangles();
  mesh.triangles.row(0) = mesh.triangles.row(m - 1).eval();  // a hole there, a doubled face here
  mesh.positions.conservativeResize(n + 2, 3);
  mesh.positions.row(n) << 0.3, 0.3, 1.5;  // unused
  mesh.positions.row(n + 1) << 7, 7, 7;
  return turned_at_random(mesh);
}

TEST(RepairedMesh, IsSoundAndSaysWhatWasDone) {
  RepairedMeshOptions options;
  options.fill_holes = 10;
  const RepairedMesh repaired = repaired_mesh(broken_cube(), options);
  EXPECT_TRUE(repaired.flaws.empty());
  EXPECT_TRUE(repaired.topology.is_watertight());
  ASSERT_TRUE(repaired.volume.has_value());
  EXPECT_NEAR(*repaired.volume, 1, 1e-12);
  EXPECT_EQ(repaired.mended.doubled, 1);
  EXPECT_EQ(repaired.mended.unused, 2);
  EXPECT_EQ(repaired.n_filled(), 1);
  const auto tells = [&](const std::string& words) {
    return std::any_of(repaired.done.begin(), repaired.done.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(tells("turned over"));
  EXPECT_TRUE(tells("lay on an equal one"));
  EXPECT_TRUE(tells("1 hole filled fairly"));
}

TEST(RepairedMesh, IsTheSameForAnyNumberOfThreads) {
  set_thread_count(1);
  const RepairedMesh one = repaired_mesh(broken_cube(), {});
  set_thread_count(4);
  const RepairedMesh four = repaired_mesh(broken_cube(), {});
  set_thread_count(0);
  EXPECT_EQ(one.mesh.positions, four.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, four.mesh.triangles);
}

TEST(RepairedMesh, NamesCrossingsAsFlaws) {
  const RepairedMesh repaired = repaired_mesh(beside(box(2), box(2, {0.5, 0.4, 0.3})), {});
  ASSERT_EQ(repaired.flaws.size(), 1u);
  EXPECT_NE(repaired.flaws[0].find("cross"), std::string::npos);
  EXPECT_NE(repaired.flaws[0].find(" at ("), std::string::npos);
  EXPECT_FALSE(repaired.crossings.empty());
}

TEST(RepairedMesh, ListsHolesThatItWasNotAskedToFill) {
  const RepairedMesh repaired = repaired_mesh(broken_cube(), {});
  ASSERT_EQ(repaired.holes.size(), 1u);
  EXPECT_EQ(repaired.holes[0].rim.size(), 3u);
  EXPECT_FALSE(repaired.holes[0].filled);
  EXPECT_FALSE(repaired.volume.has_value());
  EXPECT_TRUE(repaired.flaws.empty());  // a border is no flaw
}

// Relative to the diameter, in the unit of the mesh, or not at all.
TEST(RepairedMesh, WeldsAsFarAsItIsTold) {
  const TriangleMesh soup = soup_of(box(2), 1e-3);
  RepairedMeshOptions options;
  EXPECT_GT(repaired_mesh(soup, options).holes.size(),
            1u);  // a thousandth is too much to be taken for a seam
  options.weld_length = Length{0.01, Length::Kind::Plain};
  EXPECT_TRUE(repaired_mesh(soup, options).topology.is_watertight());
  options.weld_length = Length{0.01, Length::Kind::Relative};
  EXPECT_TRUE(repaired_mesh(soup, options).topology.is_watertight());
  options.weld_length.reset();
  options.weld = false;
  EXPECT_EQ(repaired_mesh(soup_of(box(2)), options).topology.n_components, box(2).n_triangles());
}

TEST(RepairedMesh, RefusesBadOptionsAndCancels) {
  RepairedMeshOptions options;
  options.fill_holes = 2;
  EXPECT_THROW(repaired_mesh(box(1), options), InvalidInput);
  options = {};
  options.weld_length = Length{-1, Length::Kind::Plain};
  EXPECT_THROW(repaired_mesh(box(1), options), InvalidInput);
  EXPECT_THROW(repaired_mesh({}), InvalidInput);
  EXPECT_THROW(repaired_mesh(box(1), {}, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

TEST(WeldSoup, WeldsSoupsAndNothingElse) {
  TriangleMesh soup = soup_of(box(3));
  soup.vertex_values["x"] = soup.positions.col(0);
  const auto note = weld_soup(soup);
  ASSERT_TRUE(note.has_value());
  EXPECT_EQ(soup.n_vertices(), box(3).n_vertices());
  EXPECT_EQ(soup.vertex_values.at("x"), Eigen::VectorXd(soup.positions.col(0)));
  EXPECT_TRUE(mesh_topology(soup.triangles, soup.n_vertices()).is_watertight());
  TriangleMesh cubes = beside(box(1), box(1));
  EXPECT_FALSE(weld_soup(cubes).has_value());
  EXPECT_EQ(cubes.n_vertices(), 16);
}

}  // namespace
}  // namespace batten
