#include "batten/io/cage_io.hpp"

#include "io/bad_files.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten {
namespace {

using namespace test;

/// Two quads and a pentagon with a semi-sharp crease, a corner, a polyline along two edges, a point that
/// nothing uses (vertex 4 of the file) and two that only the polyline uses (9 and 10).
const char* const kObj = R"(# a cage
v 0 0 0
v 1 0 0
v 2 0 0
v 0 1 0
v 9 9 9
v 1 1 0
v 2 1 0
v 1.5 2 0
v 0.5 2 0
v 0.5 0 0.25
v 1.5 0 0.25
f 1 2 6 4
f 2 3 7 6
f 4 6 7 8 9
l 1 10 2 11 3
t crease 3/2/0 0 1 5 2.5 10
t corner 1/1/0 3 3
t interpolateboundary 1/0/0 2
)";

std::string cage_error(const std::string& content) {
  try {
    parse_cage(content, "cage.obj");
  } catch (const FileError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CageIo, ReadsPolygonsWhatIsSharpAndPolylines) {
  std::vector<std::string> warnings;
  const ControlCage cage = parse_cage(kObj, "cage.obj", &warnings);
  EXPECT_EQ(cage.mesh.positions.rows(), 8);
  EXPECT_EQ(cage.mesh.offsets, (std::vector<int>{0, 4, 8, 13}));
  EXPECT_EQ(cage.mesh.corners, (std::vector<int>{0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 5, 6, 7}));
  ASSERT_EQ(cage.sharp_edges.size(), 2u);
  EXPECT_EQ(cage.sharp_edges[0].from, 0);
  EXPECT_EQ(cage.sharp_edges[0].to, 1);
  EXPECT_EQ(cage.sharp_edges[0].sharpness, 2.5);
  EXPECT_EQ(cage.sharp_edges[1].from, 1);
  EXPECT_EQ(cage.sharp_edges[1].to, 4);  // 5 in the file
  EXPECT_EQ(cage.sharp_edges[1].sharpness, 10);
  ASSERT_EQ(cage.sharp_vertices.size(), 1u);
  EXPECT_EQ(cage.sharp_vertices[0].vertex, 3);
  ASSERT_EQ(cage.polylines.size(), 2u) << "cut at the vertex of faces in its middle";
  EXPECT_EQ(cage.polylines[1].from, 1);
  EXPECT_EQ(cage.polylines[1].to, 2);
  ASSERT_EQ(cage.polylines[1].points.rows(), 3);
  EXPECT_EQ(cage.polylines[1].points(1, 2), 0.25);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("1 subdivision tags other than"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("1 vertices that no face uses"), std::string::npos) << warnings[1];
}

TEST(CageIo, WritesObjThatReadsBackTheSame) {
  const ControlCage cage = parse_cage(kObj, "cage.obj");
  std::vector<std::string> warnings;
  const ControlCage back = parse_cage(format_cage(cage, "back.obj"), "back.obj", &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(back.mesh.positions, cage.mesh.positions);
  EXPECT_EQ(back.mesh.corners, cage.mesh.corners);
  EXPECT_EQ(back.mesh.offsets, cage.mesh.offsets);
  ASSERT_EQ(back.sharp_edges.size(), 2u);
  EXPECT_EQ(back.sharp_edges[0].sharpness, 2.5);
  EXPECT_EQ(back.sharp_vertices.size(), 1u);
  ASSERT_EQ(back.polylines.size(), 2u);
  EXPECT_EQ(back.polylines[0].points, cage.polylines[0].points);
}

TEST(CageIo, WritesPlyAndOffWithoutSplittingFaces) {
  const ControlCage cage = parse_cage(kObj, "cage.obj");
  Points normals = Points::Zero(8, 3);
  normals.col(2).setOnes();
  for (const char* path : {"cage.ply", "cage.off"}) {
    for (const Points& with : {Points(0, 3), normals}) {
      const std::string text = format_cage(cage, path, with);
      const ControlCage back = parse_cage(text, path);
      EXPECT_EQ(back.mesh.positions, cage.mesh.positions) << path;
      EXPECT_EQ(back.mesh.corners, cage.mesh.corners) << path;
      EXPECT_EQ(back.mesh.offsets, cage.mesh.offsets) << path;
      // The readers of triangle meshes read the same file.
      const TriangleMesh triangles = parse_mesh(text, path);
      EXPECT_EQ(triangles.n_triangles(), 7) << path;
      EXPECT_EQ(triangles.normals.rows(), with.rows()) << path;
    }
  }
  EXPECT_THROW(format_cage(cage, "cage.stl"), FileError);
  EXPECT_THROW(format_cage(cage, "cage.ply", Points(3, 3)), InvalidInput);
}

// The number of corners of a PLY face is a byte where all fit into one, else more: 255 and 256 corners.
TEST(CageIo, PlyHoldsFacesOfManyCorners) {
  for (const int n : {255, 256}) {
    ControlCage cage;
    cage.mesh.positions.resize(n, 3);
    for (int k = 0; k < n; ++k) {
      cage.mesh.positions.row(k) << std::cos(2 * kPi * k / n), std::sin(2 * kPi * k / n), 0;
      cage.mesh.corners.push_back(k);
    }
    cage.mesh.offsets = {0, n};
    const ControlCage back = parse_cage(format_cage(cage, "disc.ply"), "disc.ply");
    EXPECT_EQ(back.mesh.corners, cage.mesh.corners) << n;
    EXPECT_EQ(back.mesh.offsets, cage.mesh.offsets) << n;
  }
}

TEST(CageIo, NamesTheLineOfABadTag) {
  EXPECT_NE(cage_error(replaced(kObj, "3/2/0", "4/2/0")).find(":17: the tag announces"), std::string::npos)
      << cage_error(replaced(kObj, "3/2/0", "4/2/0"));
  EXPECT_NE(cage_error(replaced(kObj, " 0 1 5 2.5", " 0 1 6 2.5"))
                .find("no face has an edge between vertices 1 and 6"),
            std::string::npos);
  EXPECT_NE(cage_error(replaced(kObj, " 0 1 5 2.5", " 0 1 99 2.5")).find("vertex 99 of a tag"),
            std::string::npos);
  EXPECT_NE(cage_error(replaced(kObj, "2.5 10", "-1 10")).find("no number of 0 or more"), std::string::npos);
  EXPECT_NE(cage_error(replaced(kObj, "2.5 10", "nan 10")).find("no number of 0 or more"), std::string::npos);
  EXPECT_NE(cage_error(replaced(kObj, "1/1/0 3 3", "")).find("counts of a tag are missing"),
            std::string::npos);
  EXPECT_NE(cage_error("v 0 0 0\nv 1 0 0\nl 1 2\n").find("curve network"), std::string::npos);
  EXPECT_NE(cage_error("v 0 0 0\n").find("holds no faces"), std::string::npos);
}

TEST(CageIo, LeavesOutPolylinesThatFollowNoEdge) {
  std::vector<std::string> warnings;
  const ControlCage cage = parse_cage(replaced(kObj, "l 1 10 2 11 3", "l 1 10 6"), "cage.obj", &warnings);
  EXPECT_TRUE(cage.polylines.empty());
  ASSERT_FALSE(warnings.empty());
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("1 pieces of polylines") != std::string::npos &&
           warning.find("line 16") != std::string::npos;
  }));
}

// Triangle meshes are read as before; what they cannot hold is told.
TEST(CageIo, TagsAndPolylinesAreToldOfWhenAMeshIsRead) {
  std::vector<std::string> warnings;
  EXPECT_EQ(parse_mesh(kObj, "cage.obj", &warnings).n_triangles(), 7);
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("3 subdivision tags") != std::string::npos;
  }));
}

}  // namespace
}  // namespace batten
