#include "batten/subdivision/subdivide.hpp"

#include "subdivision/cages.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;

TEST(Subdivide, RefusesBadCagesInWords) {
  const auto message = [](const ControlCage& cage, const SubdivisionOptions& options = {}) {
    try {
      subdivide(cage, options);
    } catch (const InvalidInput& problem) {
      return std::string(problem.what());
    }
    return std::string("accepted");
  };
  const auto mentions = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(mentions(message({}), "no faces"));
  ControlCage cage = cages::cube();
  cage.mesh.corners[5] = 8;
  EXPECT_TRUE(mentions(message(cage), "face 1 names vertex 8"));
  cage.mesh.corners[5] = 4;
  EXPECT_TRUE(mentions(message(cage), "face 1 names vertex 4 twice"));
  cage = cages::cube();
  std::reverse(cage.mesh.corners.begin() + 4, cage.mesh.corners.begin() + 8);
  EXPECT_TRUE(mentions(message(cage), "turn one of them around"));
  cage = cages::cube();
  cages::add_face(cage.mesh, {0, 1, 6});
  EXPECT_TRUE(mentions(message(cage), "belongs to 3 faces")) << message(cage);
  cage = cages::cube();
  cage.mesh.positions(3, 1) = std::nan("");
  EXPECT_TRUE(mentions(message(cage), "vertex 3"));
  cage = cages::cube();
  cage.mesh.positions.conservativeResize(9, 3);
  cage.mesh.positions.row(8) << 5, 5, 5;
  EXPECT_TRUE(mentions(message(cage), "vertex 8 belongs to no face"));
  cages::add_face(cage.mesh, {8, 0});
  EXPECT_TRUE(mentions(message(cage), "face 6 has 2 corners"));
  cage = cages::grid(3, 3, [](int i, int j) { return Row(i, j, 0); });
  cage.mesh.corners = {0, 1, 4, 3, 4, 5, 8, 7};  // two faces that touch at vertex 4
  cage.mesh.offsets = {0, 4, 8};
  cage.mesh.positions.row(2) = cage.mesh.positions.row(0);
  ControlCage bow_tie;
  bow_tie.mesh.positions = Points::Random(7, 3);
  cages::add_face(bow_tie.mesh, {0, 1, 2, 3});
  cages::add_face(bow_tie.mesh, {0, 4, 5, 6});
  EXPECT_TRUE(mentions(message(bow_tie), "around vertex 0 do not form one fan"));
  cage = cages::cube();
  cage.sharp_edges = {{0, 6, 1}};
  EXPECT_TRUE(mentions(message(cage), "between vertices 0 and 6 is no edge"));
  cage.sharp_edges = {{0, 1, -1}};
  EXPECT_TRUE(mentions(message(cage), "must be 0 or more"));
  EXPECT_TRUE(mentions(message(cages::cube(), {.levels = 13}), "levels must be 0 to 12"));
  EXPECT_TRUE(mentions(message(cages::torus(100, 100), {.levels = 8}), "fewer levels"));
}

// Moving the vertices of a kept cage is subdividing the moved cage, bit for bit.
TEST(Subdivide, MovesAKeptCageAsIfItWereNew) {
  for (const SubdivisionScheme scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Nuliss}) {
    ControlCage cage = cages::cube_with_sharp_edges();
    const SubdivisionOptions options{.scheme = scheme, .levels = 2, .limit = true};
    Subdivision kept(cage, options);
    const Points before = kept.surface().cage.mesh.positions;
    cage.mesh.positions.row(6) << 2, 3, 4;
    kept.move(cage.mesh.positions);
    const SubdividedSurface fresh = subdivide(cage, options);
    EXPECT_EQ(kept.surface().cage.mesh.positions, fresh.cage.mesh.positions);
    EXPECT_EQ(kept.surface().limit_positions, fresh.limit_positions);
    EXPECT_EQ(kept.surface().limit_normals, fresh.limit_normals);
    EXPECT_EQ(kept.surface().cage.mesh.corners, fresh.cage.mesh.corners);
    EXPECT_NE(kept.surface().cage.mesh.positions, before);
    Points bad = cage.mesh.positions;
    bad(3, 0) = std::nan("");
    EXPECT_THROW(kept.move(bad), InvalidInput);
    EXPECT_THROW(kept.move(Points::Zero(7, 3)), InvalidInput);
    EXPECT_EQ(kept.surface().cage.mesh.positions, fresh.cage.mesh.positions);
  }
}

TEST(Subdivide, CanBeCancelled) {
  const Progress stop([](std::string_view, double) { return false; });
  for (const SubdivisionScheme scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Nuliss})
    EXPECT_THROW(subdivide(cages::cube(), {.scheme = scheme}, stop), Cancelled);
}

}  // namespace
}  // namespace batten
